//! The experiment file: one question about instances and solvers.
//!
//! ```toml
//! # The question, in the first comment.
//! repetitions = 3
//! stop = { gap = 1e-6, max-iterations = 10000, time-limit = 60 }
//!
//! [[instance]]
//! mesh = ["torus:100x64", "builtin:spot"]     # a list is swept
//! data = "waves"
//! regions = 4
//! lambda = [0.002, 0.005]                     # or "auto", the one that `segment` takes, or "0.5 auto"
//!
//! [[solver]]
//! name = "fista"
//! options = { epsilon = [1e-2, 1e-4], epsilon-mode = "intrinsic" }
//!
//! [[figure]]
//! name = "decay"
//! kind = "decay"
//! ```

mod cell;
mod checks;
mod instance;
mod reconstruct;
mod solver;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::document::{self, Scalar, Section, SpanError, SpanResult, Spanned};
use super::figures::{FigureSpec, Selection, TableSpec, matches};
use super::grid::{Exclusion, MAX_RUNS};
use super::nearest::did_you_mean;
use crate::error::{Error, Result};
use crate::format_error::FormatError;
use crate::run::{Stop, time_limit};

pub use instance::{InstanceCell, LambdaChoice};
pub use reconstruct::{Evolution, RECONSTRUCT};
pub use solver::{BaselineName, Estimation, External, Init, SolverCell, Task};

use checks::{
    check_baselines, check_columns, check_faces, check_parameters, check_reconstructions,
    check_stop, check_thresholds, covers,
};
use instance::read_instances;
use solver::read_solvers;

/// The content of an experiment file.
pub struct Spec {
    /// The file.
    pub path: PathBuf,
    /// The stem of the file.
    pub name: String,
    /// Its text, without a byte order mark.
    pub text: String,
    /// Its first comment.
    pub question: String,
    /// Number of runs of each solver on each instance, at least 1.
    pub repetitions: u64,
    /// The stopping rule; at least one limit is set.
    pub stop: Stop,
    /// In the order of the file, swept lists expanded.
    pub instances: Vec<InstanceCell>,
    /// In the order of the file, swept lists expanded.
    pub solvers: Vec<SolverCell>,
    pub(crate) exclusions: Vec<Exclusion>,
    pub(crate) figures: Vec<FigureSpec>,
    pub(crate) tables: Vec<TableSpec>,
}

impl Spec {
    /// Reads a file. Fails if it cannot be read, or if anything in it is unknown, of the wrong type or impossible.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = crate::file::read(path)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::malformed(path, "is not UTF-8 text; an experiment is a TOML file")
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned();
        let name = path.file_stem().and_then(|stem| stem.to_str()).map(str::to_owned);
        let name = name.filter(|name| !name.starts_with('.')).ok_or_else(|| {
            Error::malformed(path, "needs a name in UTF-8, after which the results folder is named")
        })?;
        Spec::parse(path, name, text).map_err(|error| Box::new(error).into())
    }

    fn parse(path: &Path, name: String, text: String) -> std::result::Result<Self, FormatError> {
        let question = first_comment(&text);
        document::read(path, &text, |file| {
            let repetitions = file.count("repetitions", 1)?;
            let repeated = repetitions.as_ref().map_or(0..0, |count| count.span.clone());
            let repetitions = repetitions.map_or(1, |count| count.value);
            let stop = match file.section("stop")? {
                Some(section) => read_stop(section)?,
                None => Stop::default(),
            };
            let folder = path.parent().unwrap_or(Path::new(""));
            let instances = labeled(file, "instance", |section| read_instances(section, folder))?;
            let solvers = labeled(file, "solver", |section| read_solvers(section, &stop))?;
            check_stop(&stop, &solvers)?;
            check_run_count(repetitions, &repeated, instances.len(), solvers.len())?;
            let exclusions = read_all(file, "exclude", |mut section| {
                read_exclusion(&mut section, &instances, &solvers)
            })?;
            check_parameters(&instances, &solvers, &exclusions)?;
            check_thresholds(&instances, &solvers, &exclusions)?;
            check_faces(&instances, &solvers, &exclusions)?;
            check_baselines(&instances, &solvers, &exclusions)?;
            check_reconstructions(&instances, &solvers, &exclusions)?;
            let figures = read_all(file, "figure", FigureSpec::read)?;
            for figure in &figures {
                check_selection(&figure.selection, &instances, &solvers)?;
                check_columns(figure, &instances)?;
            }
            let tables = read_all(file, "table", TableSpec::read)?;
            for table in &tables {
                check_selection(&table.selection, &instances, &solvers)?;
            }
            Ok(Spec {
                path: path.to_owned(),
                name,
                text: text.clone(),
                question,
                repetitions,
                stop,
                instances,
                solvers,
                exclusions,
                figures,
                tables,
            })
        })
    }

    /// An error at a span of the file.
    pub fn format_error(&self, span: &Range<usize>, message: impl fmt::Display) -> Error {
        let end = self.text.len();
        let span = span.start.min(end)..span.end.min(end);
        let message = message.to_string();
        let (path, text) = (self.path.clone(), self.text.clone());
        Box::new(FormatError { path, text, span, message }).into()
    }

    /// Whether a solver runs on an instance.
    pub fn includes(&self, instance: &InstanceCell, solver: &SolverCell) -> bool {
        !self.exclusions.iter().any(|exclusion| covers(exclusion, instance, solver))
    }
}

