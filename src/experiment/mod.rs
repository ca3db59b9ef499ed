//! Reproducible experiments: a file asks one question about instances and solvers, each run is made once and stored,
//! and figures, tables and pages are drawn from the stored runs.
//!
//! `spec` is the file and `plan` its runs; `runner` makes the runs that are missing in the `store`; everything else
//! reads results from disk.

mod choice;
mod document;
mod emit;
mod external;
mod figures;
mod fixed_costs;
mod folders;
mod grid;
mod instance;
mod jobs;
mod labeled;
mod machine;
mod manifest;
mod nearest;
mod numbers;
mod photographs;
mod plan;
mod quoting;
mod reconstructed;
mod report;
mod results;
mod run_files;
mod runner;
mod scene;
mod spec;
mod store;
mod surface_trace;
mod true_labels;
mod variable;

pub use crate::format_error::FormatError;
pub use emit::{Command, emit};
pub use folders::Folders;
pub use jobs::{Cluster, Work};
pub use machine::{Machine, Program};
pub use manifest::Manifest;
pub use nearest::did_you_mean;
pub use numbers::Numbers;
pub use plan::{Plan, Planned};
pub use quoting::{one_line, operand};
pub use report::{Report, Why, report, report_vector, why};
pub use results::{Done, Origin};
pub use runner::{Event, Tally, run};
pub use spec::{InstanceCell, SolverCell, Spec};
pub use store::Store;
