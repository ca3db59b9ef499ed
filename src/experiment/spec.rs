//! The experiment file: one question, asked of instances and solvers.
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
//! lambda = [0.002, 0.005]
//!
//! [[solver]]
//! name = "fista"
//! options = { epsilon = [1e-2, 1e-4], epsilon-mode = "intrinsic" }
//!
//! [[figure]]
//! name = "decay"
//! kind = "decay"
//! ```

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::data::DataChoice;
use super::document::{self, Fits, Misfit, Placed, Scalar, Section, Wrong};
use super::figures::{FigureSpec, TableSpec};
use super::grid::{Exclusion, Group, Keys};
use super::nearest::did_you_mean;
use crate::error::{Error, Result};
use crate::mesh::Source;
use crate::operator::Mass;
use crate::problem::Problem;
use crate::regions;
use crate::run::Stop;
use crate::solve::check_lambda;
use crate::solver::{self, DESCRIPTIONS, Options, Setup};

/// What a file asks for.
pub struct Spec {
    pub path: PathBuf,
    /// The stem of the file.
    pub name: String,
    pub text: String,
    /// Its first comment.
    pub question: String,
    pub repetitions: u64,
    pub stop: Stop,
    pub instances: Vec<InstanceCell>,
    pub solvers: Vec<SolverCell>,
    pub exclusions: Vec<Exclusion>,
    pub figures: Vec<FigureSpec>,
    pub tables: Vec<TableSpec>,
}

/// What is to be segmented.
#[derive(Clone, Debug)]
pub struct InstanceCell {
    pub label: String,
    pub keys: Keys,
    pub mesh: String,
    pub data: DataChoice,
    /// Standard deviation of what is added to every entry of the data.
    pub noise: f64,
    pub seed: u64,
    pub regions: usize,
    pub lambda: f64,
    pub mass: Mass,
    /// Whether the mesh is scaled to area 1.
    pub normalize: bool,
    /// Where its mesh and its data stand in the file.
    pub mesh_place: Range<usize>,
    pub data_place: Range<usize>,
}

/// How it is solved.
#[derive(Clone, Debug)]
pub struct SolverCell {
    pub label: String,
    /// The label without the values by which it differs from others of its table, and those values.
    pub base: String,
    pub varied: Keys,
    pub keys: Keys,
    pub name: String,
    pub options: Options,
    pub threads: Option<usize>,
    pub coarse_to_fine: bool,
    /// If it is a command and not one of ours.
    pub external: Option<External>,
}

/// The name of solvers outside the program.
const EXTERNAL: &str = "external";

/// A solver outside the program.
#[derive(Clone, Debug)]
pub struct External {
    /// Words between blanks, run in the folder of the file.
    pub command: String,
    /// When it is ended, whatever it does: wall time, reading and compiling included.
    pub limit: Duration,
}

