//! The runs behind the numbers of a figure or a table.

use std::path::Path;

use serde::Deserialize;

use super::super::quoting::{operand, shell};
use super::super::results::Done;
use crate::error::{Error, Result};
use crate::file;

/// One run behind a figure.
pub struct Why {
    /// The name of its folder in `runs/`.
    pub id: String,
    /// The label of the instance.
    pub instance: String,
    /// The label of the solver.
    pub solver: String,
    /// Which repetition it is, from 0.
    pub repetition: u64,
    /// The commit of the program that made the run, or `unknown`.
    pub commit: String,
    /// Whether its sources had changes that were not committed.
    pub dirty: bool,
    /// The command that makes the run again.
    pub command: String,
}

#[derive(Deserialize)]
struct Sources {
    runs: Vec<String>,
}

/// The runs behind `results/NAME/figures/X.svg`, or any other file of that stem.
///
/// # Errors
/// The file is not part of a report, or a run no longer exists.
pub fn why(path: &Path) -> Result<Vec<Why>> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.strip_suffix(".runs").unwrap_or(&stem);
    let sources = path.with_file_name(format!("{stem}.runs.json"));
    if !sources.is_file() {
        return Err(Error::malformed(
            path,
            "is not a figure or table of a report: there is no .runs.json next to it",
        ));
    }
    let parsed: Sources = serde_json::from_slice(&file::read(&sources)?)
        .map_err(|error| Error::malformed(&sources, error.to_string()))?;
    let folder = path.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    let file = |folder: &Path| shell(&operand(&folder.join("spec.toml").display().to_string()));
    let run = |id: String| {
        let folder = folder.join("runs").join(&id);
        let run = Done::read(&folder)?;
        let manifest = run.manifest;
        Ok(Why {
            command: format!("meshseg experiment run {}", file(&folder)),
            id,
            instance: manifest.instance,
            solver: manifest.solver,
            repetition: manifest.repetition,
            commit: manifest.program.commit,
            dirty: manifest.program.dirty,
        })
    };
    parsed.runs.into_iter().map(run).collect()
}
