//! What a report has written so far, and the runs behind it.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::super::results::Done;
use super::page::PageFigure;
use crate::error::{Error, Result};
use crate::file;

/// The figures that were written, or kept as they were.
#[derive(Default)]
pub struct WrittenFigures {
    pub paths: Vec<PathBuf>,
    pub shown: Vec<PageFigure>,
    /// Why figures are unchanged or left out, a line each.
    pub kept: Vec<String>,
    /// A figure of the file for which no run has anything to show.
    pub empty: Option<Error>,
}

/// Records the runs behind the numbers of a figure or a table.
///
/// # Errors
/// The file cannot be written.
pub fn write_sources(folder: &Path, stem: &str, runs: &[&Done]) -> Result<()> {
    let ids: Vec<&str> = runs.iter().map(|run| run.manifest.id.as_str()).collect();
    file::write(&folder.join(format!("{stem}.runs.json")), |out| {
        serde_json::to_writer_pretty(&mut *out, &json!({ "runs": ids }))?;
        out.write_all(b"\n")
    })
}