impl Spec {
    /// # Errors
    /// A file that cannot be read, and everything in it that is unknown, of the wrong type or impossible.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = crate::file::read(path)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::malformed(path, "is not UTF-8 text; an experiment is a TOML file")
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned();
        let name = path.file_stem().and_then(|stem| stem.to_str()).map(str::to_owned);
        let name = name.filter(|name| !name.starts_with('.')).ok_or_else(|| {
            Error::malformed(
                path,
                "needs a name in UTF-8, from which the folder of results is named",
            )
        })?;
        Spec::parse(path, name, text).map_err(|misfit| Box::new(misfit).into())
    }

    fn parse(path: &Path, name: String, text: String) -> std::result::Result<Self, Misfit> {
        let question = first_comment(&text);
        document::read(path, &text, |file| {
            let repetitions = file.count("repetitions", 1)?.map_or(1, |count| count.value);
            let stop = match file.section("stop")? {
                Some(section) => read_stop(section)?,
                None => Stop::default(),
            };
            if stop.relative_gap.is_none() && stop.iterations.is_none() && stop.time.is_none() {
                return Err(Wrong::at(
                    &(0..0),
                    "no end: give stop = { gap = ..., max-iterations = ..., time-limit = ... }, one at least",
                ));
            }
            let folder = path.parent().unwrap_or(Path::new(""));
            let instances = labeled(file, "instance", |section| read_instances(section, folder))?;
            let solvers = labeled(file, "solver", |section| read_solvers(section, &stop))?;
            let exclusions = file
                .sections("exclude")?
                .into_iter()
                .map(|mut section| read_exclusion(&mut section, &instances, &solvers))
                .collect::<Fits<_>>()?;
            let figures = file
                .sections("figure")?
                .into_iter()
                .map(FigureSpec::read)
                .collect::<Fits<Vec<_>>>()?;
            for figure in &figures {
                check_filters(figure, &instances, &solvers)?;
            }
            let tables = file
                .sections("table")?
                .into_iter()
                .map(TableSpec::read)
                .collect::<Fits<Vec<_>>>()?;
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

    /// Something that the file asks for at a place, and that is not there.
    pub fn misfit(&self, place: &Range<usize>, message: impl fmt::Display) -> Error {
        let end = self.text.len();
        let place = place.start.min(end)..place.end.min(end);
        let message = message.to_string();
        let (path, text) = (self.path.clone(), self.text.clone());
        Box::new(Misfit { path, text, place, message }).into()
    }

    /// Whether a solver runs on an instance.
    pub fn includes(&self, instance: &InstanceCell, solver: &SolverCell) -> bool {
        let value = |key: &str| {
            let own = instance.keys.iter().chain(&solver.keys).find(|(name, _)| name == key);
            own.map(|(_, value)| value.clone())
        };
        !self.exclusions.iter().any(|exclusion| exclusion.covers(value))
    }
}

/// The lines of the first block of comments, as one text.
fn first_comment(text: &str) -> String {
    let lines = text.lines().map(str::trim).skip_while(|line| line.is_empty());
    let comment = lines.map_while(|line| line.strip_prefix('#')).map(str::trim);
    comment.collect::<Vec<_>>().join(" ").trim().to_owned()
}

fn read_stop(mut section: Section<'_>) -> Fits<Stop> {
    let gap = section.number("gap")?;
    if let Some(gap) = &gap
        && gap.value < 0.0
    {
        return Err(Wrong::at(&gap.place, "gap must be a number from 0"));
    }
    let time = section.number("time-limit")?.map(|limit| {
        Duration::try_from_secs_f64(limit.value)
            .map_err(|error| Wrong::at(&limit.place, format!("time-limit: {error}")))
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

/// All tables `[[key]]`, at least one, with labels that differ.
fn labeled<T: Labeled>(
    file: &mut Section<'_>,
    key: &'static str,
    read: impl Fn(Section<'_>) -> Fits<Vec<T>>,
) -> Fits<Vec<T>> {
    let sections = file.sections(key)?;
    if sections.is_empty() {
        return Err(Wrong::at(&(0..0), format!("there is no [[{key}]]: at least one is needed")));
    }
    let mut all: Vec<T> = Vec::new();
    for section in sections {
        let place = section.place.clone();
        for one in read(section)? {
            if all.iter().any(|other| other.label() == one.label()) {
                let label = one.label();
                let message =
                    format!("two of [[{key}]] are called {label:?}: give one another label");
                return Err(Wrong::at(&place, message));
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

/// The values of a cell, each asked for by its key.
struct Cell<'a>(&'a [(String, Placed<Scalar>)]);

impl Cell<'_> {
    fn get(&self, key: &str) -> Option<&Placed<Scalar>> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    fn number(&self, key: &str, default: f64, least: f64) -> Fits<f64> {
        let Some(Placed { value, place }) = self.get(key) else { return Ok(default) };
        let number = value.number().filter(|&number| number >= least);
        number.ok_or_else(|| Wrong::at(place, format!("{key} must be a number from {least}")))
    }

    fn count(&self, key: &str, default: u64, range: std::ops::RangeInclusive<u64>) -> Fits<u64> {
        let Some(Placed { value, place }) = self.get(key) else { return Ok(default) };
        match value {
            Scalar::Integer(x) if u64::try_from(*x).is_ok_and(|x| range.contains(&x)) => {
                Ok(*x as u64)
            }
            _ => {
                let (from, to) = (range.start(), range.end());
                let to = if *to == u64::MAX { String::new() } else { format!(" to {to}") };
                Err(Wrong::at(place, format!("{key} must be a whole number from {from}{to}")))
            }
        }
    }

    fn named<T: Copy>(&self, key: &str, names: &[(&str, T)]) -> Fits<T> {
        let Some(Placed { value, place }) = self.get(key) else { return Ok(names[0].1) };
        let found = names.iter().find(|(name, _)| *value == Scalar::Text((*name).to_owned()));
        found.map(|(_, value)| *value).ok_or_else(|| {
            let meant = did_you_mean(&value.text(), names.iter().map(|(name, _)| *name));
            let names: Vec<String> = names.iter().map(|(name, _)| format!("{name:?}")).collect();
            Wrong::at(place, format!("{key} must be one of {}{meant}", names.join(", ")))
        })
    }

    fn text(&self, key: &str) -> Fits<Option<(&str, &Range<usize>)>> {
        match self.get(key) {
            None => Ok(None),
            Some(Placed { value: Scalar::Text(text), place }) => Ok(Some((text, place))),
            Some(Placed { place, .. }) => {
                Err(Wrong::at(place, format!("{key} must be a text in quotes")))
            }
        }
    }

    fn keys(&self) -> Keys {
        self.0.iter().map(|(key, placed)| (key.clone(), placed.value.clone())).collect()
    }
}

/// The given label, or what the cell is; behind it the values by which it differs from others of its table.
fn label_of(label: Option<&str>, plain: String, cell: &Cell<'_>, group: &Group) -> String {
    let Some(label) = label else { return plain };
    let varied = cell.0.iter().filter(|(key, _)| group.varies(key));
    let varied = varied.map(|(key, placed)| {
        let key = key.strip_prefix("options.").unwrap_or(key);
        format!(", {key} {}", placed.value.text())
    });
    label.to_owned() + &varied.collect::<String>()
}

fn read_instances(mut section: Section<'_>, folder: &Path) -> Fits<Vec<InstanceCell>> {
    let label = section.text("label")?.map(|label| label.value);
    let mut group = Group { keys: Vec::new(), zip: Vec::new() };
    for key in ["mesh", "data", "noise", "seed", "regions", "lambda", "mass", "normalize"] {
        match section.list(key)? {
            Some(values) => group.keys.push((key.to_owned(), values)),
            None if ["mesh", "data", "lambda"].contains(&key) => {
                return Err(Wrong::at(&section.place, format!("{} needs {key}", section.name)));
            }
            None => {}
        }
    }
    group.zipped(&mut section)?;
    section.end()?;
    let instance = |cell: &[(String, Placed<Scalar>)]| {
        let cell = Cell(cell);
        let (mesh, place) = cell.text("mesh")?.expect("it is needed");
        let mesh_place = place.clone();
        if !mesh.starts_with("data:") && !folder.join(mesh).exists() {
            Source::parse(mesh).map_err(|error| Wrong::at(place, error.to_string()))?;
        }
        let (data, place) = cell.text("data")?.expect("it is needed");
        let data_place = place.clone();
        let data: DataChoice = data.parse().map_err(|message: String| {
            let known = ["waves", "own", "colors", "curvature"];
            Wrong::at(place, message + &did_you_mean(data, known))
        })?;
        let lambda = cell.number("lambda", 0.0, 0.0)?;
        check_lambda(lambda).expect("a finite number from 0");
        let regions = match (cell.get("regions"), &data) {
            (Some(given), DataChoice::Costs(_)) => {
                let message = "costs have one column per region: leave regions out";
                return Err(Wrong::at(&given.place, message));
            }
            (None, DataChoice::Costs(_)) => 0,
            (None, _) => {
                return Err(Wrong::at(place, "regions is needed beside this data"));
            }
            (Some(_), _) => {
                let range = *regions::REGIONS.start() as u64..=*regions::REGIONS.end() as u64;
                cell.count("regions", 0, range)? as usize
            }
        };
        let plain = {
            let regions = if regions > 0 { format!(", {regions} regions") } else { String::new() };
            let mass =
                cell.get("mass").map_or(String::new(), |mass| format!(", {}", mass.value.text()));
            let extra = ["noise", "seed"].iter().filter(|key| group.varies(key));
            let extra: String = extra
                .map(|key| format!(", {key} {}", cell.get(key).expect("it varies").value.text()))
                .collect();
            format!("{mesh}, {data}{regions}, lambda {}{mass}{extra}", Scalar::Float(lambda).text())
        };
        Ok(InstanceCell {
            label: label_of(label.as_deref(), plain, &cell, &group),
            keys: cell.keys(),
            mesh: mesh.to_owned(),
            data,
            noise: cell.number("noise", 0.0, 0.0)?,
            seed: cell.count("seed", 0, 0..=u64::MAX)?,
            regions,
            lambda,
            mass: cell.named("mass", &Mass::NAMES)?,
            normalize: cell.named("normalize", &[("area", true), ("none", false)])?,
            mesh_place,
            data_place,
        })
    };
    group.cells().iter().map(|cell| instance(cell)).collect()
}

fn read_solvers(mut section: Section<'_>, stop: &Stop) -> Fits<Vec<SolverCell>> {
    let label = section.text("label")?.map(|label| label.value);
    let mut group = Group { keys: Vec::new(), zip: Vec::new() };
    match section.list("name")? {
        Some(names) => group.keys.push(("solver".into(), names)),
        None => return Err(Wrong::at(&section.place, "[[solver]] needs name")),
    }
    for key in ["command", "limit", "threads", "coarse-to-fine"] {
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
    section.end()?;
    let solver = |cell: &[(String, Placed<Scalar>)]| {
        let cell = Cell(cell);
        let (name, place) = cell.text("solver")?.expect("it is needed");
        let external = match name {
            EXTERNAL => Some(read_external(&cell, place, stop)?),
            _ => None,
        };
        if external.is_none()
            && let Some(given) = cell.get("command").or_else(|| cell.get("limit"))
        {
            let message = format!("belongs to name = \"{EXTERNAL}\" only");
            return Err(Wrong::at(&given.place, message));
        }
        let description = match &external {
            Some(_) => None,
            None => Some(solver::describe(name).map_err(|error| {
                let known = DESCRIPTIONS.iter().map(|description| description.name);
                let meant = did_you_mean(name, known.chain([EXTERNAL]));
                Wrong::at(place, format!("{error}, {EXTERNAL}{meant}"))
            })?),
        };
        let mut options = Vec::new();
        for (key, value) in cell.0 {
            let Some(key) = key.strip_prefix("options.") else { continue };
            if external.is_some() && key == "command" {
                let message = "command is no option; it stands beside name";
                return Err(Wrong::at(&value.place, message));
            }
            let option = format!("{key}={}", value.value.text());
            Options::parse(&[&option])
                .and_then(|alone| description.map_or(Ok(()), |known| alone.check(known)))
                .map_err(|error| {
                    let known = description.iter().flat_map(|known| known.options);
                    let meant = did_you_mean(key, known.map(|option| option.key));
                    let meant = if option_is_known(description, key) { "" } else { &meant };
                    Wrong::at(&value.place, format!("{error}{meant}"))
                })?;
            options.push((option, &value.place));
        }
        let texts: Vec<&str> = options.iter().map(|(option, _)| option.as_str()).collect();
        let all = Options::parse(&texts).map_err(|error| Wrong::at(place, error.to_string()))?;
        if external.is_none()
            && let Err(error) = try_out(name, &all)
        {
            let names = |option: &str| error.to_string().contains(option);
            let blamed = options.iter().find(|(option, _)| names(option));
            return Err(Wrong::at(blamed.map_or(place, |(_, place)| place), error.to_string()));
        }
        let threads = match cell.get("threads") {
            None => None,
            Some(_) => Some(cell.count("threads", 1, 1..=1024)? as usize),
        };
        let coarse_to_fine = match cell.get("coarse-to-fine") {
            None => false,
            Some(Placed { value: Scalar::Truth(truth), .. }) => *truth,
            Some(Placed { place, .. }) => {
                return Err(Wrong::at(place, "coarse-to-fine must be true or false"));
            }
        };
        let plain = {
            let threads = threads.map_or(String::new(), |n| format!(", {n} threads"));
            let coarse = if coarse_to_fine { ", coarse to fine" } else { "" };
            let options: String = texts.iter().map(|option| format!(", {option}")).collect();
            let name = external.as_ref().map_or(name, |external| &external.command);
            format!("{name}{options}{threads}{coarse}")
        };
        let varied = cell.keys().into_iter().filter(|(key, _)| group.varies(key)).collect();
        let base = match &label {
            Some(label) => label.clone(),
            None => external.as_ref().map_or(name, |external| &external.command).to_owned(),
        };
        Ok(SolverCell {
            label: label_of(label.as_deref(), plain, &cell, &group),
            base,
            varied,
            keys: cell.keys(),
            name: name.to_owned(),
            options: all,
            threads,
            coarse_to_fine,
            external,
        })
    };
    group.cells().iter().map(|cell| solver(cell)).collect()
}

fn option_is_known(description: Option<&solver::Description>, key: &str) -> bool {
    description.is_some_and(|known| known.options.iter().any(|option| option.key == key))
}

/// A command that would take no more than three times the time of the stop, and a minute to start, by itself.
fn read_external(cell: &Cell<'_>, place: &Range<usize>, stop: &Stop) -> Fits<External> {
    if let Some(given) = cell.get("coarse-to-fine") {
        return Err(Wrong::at(&given.place, "a solver outside the program starts where it likes"));
    }
    let Some((command, command_place)) = cell.text("command")? else {
        return Err(Wrong::at(place, "an external solver needs command = \"PROGRAM [WORDS]\""));
    };
    if command.trim().is_empty() {
        return Err(Wrong::at(command_place, "command is empty"));
    }
    let limit = match (cell.get("limit"), stop.time) {
        (None, Some(time)) => time.saturating_mul(3).saturating_add(Duration::from_secs(60)),
        (None, None) => {
            let message = "an external solver needs limit = SECONDS, or stop a time-limit";
            return Err(Wrong::at(place, message));
        }
        (Some(given), _) => Duration::try_from_secs_f64(cell.number("limit", 0.0, 0.0)?)
            .map_err(|error| Wrong::at(&given.place, format!("limit: {error}")))?,
    };
    Ok(External { command: command.to_owned(), limit })
}

/// Builds the solver for a tiny problem, which finds every value that it refuses.
fn try_out(name: &str, options: &Options) -> Result<()> {
    let mesh = Source::parse("torus:5x4")?.mesh()?;
    let start = vec![crate::field::Row([0.5; 2]); mesh.vertices.len()];
    let problem = Problem::new(crate::operator::Stencil::new(&mesh), start.clone(), 1.0);
    let setup = Setup { mesh: &mesh, problem: &problem, start, dual_start: None, options };
    solver::build(name, setup).map(drop)
}

/// A figure must have something that it can show.
fn check_filters(
    figure: &FigureSpec,
    instances: &[InstanceCell],
    solvers: &[SolverCell],
) -> Fits<()> {
    let check = |key: &str, part: &Option<String>, place: &Range<usize>, labels: Vec<&str>| {
        let Some(part) = part else { return Ok(()) };
        if labels.iter().any(|label| label.contains(&part[..])) {
            return Ok(());
        }
        let meant = did_you_mean(part, labels);
        let message = format!("{key}: no label of [[{}]] contains {part:?}{meant}", &key_of(key));
        Err(Wrong::at(place, message))
    };
    let labels = instances.iter().map(|cell| cell.label.as_str()).collect();
    check("only", &figure.only, &figure.places.only, labels)?;
    let labels = solvers.iter().map(|cell| cell.label.as_str()).collect();
    check("solvers", &figure.solvers, &figure.places.solvers, labels)
}

/// The tables whose labels a key of a figure names.
fn key_of(key: &str) -> &'static str {
    if key == "only" { "instance" } else { "solver" }
}

fn read_exclusion(
    section: &mut Section<'_>,
    instances: &[InstanceCell],
    solvers: &[SolverCell],
) -> Fits<Exclusion> {
    let mut entries = Vec::new();
    if let Some(mut options) = section.section("options")? {
        for (key, values) in options.rest()? {
            entries.push((Placed { value: format!("options.{}", key.value), ..key }, values));
        }
    }
    entries.extend(section.rest()?);
    let mut known: BTreeMap<&str, ()> = BTreeMap::new();
    known.extend(instances.iter().flat_map(|cell| &cell.keys).map(|(key, _)| (key.as_str(), ())));
    known.extend(solvers.iter().flat_map(|cell| &cell.keys).map(|(key, _)| (key.as_str(), ())));
    for (key, _) in &entries {
        if !known.contains_key(key.value.as_str()) {
            let known: Vec<&str> = known.into_keys().collect();
            let meant = did_you_mean(&key.value, known.iter().copied());
            let message =
                format!("no cell has {:?}; there are {}{meant}", key.value, known.join(", "));
            return Err(Wrong::at(&key.place, message));
        }
    }
    Ok(Exclusion(entries))
}
