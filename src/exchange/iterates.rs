//! What a solver leaves in its folder.
//!
//! ```text
//! trace.csv             iteration,seconds[,epsilon,epsilon_mode], a line for each sample
//! u_<iteration>.npy     V x m, any number of zeros in front of the number
//! q_<iteration>.npy     2F x m, rows as those of K, if the solver has one
//! ```
//!
//! A line counts once it is whole: a solver that is ended in the middle keeps what it wrote before. The last one needs
//! no end of line, if its fields can be read and its iterate is there.

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
    /// By the solver's own clock, in seconds; does not descend.
    pub seconds: f64,
    /// Of the energy that it minimizes, if that is not the true one.
    pub smoothing: Option<Smoothing>,
    /// The file of U, V x m, not read yet.
    pub u: PathBuf,
    /// The file of the dual field, 2F x m, if there is one; not read yet.
    pub q: Option<PathBuf>,
}

/// All that is whole, and what is wrong with the rest.
#[derive(Debug, Default)]
pub struct Iterates {
    /// In ascending order of their iterations.
    pub all: Vec<Iterate>,
    /// Why the rest was not read, if there is any.
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

/// 10 and 10.0 alike, as tables of floats are written.
fn whole<'a, D: Deserializer<'a>>(field: D) -> std::result::Result<u64, D::Error> {
    let text = String::deserialize(field)?;
    let float = || text.parse().ok().filter(|x: &f64| x.fract() == 0.0 && (0.0..1e15).contains(x));
    let number = text.parse().ok().or_else(|| float().map(|x| x as u64));
    number.ok_or_else(|| serde::de::Error::custom(format!("iteration {text:?} is no whole number")))
}

impl Iterates {
    /// The iterates of a folder, in the order of their iterations, up to where the trace is no CSV, its iterations
    /// or times do not ascend, or it names what is not there.
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
                "names no column {missing}; it must name the columns iteration and seconds, and may name epsilon and \
                 epsilon_mode, with commas between them"
            );
            return Err(Error::malformed_line(&path, line, message));
        }
        for record in csv.records() {
            let record = record.map_err(malformed)?;
            let start = record.position().map_or(0, |position| position.byte() as usize);
            match self.iterate(&path, &headers, &record, &arrays) {
                Ok(iterate) => self.all.push(iterate),
                // It was being written.
                Err(_) if start >= whole => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// What a line of the trace stands for, after those before it.
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
                "{} fields, the header has {}",
                record.len(),
                headers.len()
            )));
        }
        let line: Line = record.deserialize(Some(headers)).map_err(|error| {
            wrong(match error.kind() {
                csv::ErrorKind::Deserialize { err, .. } => {
                    let field = err.field().and_then(|field| usize::try_from(field).ok());
                    match field.and_then(|i| Some((headers.get(i)?, record.get(i)?))) {
                        Some((column, text)) => format!("{column} {text:?} is no number"),
                        None => err.to_string(),
                    }
                }
                _ => error.to_string(),
            })
        })?;
        if !(line.seconds >= 0.0 && line.seconds <= u32::MAX.into()) {
            return Err(wrong(format!("{} is no time in seconds", line.seconds)));
        }
        if let Some(last) = self.all.last()
            && !(line.iteration > last.iteration && line.seconds >= last.seconds)
        {
            return Err(wrong("iterations must ascend, and times not descend".into()));
        }
        // Tables of floats write what is missing as NaN.
        let smoothing = match line.epsilon.filter(|epsilon| !epsilon.is_nan()) {
            None => None,
            Some(epsilon) => {
                let mode = line.epsilon_mode.as_deref().unwrap_or("paper");
                let mode = SmoothingMode::named(mode)
                    .ok_or_else(|| wrong(format!("epsilon_mode {mode:?}: paper or intrinsic")))?;
                Some(Smoothing::new(mode, epsilon).map_err(|error| wrong(error.to_string()))?)
            }
        };
        let u = us
            .get(&line.iteration)
            .cloned()
            .ok_or_else(|| wrong(format!("there is no file u_{}.npy beside it", line.iteration)))?;
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
            all.insert(number, path);
        }
    }
    Ok(all)
}
