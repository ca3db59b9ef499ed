//! Over-relaxed Chambolle-Pock with local steps, the default:
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )        u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K (2x - u) )  q <- q + rho (y - q)
//! ```
//!
//! A. Chambolle, T. Pock, *A first-order primal-dual algorithm for convex problems with applications to
//! imaging*, J. Math. Imaging Vis. 40, 2011; relaxation: L. Condat, *A primal-dual splitting method for
//! convex optimization*, J. Optim. Theory Appl. 158, 2013. Relaxed iterates are infeasible and poor; the last step
//! before a sample has rho = 1, after which u = x and q = y.
//!
//! `rows` is the reference implementation, for any operator. `fused` computes the same iterates for the stencil,
//! several in one pass over memory. Both share the step lengths (`steps`) and the balancing of their weight omega
//! (`stepping`, `../balance.rs`).

mod engine;
mod fused;
mod rows;
mod settings;
mod stepping;
mod steps;

pub use engine::{Engines, build};
pub use settings::{Engine, Precision, Settings};
pub use steps::Rule;

pub use super::balance::Balancing;
use super::interface::Description;

/// What `meshseg solvers` prints about the method.
pub const DESCRIPTION: Description = Description {
    name: "chambolle-pock",
    summary: "over-relaxed primal-dual method with steps fitted face by face; exact energy, no smoothing",
    reference: "Chambolle, Pock 2011; relaxation: Condat 2013; diagonal steps: Pock, Chambolle 2011",
    steps: "closed form, no power iteration; balanced by the primal and dual moves after 100, 300, 700, ... steps",
};
