//! `meshseg paper`: a paper that cites results by name.

use std::path::PathBuf;

use crate::counted::counted;
use crate::paper::{self, Checked};

use super::{Error, Outcome, note, print};

/// Papers that cite the results of experiments
#[derive(clap::Subcommand)]
#[command(after_help = EXAMPLES)]
pub enum Verb {
    /// Check that every number, figure and table that a paper cites exists and comes from the runs
    ///
    /// Reads main.tex and the files of the paper that it reads. Results are looked for in the folder results beside that
    /// of the paper. Reported are names that do not exist, results that differ from what the runs give, results of another
    /// experiment file, of several machines or versions, or of a program with uncommitted changes, and measurements that
    /// are typed by hand.
    Check(Check),
}

const EXAMPLES: &str = "\
Examples:
  meshseg paper check
  meshseg paper check other/paper";

#[derive(clap::Args)]
pub struct Check {
    /// Folder of the paper
    #[arg(default_value = "paper")]
    folder: PathBuf,
}

pub fn run(verb: &Verb) -> Outcome {
    let Verb::Check(arguments) = verb;
    let checked = paper::check(&arguments.folder, env!("CARGO_PKG_VERSION"))?;
    for fault in &checked.faults {
        note(fault);
    }
    let Checked { names, figures, tables, experiments, faults } = checked;
    if !faults.is_empty() {
        let count = counted(faults.len(), "fault", "faults");
        return Err(Error::unsuitable(format!(
            "{}: {count}, listed above",
            arguments.folder.display()
        ))
        .into());
    }
    print(&format!(
        "{}, {} and {} of {}, as their runs give them\n",
        counted(names, "name", "names"),
        counted(figures, "figure", "figures"),
        counted(tables, "table", "tables"),
        counted(experiments, "experiment", "experiments")
    ))?;
    Ok(())
}