/// All tables `[[key]]`; there may be none.
fn read_all<'a, T>(
    file: &mut Section<'a>,
    key: &'static str,
    read: impl FnMut(Section<'a>) -> SpanResult<T>,
) -> SpanResult<Vec<T>> {
    file.sections(key)?.into_iter().map(read).collect()
}

fn check_run_count(
    repetitions: u64,
    repeated: &Range<usize>,
    instances: usize,
    solvers: usize,
) -> SpanResult<()> {
    let runs = repetitions.saturating_mul(instances as u64).saturating_mul(solvers as u64);
    if runs <= MAX_RUNS {
        return Ok(());
    }
    let message = format!(
        "{repetitions} repetitions of {solvers} solvers on {instances} instances make {runs} runs; at most {MAX_RUNS} \
         are allowed"
    );
    Err(SpanError::at(repeated, message))
}

/// The lines of the first block of comments, joined.
fn first_comment(text: &str) -> String {
    let lines = text.lines().map(str::trim).skip_while(|line| line.is_empty());
    let comment = lines.map_while(|line| line.strip_prefix('#')).map(str::trim);
    let paragraph = comment.skip_while(|line| line.is_empty()).take_while(|line| !line.is_empty());
    paragraph.collect::<Vec<_>>().join(" ").trim().to_owned()
}

fn read_stop(mut section: Section<'_>) -> SpanResult<Stop> {
    let gap = section.number("gap")?;
    if let Some(gap) = &gap
        && gap.value < 0.0
    {
        return Err(SpanError::at(&gap.span, "gap must be a number, 0 or more"));
    }
    let time = section.number("time-limit")?.map(|limit| {
        time_limit(limit.value)
            .map_err(|message| SpanError::at(&limit.span, format!("time-limit {message}")))
    });
    let stop = Stop {
        relative_gap: gap.map(|gap| gap.value),
        iterations: section.count("max-iterations", 0)?.map(|count| count.value),
        time: time.transpose()?,
        change: None,
        interval: section.count("check-every", 1)?.map(|count| count.value),
    };
    section.end()?;
    Ok(stop)
}

