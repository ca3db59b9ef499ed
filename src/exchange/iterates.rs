//! What a solver leaves in its folder.
//!
//! ```text
//! trace.csv             iteration,seconds[,epsilon,epsilon_mode], a line for each sample
//! u_<iteration>.npy     V x m, any number of zeros in front of the number
//! q_<iteration>.npy     2F x m, rows as those of K, if the solver has one
//! ```
//!
//! A line counts once it is whole: a solver that is ended in the middle keeps what it wrote before.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::{Error, Result};
use crate::file;
use crate::problem::{Smoothing, SmoothingMode};

/// One line of `trace.csv`, and the files that belong to it.
#[derive(Clone, Debug)]
pub struct Iterate {
    pub iteration: u64,
    /// By the solver's own clock.
    pub seconds: f64,
    /// Of the energy that it minimizes, if that is not the true one.
    pub smoothing: Option<Smoothing>,
    pub u: PathBuf,
    pub q: Option<PathBuf>,
}

#[derive(Clone, Debug)]
pub struct Iterates(pub Vec<Iterate>);

#[derive(Deserialize)]
struct Line {
    iteration: u64,
    seconds: f64,
    #[serde(default)]
    epsilon: Option<f64>,
    #[serde(default)]
    epsilon_mode: Option<String>,
}

impl Iterates {
    /// The iterates of a folder, in the order of their iterations.
    ///
    /// # Errors
    /// A trace that is missing or no CSV, whose iterations or times do not ascend, or that names what is not there.
    pub fn of(folder: &Path) -> Result<Self> {
        let path = folder.join("trace.csv");
        let bytes = file::read(&path)?;
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        let us = numbered(folder, "u_")?;
        let qs = numbered(folder, "q_")?;
        let mut all: Vec<Iterate> = Vec::new();
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&bytes[..whole]);
        for (index, line) in csv.deserialize().enumerate() {
            let wrong = |message: String| Error::malformed_line(&path, index + 2, message);
            let line: Line = line.map_err(|error| wrong(error.to_string()))?;
            if !(line.seconds >= 0.0 && line.seconds <= u32::MAX.into()) {
                return Err(wrong(format!("{} is no time in seconds", line.seconds)));
            }
            if let Some(last) = all.last()
                && !(line.iteration > last.iteration && line.seconds >= last.seconds)
            {
                return Err(wrong("iterations must ascend, and times not descend".into()));
            }
            let smoothing = match line.epsilon {
                None => None,
                Some(epsilon) => {
                    let mode = line.epsilon_mode.as_deref().filter(|mode| !mode.is_empty());
                    let mode = mode.unwrap_or("paper");
                    let named = SmoothingMode::NAMES.iter().find(|(name, _)| *name == mode);
                    let (_, mode) = named.ok_or_else(|| {
                        wrong(format!("epsilon_mode {mode:?}: paper or intrinsic"))
                    })?;
                    Some(Smoothing::new(*mode, epsilon).map_err(|error| wrong(error.to_string()))?)
                }
            };
            let u = us.get(&line.iteration).cloned().ok_or_else(|| {
                wrong(format!("there is no file u_{}.npy beside it", line.iteration))
            })?;
            all.push(Iterate {
                iteration: line.iteration,
                seconds: line.seconds,
                smoothing,
                u,
                q: qs.get(&line.iteration).cloned(),
            });
        }
        Ok(Iterates(all))
    }
}

/// The files `<prefix><number>.npy`, by their numbers.
fn numbered(folder: &Path, prefix: &str) -> Result<BTreeMap<u64, PathBuf>> {
    let io = |error| Error::io(folder, error);
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
        let number = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(".npy"));
        if let Some(number) = number.and_then(|digits| digits.parse().ok()) {
            all.insert(number, path);
        }
    }
    Ok(all)
}
