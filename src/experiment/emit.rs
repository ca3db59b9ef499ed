//! Scripts that make all runs of an experiment on a cluster, and then the report.
//!
//! Each job makes a shard, every N-th run. All shards write to one folder, which is safe even if two of them overlap.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::plan::Plan;
use super::quoting::{braces, one_line, plain, python, shell};

/// The system that runs the jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Cluster {
    /// An array job for `sbatch`; its first task submits the job that makes the report.
    Slurm,
    /// A Snakefile with a rule for the shards and one for the report.
    Snakemake,
}

/// The maximum number of jobs, unless another is requested.
const DEFAULT_MAX_JOBS: usize = 100;

/// The script for the runs of a plan, with at most one job for each.
pub fn emit(cluster: Cluster, plan: &Plan<'_>, command: &Command, jobs: Option<usize>) -> String {
    let jobs = jobs.unwrap_or(DEFAULT_MAX_JOBS).clamp(1, plan.runs.len().max(1));
    let threads = plan.runs.iter().filter_map(|run| run.solver.threads).max();
    match cluster {
        Cluster::Slurm => slurm(&plan.spec.name, command, jobs, threads),
        Cluster::Snakemake => snakemake(&plan.spec.name, command, jobs, threads),
    }
}

/// How the program is called.
pub struct Command {
    /// Its name or path.
    pub program: String,
    /// The file and the options of `experiment run`.
    pub run: Vec<String>,
    /// The folder that `experiment report` reads.
    pub report: String,
}

fn slurm(name: &str, command: &Command, jobs: usize, threads: Option<usize>) -> String {
    let Command { program, run, report } = command;
    let run: Vec<String> = run.iter().map(|word| shell(word)).collect();
    let (program, run, report) = (shell(program), run.join(" "), shell(report));
    let cpus = threads.map_or(String::new(), |n| format!("#SBATCH --cpus-per-task={n}\n"));
    let (title, name) = (one_line(name), plain(name));
    format!(
        "#!/usr/bin/env bash\n\
         # All runs of the experiment {title} in {jobs} jobs, and then the report: sbatch THIS_FILE\n\
         #SBATCH --job-name=meshseg-{name}\n\
         #SBATCH --array=1-{jobs}\n\
         #SBATCH --exclusive\n\
         {cpus}\
         set -euo pipefail\n\
         if [ \"$SLURM_ARRAY_TASK_ID\" = 1 ]; then\n\
         \x20   sbatch --dependency=\"afterok:$SLURM_ARRAY_JOB_ID\" --job-name=meshseg-{name}-report \\\n\
         \x20       --wrap={wrap}\n\
         fi\n\
         {program} experiment run {run} --shard \"$SLURM_ARRAY_TASK_ID/{jobs}\"\n",
        wrap = shell(&format!("{program} experiment report {report}")),
    )
}

fn snakemake(name: &str, command: &Command, jobs: usize, threads: Option<usize>) -> String {
    let Command { program, run, report } = command;
    let run: Vec<String> = run.iter().map(|word| braces(&shell(word))).collect();
    let threads = threads.map_or("workflow.cores".to_owned(), |n| n.to_string());
    let run = python(&format!(
        "{} experiment run {} --shard {{wildcards.i}}/{jobs}",
        braces(&shell(program)),
        run.join(" ")
    ));
    let collect = python(&format!(
        "{} experiment report {}",
        braces(&shell(program)),
        braces(&shell(report))
    ));
    // Braces in file names cannot be quoted; then marker files with other names stand for the results.
    let folder = if report.contains(['{', '}']) { plain(report) + "-made" } else { report.clone() };
    let done = python(&format!("{folder}/shards/{{i}}-of-{jobs}"));
    let page = if folder == *report {
        python(&format!("{folder}/report.html"))
    } else {
        format!("touch({})", python(&format!("{folder}/report")))
    };
    let name = one_line(name);
    format!(
        "# All runs of the experiment {name} in {jobs} jobs, and then the report: snakemake --cores 1 -s THIS_FILE\n\
         rule report:\n\
         \x20   input: expand({done}, i=range(1, {jobs} + 1))\n\
         \x20   output: {page}\n\
         \x20   shell: {collect}\n\
         \n\
         rule shard:\n\
         \x20   output: touch({done})\n\
         \x20   threads: {threads}\n\
         \x20   shell: {run}\n"
    )
}
