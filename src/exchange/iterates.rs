//! The files that an external solver writes into its folder.
//!
//! ```text
//! trace.csv             iteration,seconds[,epsilon,epsilon_mode], a line for each sample
//! u_<iteration>.npy     V x m; the number may have leading zeros
//! q_<iteration>.npy     2F x m, rows as in K, if the solver has one
//! ```
//!
//! Two files of one number are refused. Only complete lines count, so that a solver that is killed keeps what it wrote
//! before. The last line needs no line break if its fields are valid and its iterate exists.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use csv::StringRecord;
use serde::{Deserialize, Deserializer};

use crate::error::{Error, Result};
use crate::file;
use crate::names::Named;
use crate::problem::{Smoothing, SmoothingMode};

/// One line of `trace.csv`, and the files that belong to it.
#[derive(Clone, Debug)]
pub struct Iterate {
    /// Its number, as in the names of its files.
    pub iteration: u64,
    /// Time by the clock of the solver, in seconds; does not decrease.
    pub seconds: f64,
    /// The smoothing, if the solver minimizes a smoothed energy.
    pub smoothing: Option<Smoothing>,
    /// The file of U, V x m, not read yet.
    pub u: PathBuf,
    /// The file of the dual field, 2F x m, if there is one; not read yet.
    pub q: Option<PathBuf>,
}

/// The complete iterates, and the error at which reading stopped.
#[derive(Debug, Default)]
pub struct Iterates {
    /// The iterates, by increasing iteration.
    pub all: Vec<Iterate>,
    /// Why the rest was not read, if that is so.
    pub broken: Option<Error>,
}

/// The columns that a trace must have.
const NEEDED_COLUMNS: [&str; 2] = ["iteration", "seconds"];

#[derive(Deserialize)]
struct Line {
    #[serde(deserialize_with = "whole")]
    iteration: u64,
    seconds: f64,
    #[serde(default)]
    epsilon: Option<f64>,
    #[serde(default)]
    epsilon_mode: Option<String>,
}

/// Reads a whole number, also in the form 10.0 that tables of floats have.
fn whole<'a, D: Deserializer<'a>>(field: D) -> std::result::Result<u64, D::Error> {
    let text = String::deserialize(field)?;
    let float = || text.parse().ok().filter(|x: &f64| x.fract() == 0.0 && (0.0..1e15).contains(x));
    let number = text.parse().ok().or_else(|| float().map(|x| x as u64));
    number.ok_or_else(|| {
        serde::de::Error::custom(format!("iteration {text:?} is not a whole number"))
    })
}

impl Iterates {
    /// Reads the iterates of a folder up to the first line of the trace that is not CSV, whose iteration or time is out
    /// of order, or whose files are missing.
    pub fn of(folder: &Path) -> Self {
        let mut iterates = Iterates::default();
        iterates.broken = iterates.read(folder).err();
        iterates
    }

    fn read(&mut self, folder: &Path) -> Result<()> {
        let path = folder.join("trace.csv");
        let bytes = file::read(&path)?;
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        let arrays = Arrays { us: numbered(folder, "u_")?, qs: numbered(folder, "q_")? };
        let mut csv =
            csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(&bytes[..]);
        let malformed = |error: csv::Error| Error::malformed(&path, error.to_string());
        let headers = csv.headers().map_err(malformed)?.clone();
        if whole == 0 {
            return Ok(());
        }
        if let Some(missing) =
            NEEDED_COLUMNS.iter().find(|name| !headers.iter().any(|it| it == **name))
        {
            let line = headers.position().map_or(1, |position| position.line() as usize);
            let message = format!(
                "has no column {missing}; the columns iteration and seconds are needed, epsilon and epsilon_mode are \
                 optional, all separated by commas"
            );
            return Err(Error::malformed_line(&path, line, message));
        }
        for record in csv.records() {
            let record = record.map_err(malformed)?;
            let start = record.position().map_or(0, |position| position.byte() as usize);
            match self.iterate(&path, &headers, &record, &arrays) {
                Ok(iterate) => self.all.push(iterate),
                // The line is incomplete.
                Err(_) if start >= whole => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The iterate of a line of the trace that follows those read so far.
    fn iterate(
        &self,
        path: &Path,
        headers: &StringRecord,
        record: &StringRecord,
        Arrays { us, qs }: &Arrays,
    ) -> Result<Iterate> {
        let number = record.position().map_or(0, |position| position.line() as usize);
        let wrong = |message: String| Error::malformed_line(path, number, message);
        if record.len() != headers.len() {
            return Err(wrong(format!(
                "{} fields, but the header has {}",
                record.len(),
                headers.len()
            )));
        }
        let line: Line = record.deserialize(Some(headers)).map_err(|error| {
            wrong(match error.kind() {
                csv::ErrorKind::Deserialize { err, .. } => {
                    let field = err.field().and_then(|field| usize::try_from(field).ok());
                    match field.and_then(|i| Some((headers.get(i)?, record.get(i)?))) {
                        Some((column, text)) => format!("{column} {text:?} is not a number"),
                        None => err.to_string(),
                    }
                }
                _ => error.to_string(),
            })
        })?;
        if !(line.seconds >= 0.0 && line.seconds <= u32::MAX.into()) {
            return Err(wrong(format!("{} is not a time in seconds", line.seconds)));
        }
        if let Some(last) = self.all.last()
            && !(line.iteration > last.iteration && line.seconds >= last.seconds)
        {
            return Err(wrong("iterations must increase, and times must not decrease".into()));
        }
        // Tables of floats contain NaN for missing values.
        let smoothing = match line.epsilon.filter(|epsilon| !epsilon.is_nan()) {
            None => None,
            Some(epsilon) => {
                let mode = line.epsilon_mode.as_deref().unwrap_or("paper");
                let mode = SmoothingMode::named(mode).ok_or_else(|| {
                    wrong(format!("epsilon_mode {mode:?}: must be paper or intrinsic"))
                })?;
                Some(Smoothing::new(mode, epsilon).map_err(|error| wrong(error.to_string()))?)
            }
        };
        let u = us
            .get(&line.iteration)
            .cloned()
            .ok_or_else(|| wrong(format!("the file u_{}.npy is missing", line.iteration)))?;
        let q = qs.get(&line.iteration).cloned();
        Ok(Iterate { iteration: line.iteration, seconds: line.seconds, smoothing, u, q })
    }
}

/// The arrays of a folder, by their iterations.
struct Arrays {
    us: BTreeMap<u64, PathBuf>,
    qs: BTreeMap<u64, PathBuf>,
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
            let name = name.to_owned();
            if let Some(other) = all.insert(number, path) {
                let other = other.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let [first, second] = if other < name { [other, name] } else { [name, other] };
                let message =
                    format!("{first} and {second} are both of iteration {number}; remove one");
                return Err(Error::malformed(folder, message));
            }
        }
    }
    Ok(all)
}
