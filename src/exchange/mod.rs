//! Problems for solvers outside the program, and what they bring back.
//!
//! ```text
//! problem   meshseg problem export  ->  PROBLEM.npz                     (`problem`)
//! solver    COMMAND PROBLEM.npz OUT [--key=value ...]                   anyone's
//! iterates  OUT/trace.csv, u_<iteration>.npy, [q_<iteration>.npy]      (`iterates`)
//! run       E and a true lower bound of every iterate                   (`certify`)
//! ```
//!
//! experiments/reference/README.md has the names and shapes for those who write a solver.

mod certify;
mod iterates;
mod problem;

#[cfg(test)]
mod tests;

pub use certify::{End, certify};
pub use iterates::{Iterate, Iterates};
pub use problem::Exchanged;
