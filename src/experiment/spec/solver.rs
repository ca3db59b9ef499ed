//! `[[solver]]`: how instances are solved, by a built-in solver or by a command.

use std::ops::Range;
use std::time::Duration;

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::super::document::{Scalar, Section, SpanError, SpanResult, Spanned};
use super::super::grid::{Group, Keys};
use super::super::nearest::did_you_mean;
use super::cell::{Cell, label_of};
use super::reconstruct::{Evolution, RECONSTRUCT};
use crate::error::Result;
use crate::mesh::Source;
use crate::names::Named;
use crate::problem::Problem;
use crate::rounding::Rounding;
use crate::run::{Stop, time_limit};
use crate::solver::{Method, Options, Setup};

/// How instances are solved.
#[derive(Clone, Debug)]
pub struct SolverCell {
    /// Its name in figures, tables and messages.
    pub label: String,
    /// The label without the values that differ between the cells of its table.
    pub base: String,
    /// Those values.
    pub(crate) varied: Keys,
    pub(crate) keys: Keys,
    /// The name of a method or of a baseline, `external` or `reconstruct`.
    pub name: String,
    /// Its settings, as in the file.
    pub options: Options,
    /// Number of threads; `None` for one per core.
    pub threads: Option<usize>,
    /// Whether coarser meshes are solved first.
    pub coarse_to_fine: bool,
    /// Maximum number of iterations, if it differs from that of the file.
    pub(crate) max_iterations: Option<u64>,
    /// Number of thresholds of two regions that are evaluated, see [`crate::level_sets`].
    pub(crate) thresholds: Option<usize>,
    /// How U is rounded.
    pub(crate) rounding: Rounding,
    /// The gap of the labels at which their bound need not be raised further; `None` if it is not raised at all.
    pub(crate) label_gap: Option<f64>,
    /// What it computes.
    pub(crate) task: Task,
}

/// What a solver of an experiment computes.
#[derive(Clone, Debug)]
pub enum Task {
    /// U for fixed costs, by a built-in method.
    Solve,
    /// U for fixed costs, by a command.
    External(External),
    /// U and the region parameters in turn.
    Segment(Estimation),
    /// Labels without regard to cuts.
    Baseline(BaselineName),
    /// A surface from photographs.
    Reconstruct(Evolution),
}

impl Task {
    /// Whether it uses the costs of the instance. All others have parameters, and thus costs, of their own.
    pub fn has_fixed_costs(&self) -> bool {
        matches!(self, Task::Solve | Task::External(_))
    }

    /// How a surface evolves, if one does.
    pub fn evolution(&self) -> Option<&Evolution> {
        match self {
            Task::Reconstruct(evolution) => Some(evolution),
            _ => None,
        }
    }

    /// The command, if it is one.
    pub fn external(&self) -> Option<&External> {
        match self {
            Task::External(external) => Some(external),
            _ => None,
        }
    }
}

/// How region parameters are estimated.
#[derive(Clone, Copy, Debug)]
pub struct Estimation {
    /// r, the steps of U between re-estimations.
    pub every: u64,
    /// The start.
    pub init: Init,
    /// The seed of a random start.
    pub seed: u64,
}

/// The start of an estimation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Init {
    /// Clusters of the data.
    #[strum(serialize = "kmeans")]
    KMeans,
    /// Random labels.
    Random,
    /// Slabs across the longest side of the mesh, of equal length, one per region.
    Slabs,
    /// The same slabs in the opposite order.
    OppositeSlabs,
    /// Shells around the center of the bounding box of the mesh.
    Shells,
    /// Thin slabs, whose labels take turns.
    Stripes,
}

/// A baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum BaselineName {
    /// The nearest center of k-means.
    KMeans,
    /// The classes of least variance of scalar data.
    Threshold,
}

/// The keys of an estimation; the first makes it one.
const ESTIMATION_KEYS: [&str; 3] = ["every", "init", "init-seed"];

/// The keys of labels.
const LABEL_KEYS: [&str; 2] = ["rounding", "label-gap"];

/// The name of all external solvers.
const EXTERNAL: &str = "external";

/// An external solver.
#[derive(Clone, Debug)]
pub struct External {
    /// Words separated by blanks; run in the folder of the file.
    pub command: String,
    /// Wall time after which it is killed, including reading and compiling.
    pub limit: Duration,
}

pub(super) fn read_solvers(mut section: Section<'_>, stop: &Stop) -> SpanResult<Vec<SolverCell>> {
    let label = section.text("label")?.map(|label| label.value);
    let mut group = Group { keys: Vec::new(), zip: Vec::new() };
    match section.list("name")? {
        Some(names) => group.keys.push(("solver".into(), names)),
        None => return Err(SpanError::at(&section.span, "[[solver]] needs name")),
    }
    for key in ESTIMATION_KEYS.into_iter().chain(LABEL_KEYS).chain([
        "max-iterations",
        "thresholds",
        "command",
        "limit",
        "threads",
        "coarse-to-fine",
    ]) {
        if let Some(values) = section.list(key)? {
            group.keys.push((key.to_owned(), values));
        }
    }
    if let Some(mut options) = section.section("options")? {
        for (key, values) in options.rest()? {
            group.keys.push((format!("options.{}", key.value), values));
        }
    }
    group.zipped(&mut section)?;
    let table = section.span.clone();
    section.end()?;
    let cells = group.cells(&table)?;
    cells.iter().map(|cell| read_cell(&Cell(cell), &group, label.as_deref(), stop)).collect()
}