/// All tables `[[key]]`, at least one, with distinct labels.
fn labeled<T: Labeled>(
    file: &mut Section<'_>,
    key: &'static str,
    read: impl Fn(Section<'_>) -> SpanResult<Vec<T>>,
) -> SpanResult<Vec<T>> {
    let sections = file.sections(key)?;
    if sections.is_empty() {
        return Err(SpanError::at(
            &(0..0),
            format!("there is no [[{key}]]: at least one is needed"),
        ));
    }
    let mut all: Vec<T> = Vec::new();
    let mut labels = HashSet::new();
    for section in sections {
        let span = section.span.clone();
        for one in read(section)? {
            let label = one.label();
            if !labels.insert(label.to_owned()) {
                let message = format!(
                    "two of [[{key}]] are called {label:?}: give one of them another label"
                );
                return Err(SpanError::at(&span, message));
            }
            all.push(one);
        }
    }
    Ok(all)
}

trait Labeled {
    fn label(&self) -> &str;
}

impl Labeled for InstanceCell {
    fn label(&self) -> &str {
        &self.label
    }
}

impl Labeled for SolverCell {
    fn label(&self) -> &str {
        &self.label
    }
}

/// Checks that a figure or a table selects something.
fn check_selection(
    selection: &Selection,
    instances: &[InstanceCell],
    solvers: &[SolverCell],
) -> SpanResult<()> {
    let check = |key: &str, parts: &[Spanned<String>], labels: &[&str]| {
        let is_there = |wanted: &str| labels.iter().any(|label| matches(label, wanted));
        let Some(part) = parts.iter().find(|part| !is_there(&part.value)) else { return Ok(()) };
        let Spanned { value, span } = part;
        let (verb, text) = match value.strip_prefix('=') {
            Some(whole) => ("is", whole),
            None => ("contains", &value[..]),
        };
        let meant = did_you_mean(text, labels.iter().copied());
        let message = format!("{key}: no label of [[{}]] {verb} {text:?}{meant}", key_of(key));
        Err(SpanError::at(span, message))
    };
    let labels: Vec<&str> = instances.iter().map(|cell| cell.label.as_str()).collect();
    check("only", &selection.only, &labels)?;
    let labels: Vec<&str> = solvers.iter().map(|cell| cell.label.as_str()).collect();
    check("solvers", &selection.solvers, &labels)
}

/// The tables whose labels a key of a figure names.
fn key_of(key: &str) -> &'static str {
    if key == "only" { "instance" } else { "solver" }
}

fn read_exclusion(
    section: &mut Section<'_>,
    instances: &[InstanceCell],
    solvers: &[SolverCell],
) -> SpanResult<Exclusion> {
    let mut entries = Vec::new();
    if let Some(mut options) = section.section("options")? {
        for (key, values) in options.rest()? {
            entries.push((Spanned { value: format!("options.{}", key.value), ..key }, values));
        }
    }
    entries.extend(section.rest()?);
    let mut known: BTreeMap<&str, Vec<&Scalar>> = BTreeMap::new();
    let of_instances = instances.iter().flat_map(|cell| &cell.keys);
    for (key, value) in of_instances.chain(solvers.iter().flat_map(|cell| &cell.keys)) {
        known.entry(key).or_default().push(value);
    }
    for (key, values) in &entries {
        let Some(there) = known.get(key.value.as_str()) else {
            let known: Vec<&str> = known.into_keys().collect();
            let meant = did_you_mean(&key.value, known.iter().copied());
            let message = format!(
                "no cell has the key {:?}; there are {}{meant}",
                key.value,
                known.join(", ")
            );
            return Err(SpanError::at(&key.span, message));
        };
        if let Some(odd) = values.iter().find(|odd| !there.iter().any(|value| odd.value.is(value)))
        {
            let (key, given) = (&key.value, odd.value.text());
            let there: BTreeSet<String> = there.iter().map(|value| value.text()).collect();
            let meant = did_you_mean(&given, there.iter().map(String::as_str));
            let message = format!("no cell has the {key} {given}, so nothing is excluded{meant}");
            return Err(SpanError::at(&odd.span, message));
        }
    }
    let exclusion = Exclusion(entries);
    let mut solved = instances.iter().flat_map(|one| solvers.iter().map(move |other| (one, other)));
    if !solved.any(|(instance, solver)| covers(&exclusion, instance, solver)) {
        let message = "no cell has all of these values together, so nothing is excluded";
        return Err(SpanError::at(&section.span, message));
    }
    Ok(exclusion)
}
