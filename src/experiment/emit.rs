//! Scripts that make all runs of an experiment on a cluster, and then the report.
//!
//! Each job makes a shard, every N-th run. All shards write to one folder, which is safe even if two of them overlap.

use super::jobs::{Cluster, End, Work};
use super::plan::Plan;

/// How the program is called.
pub struct Command {
    /// Its name or path.
    pub program: String,
    /// The file and the options of `experiment run`.
    pub run: Vec<String>,
    /// The folder that `experiment report` reads.
    pub report: String,
}

/// The script for the runs of a plan, with at most one job for each.
pub fn emit(cluster: Cluster, plan: &Plan<'_>, command: &Command, jobs: Option<usize>) -> String {
    let Command { program, run, report } = command;
    let words = |verb: &str, rest: &[String]| -> Vec<String> {
        let words = [program.as_str(), "experiment", verb].into_iter().map(str::to_owned);
        words.chain(rest.iter().cloned()).collect()
    };
    let work = Work {
        title: format!("All runs of the experiment {}", plan.spec.name),
        name: plan.spec.name.clone(),
        parts: plan.runs.len(),
        command: words("run", run),
        behind: Vec::new(),
        end: Some(End {
            name: "report",
            command: words("report", std::slice::from_ref(report)),
            file: "report.html",
        }),
        folder: report.clone(),
        threads: plan.runs.iter().filter_map(|run| run.solver.threads).max(),
    };
    work.script(cluster, jobs)
}