fn read_cell(
    cell: &Cell<'_>,
    group: &Group,
    label: Option<&str>,
    stop: &Stop,
) -> SpanResult<SolverCell> {
    let (name, span) = cell.text("solver")?.expect("it is needed");
    let baseline = BaselineName::named(name);
    let task = match (name, baseline) {
        (EXTERNAL, _) => Task::External(read_external(cell, span, stop)?),
        (RECONSTRUCT, _) => Task::Reconstruct(Evolution::read(cell)?),
        (_, Some(baseline)) => Task::Baseline(baseline),
        _ => read_estimation(cell)?.map_or(Task::Solve, Task::Segment),
    };
    if matches!(task, Task::External(_) | Task::Baseline(_))
        && let Some(given) = ESTIMATION_KEYS.iter().find_map(|key| cell.get(key))
    {
        let message =
            format!("{name} estimates no parameters: leave out {}", ESTIMATION_KEYS.join(", "));
        return Err(SpanError::at(&given.span, message));
    }
    if task.external().is_none()
        && let Some(given) = cell.get("command").or_else(|| cell.get("limit"))
    {
        let message = format!("command and limit need name = \"{EXTERNAL}\"");
        return Err(SpanError::at(&given.span, message));
    }
    if matches!(task, Task::External(_) | Task::Baseline(_))
        && let Some(given) = LABEL_KEYS.iter().find_map(|key| cell.get(key))
    {
        let message = format!("{name} rounds nothing: leave out {}", LABEL_KEYS.join(", "));
        return Err(SpanError::at(&given.span, message));
    }
    let method = match task {
        Task::Solve | Task::Segment(_) => Some(method_named(name, span)?),
        Task::External(_) | Task::Baseline(_) | Task::Reconstruct(_) => None,
    };
    if let (Task::Baseline(_), Some((_, given))) =
        (&task, cell.0.iter().find(|(key, _)| key.starts_with("options.")))
    {
        return Err(SpanError::at(&given.span, format!("{name} has no options")));
    }
    let options = read_options(cell, method, span)?;
    let threads = match cell.get("threads") {
        None => None,
        Some(_) => Some(cell.count("threads", 1, 1..=1024)? as usize),
    };
    let coarse_to_fine = read_boolean(cell, "coarse-to-fine")?;
    let called = task.external().map_or(name, |external| &external.command);
    let plain = called.to_owned() + &plain_settings(cell, threads, coarse_to_fine);
    Ok(SolverCell {
        label: label_of(label, plain, cell, group),
        base: label.unwrap_or(called).to_owned(),
        varied: cell.keys().into_iter().filter(|(key, _)| group.varies(key)).collect(),
        keys: cell.keys(),
        name: name.to_owned(),
        options,
        threads,
        coarse_to_fine,
        max_iterations: match cell.get("max-iterations") {
            None => None,
            Some(_) => Some(cell.count("max-iterations", 0, 0..=u64::MAX)?),
        },
        thresholds: read_thresholds(cell, &task)?,
        rounding: cell.named("rounding", Rounding::Argmax)?,
        label_gap: match cell.get("label-gap") {
            None => None,
            Some(_) => Some(cell.number("label-gap", 0.0, 0.0)?),
        },
        task,
    })
}

fn read_estimation(cell: &Cell<'_>) -> SpanResult<Option<Estimation>> {
    if cell.get("every").is_none() {
        return match ESTIMATION_KEYS.iter().find_map(|key| cell.get(key)) {
            None => Ok(None),
            Some(given) => Err(SpanError::at(
                &given.span,
                "a start needs every = STEPS between re-estimations of the parameters",
            )),
        };
    }
    Ok(Some(Estimation {
        every: cell.count("every", 1, 1..=u64::MAX)?,
        init: cell.named("init", Init::KMeans)?,
        seed: cell.count("init-seed", 0, 0..=u64::MAX)?,
    }))
}

/// The part after the name in the label of a solver without a given one.
fn plain_settings(cell: &Cell<'_>, threads: Option<usize>, coarse_to_fine: bool) -> String {
    let shown = ESTIMATION_KEYS.into_iter().chain(LABEL_KEYS).chain(["max-iterations"]);
    let shown: Vec<&str> = shown.collect();
    let options = cell.0.iter().filter_map(|(key, value)| match key.strip_prefix("options.") {
        Some(key) => Some(format!(", {key}={}", value.value.text())),
        None if shown.contains(&key.as_str()) => Some(format!(", {key} {}", value.value.text())),
        None => None,
    });
    let threads = threads.map_or(String::new(), |n| format!(", {n} threads"));
    let coarse = if coarse_to_fine { ", coarse to fine" } else { "" };
    format!("{}{threads}{coarse}", options.collect::<String>())
}

