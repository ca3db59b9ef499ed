//! Exchange with external solvers: problems to solve, and the iterates in return.
//!
//! ```text
//! problem   meshseg problem export  ->  PROBLEM.npz                     (`problem`)
//! solver    COMMAND PROBLEM.npz OUT [--key=value ...]                   external
//! iterates  OUT/trace.csv, u_<iteration>.npy, [q_<iteration>.npy]      (`iterates`)
//! run       E and a true lower bound of every iterate                   (`certify`)
//! ```
//!
//! experiments/reference/README.md lists names and shapes for authors of solvers.

mod certify;
mod iterates;
mod problem;

#[cfg(test)]
mod tests;

pub use certify::{End, certify};
pub use iterates::{Iterate, Iterates};
pub use problem::Exchanged;
