//! Scripts for clusters: work that is divided among jobs, each of which takes every N-th part.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::quoting::{braces, one_line, plain, python, shell};

/// The system that runs the jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Cluster {
    /// An array job for `sbatch`; its first task submits the job that ends the work.
    Slurm,
    /// A Snakefile with a rule for the shards and one for the end.
    Snakemake,
}

/// The maximum number of jobs, unless another is requested.
const DEFAULT_MAX_JOBS: usize = 100;

/// Work of `COMMAND --shard I/N BEHIND`. Words are quoted here.
pub struct Work {
    /// What it makes, such as "All runs of the experiment waves".
    pub title: String,
    /// The name of the jobs.
    pub name: String,
    /// Number of parts.
    pub parts: usize,
    /// The words of the command.
    pub command: Vec<String>,
    /// Words behind the shard.
    pub behind: Vec<String>,
    /// What is made when all parts are.
    pub end: Option<End>,
    /// The folder in which Snakemake marks the shards that are made.
    pub folder: String,
    /// Threads of a job; all cores if `None`.
    pub threads: Option<usize>,
}

/// The end of the work.
pub struct End {
    /// Its name, such as report.
    pub name: &'static str,
    /// The words of its command.
    pub command: Vec<String>,
    /// The file in the folder that it makes.
    pub file: &'static str,
}

impl Work {
    /// The script for a number of jobs, at most one for each part.
    pub fn script(&self, cluster: Cluster, jobs: Option<usize>) -> String {
        let jobs = jobs.unwrap_or(DEFAULT_MAX_JOBS).clamp(1, self.parts.max(1));
        match cluster {
            Cluster::Slurm => self.slurm(jobs),
            Cluster::Snakemake => self.snakemake(jobs),
        }
    }

    fn slurm(&self, jobs: usize) -> String {
        let cpus = self.threads.map_or(String::new(), |n| format!("#SBATCH --cpus-per-task={n}\n"));
        let (title, name) = (one_line(&self.title), plain(&self.name));
        let (then, end) = match &self.end {
            None => (String::new(), String::new()),
            Some(End { name: end, command, .. }) => (
                format!(", and then the {end}"),
                format!(
                    "if [ \"$SLURM_ARRAY_TASK_ID\" = 1 ]; then\n\
                     \x20   sbatch --dependency=\"afterok:$SLURM_ARRAY_JOB_ID\" --job-name=meshseg-{name}-{end} \\\n\
                     \x20       --wrap={}\n\
                     fi\n",
                    shell(&line(command, shell))
                ),
            ),
        };
        let behind: String = self.behind.iter().map(|word| format!(" {}", shell(word))).collect();
        format!(
            "#!/usr/bin/env bash\n\
             # {title} in {jobs} jobs{then}: sbatch THIS_FILE\n\
             #SBATCH --job-name=meshseg-{name}\n\
             #SBATCH --array=1-{jobs}\n\
             #SBATCH --exclusive\n\
             {cpus}\
             set -euo pipefail\n\
             {end}\
             {} --shard \"$SLURM_ARRAY_TASK_ID/{jobs}\"{behind}\n",
            line(&self.command, shell)
        )
    }

    fn snakemake(&self, jobs: usize) -> String {
        let quoted = |word: &str| braces(&shell(word));
        let threads = self.threads.map_or("workflow.cores".to_owned(), |n| n.to_string());
        let behind: String = self.behind.iter().map(|word| format!(" {}", quoted(word))).collect();
        let command = line(&self.command, quoted);
        let run = python(&format!("{command} --shard {{wildcards.i}}/{jobs}{behind}"));
        // Braces in file names cannot be quoted; then marker files with other names stand for the results.
        let folder = match self.folder.contains(['{', '}']) {
            true => plain(&self.folder) + "-made",
            false => self.folder.clone(),
        };
        let done = python(&format!("{folder}/shards/{{i}}-of-{jobs}"));
        let title = one_line(&self.title);
        let (then, rule, made) = match &self.end {
            None => (String::new(), "all", String::new()),
            Some(End { name, command, file }) => {
                let page = match folder == self.folder {
                    true => python(&format!("{folder}/{file}")),
                    false => format!("touch({})", python(&format!("{folder}/{name}"))),
                };
                let command = python(&line(command, quoted));
                let made = format!("\x20   output: {page}\n\x20   shell: {command}\n");
                (format!(", and then the {name}"), *name, made)
            }
        };
        format!(
            "# {title} in {jobs} jobs{then}: snakemake --cores 1 -s THIS_FILE\n\
             rule {rule}:\n\
             \x20   input: expand({done}, i=range(1, {jobs} + 1))\n\
             {made}\
             \n\
             rule shard:\n\
             \x20   output: touch({done})\n\
             \x20   threads: {threads}\n\
             \x20   shell: {run}\n"
        )
    }
}

/// Words on a line.
fn line(words: &[String], quoted: impl Fn(&str) -> String) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}