fn method_named(name: &str, span: &Range<usize>) -> SpanResult<Method> {
    Method::named(name).map_err(|error| {
        let known = Method::all();
        let known = known.iter().map(Method::name);
        let meant = did_you_mean(
            name,
            known.chain(BaselineName::names().iter().copied()).chain([EXTERNAL, RECONSTRUCT]),
        );
        let others = BaselineName::names().join(", ");
        SpanError::at(span, format!("{error}, {others}, {EXTERNAL}, {RECONSTRUCT}{meant}"))
    })
}

/// The options of a method, each checked by itself and then all together; those of a command are not checked. Options
/// that only conflict with each other are an error at `span`.
fn read_options(
    cell: &Cell<'_>,
    mut method: Option<Method>,
    span: &Range<usize>,
) -> SpanResult<Options> {
    let mut options = Vec::new();
    for (key, value) in cell.0 {
        let Some(key) = key.strip_prefix("options.") else { continue };
        if method.is_none() && key == "command" {
            let message = "command is not an option; it belongs next to name";
            return Err(SpanError::at(&value.span, message));
        }
        let option = format!("{key}={}", value.value.text());
        Options::parse(&[&option])
            .and_then(|alone| method.as_mut().map_or(Ok(()), |method| method.set(&alone)))
            .map_err(|error| {
                let known = method.iter_mut().flat_map(Method::settings);
                let known: Vec<&str> = known.map(|setting| setting.key).collect();
                let meant = did_you_mean(key, known.iter().copied());
                let meant = if known.contains(&key) { "" } else { &meant };
                SpanError::at(&value.span, format!("{error}{meant}"))
            })?;
        options.push((option, &value.span));
    }
    if let Some(method) = &method
        && let Err(error) = try_out(method)
    {
        let names = |option: &str| error.to_string().contains(option);
        let blamed = options.iter().find(|(option, _)| names(option));
        return Err(SpanError::at(blamed.map_or(span, |(_, span)| span), error.to_string()));
    }
    let texts: Vec<String> = options.into_iter().map(|(option, _)| option).collect();
    Options::parse(&texts).map_err(|error| SpanError::at(span, error.to_string()))
}

fn read_thresholds(cell: &Cell<'_>, task: &Task) -> SpanResult<Option<usize>> {
    let Some(given) = cell.get("thresholds") else { return Ok(None) };
    if !matches!(task, Task::Solve) {
        let message = "thresholds are those of a built-in solver with fixed costs, without every";
        return Err(SpanError::at(&given.span, message));
    }
    Ok(Some(cell.count("thresholds", 0, 1..=1000)? as usize))
}

/// The value of a Boolean key, false by default.
fn read_boolean(cell: &Cell<'_>, key: &str) -> SpanResult<bool> {
    match cell.get(key) {
        None => Ok(false),
        Some(Spanned { value: Scalar::Boolean(value), .. }) => Ok(*value),
        Some(Spanned { span, .. }) => {
            Err(SpanError::at(span, format!("{key} must be true or false")))
        }
    }
}

/// An external solver. Its default limit is three times the time limit of the stopping rule plus a minute to start.
fn read_external(cell: &Cell<'_>, span: &Range<usize>, stop: &Stop) -> SpanResult<External> {
    if let Some(given) = cell.get("coarse-to-fine") {
        return Err(SpanError::at(
            &given.span,
            "coarse-to-fine does not apply to an external solver",
        ));
    }
    let Some((command, command_span)) = cell.text("command")? else {
        return Err(SpanError::at(span, "an external solver needs command = \"PROGRAM [WORDS]\""));
    };
    if command.trim().is_empty() {
        return Err(SpanError::at(command_span, "command is empty"));
    }
    let limit = match (cell.get("limit"), stop.time) {
        (None, Some(time)) => time.saturating_mul(3).saturating_add(Duration::from_secs(60)),
        (None, None) => {
            let message = "an external solver needs limit = SECONDS, or a time-limit in stop";
            return Err(SpanError::at(span, message));
        }
        (Some(given), _) => time_limit(cell.number("limit", 0.0, 0.0)?)
            .map_err(|message| SpanError::at(&given.span, format!("limit {message}")))?,
    };
    Ok(External { command: command.to_owned(), limit })
}

/// Builds the solver for a tiny problem, which detects conflicting settings.
fn try_out(method: &Method) -> Result<()> {
    let mesh = Source::parse("torus:5x4")?.mesh()?;
    let start = vec![crate::field::Row([0.5; 2]); mesh.vertices.len()];
    let problem = Problem::new(crate::operator::Stencil::new(&mesh), start.clone(), 1.0);
    let setup = Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
    method.build(setup).map(drop)
}
