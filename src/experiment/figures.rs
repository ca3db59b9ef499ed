//! What an experiment file asks to be drawn and listed.

use std::ops::Range;

use super::document::{Fits, Placed, Scalar, Section, Wrong};
use super::nearest::did_you_mean;

/// `[[figure]]`.
#[derive(Clone, Debug)]
pub struct FigureSpec {
    pub name: String,
    pub title: Option<String>,
    pub kind: FigureKind,
    /// Whether it is as wide as a page or as a column of it.
    pub page: bool,
    /// Panels beside each other.
    pub columns: usize,
    /// Only instances whose label contains this.
    pub only: Option<String>,
    /// Only solvers whose label contains this.
    pub solvers: Option<String>,
    pub places: Places,
}

/// Where a figure stands in the file, and what of it.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// What is shown: its y, or all of it.
    pub shown: Range<usize>,
    pub only: Range<usize>,
    pub solvers: Range<usize>,
}

#[derive(Clone, Debug)]
pub enum FigureKind {
    /// y over x along the traces, a panel for each instance.
    Decay { x: Clock, y: Measure },
    /// The share of instances solved to a gap, over the time relative to the fastest: E. Dolan, J. Moré,
    /// *Benchmarking optimization software with performance profiles*, Math. Program. 91, 2002.
    Profile { x: Clock, gap: f64 },
    /// One point for each cell.
    Relation {
        x: String,
        y: String,
        /// For `seconds` and `iterations`.
        gap: Option<f64>,
        /// A key by whose values there are panels.
        panels: Option<String>,
        /// Whether a power of x is fitted to each series.
        fit: bool,
        logx: bool,
        logy: bool,
        /// A single point that others report, and its name.
        reference: Option<(String, [f64; 2])>,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    Iterations,
    Seconds,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    Suboptimality,
    Gap,
    Energy,
}

/// What a gap is measured to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// (E - D) / (E - B), D the bound of the run.
    Certificate,
    /// (E - D*) / (E* - B), D* the best bound and E* the least energy of all runs of the instance.
    Optimum,
}

/// `[[table]]`.
#[derive(Clone, Debug)]
pub struct TableSpec {
    pub name: String,
    pub title: Option<String>,
    pub kind: TableKind,
}

#[derive(Clone, Debug)]
pub enum TableKind {
    /// Time and iterations to gaps, instance by instance and solver by solver: those that each run certifies
    /// itself, or those to the best bound of all.
    TimeToGap { gaps: Vec<f64>, to: Target },
    /// Given quantities of every cell.
    Cells { columns: Vec<String> },
}

/// What a relation or a table may show besides the keys of the cells.
pub const QUANTITIES: [&str; 17] = [
    "vertices",
    "faces",
    "iterations",
    "seconds",
    "wall-seconds",
    "energy",
    "bound",
    "gap",
    "excess",
    "bias",
    "optimization-error",
    "rounding-error",
    "labels-changed",
    "rounded-gap",
    "regions-used",
    "mislabeled",
    "status",
];

fn choice<T: Copy>(section: &mut Section<'_>, key: &'static str, names: &[(&str, T)]) -> Fits<T> {
    let Some(Placed { value, place }) = section.text(key)? else { return Ok(names[0].1) };
    let found = names.iter().find(|(name, _)| *name == value);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let meant = did_you_mean(&value, names.iter().map(|(name, _)| *name));
        let names: Vec<String> = names.iter().map(|(name, _)| format!("{name:?}")).collect();
        Wrong::at(&place, format!("{key} must be one of {}{meant}", names.join(", ")))
    })
}

fn name(section: &mut Section<'_>) -> Fits<String> {
    let place = section.place.clone();
    let name = section.text("name")?;
    let name = name.ok_or_else(|| Wrong::at(&place, format!("{} needs name", section.name)))?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.value.is_empty() || !name.value.chars().all(plain) {
        return Err(Wrong::at(&name.place, "name becomes a file: letters, digits, - and _ only"));
    }
    Ok(name.value)
}

fn positive(section: &mut Section<'_>, key: &'static str) -> Fits<Option<f64>> {
    match section.number(key)? {
        Some(Placed { value, .. }) if value > 0.0 => Ok(Some(value)),
        Some(Placed { place, .. }) => Err(Wrong::at(&place, format!("{key} must be positive"))),
        None => Ok(None),
    }
}

/// A key of the cells or one of [`QUANTITIES`].
fn quantity(Placed { value, place }: Placed<String>) -> Fits<String> {
    let keys = ["mesh", "data", "noise", "seed", "regions", "lambda", "mass", "solver", "threads"];
    let known = value.starts_with("options.")
        || keys.contains(&value.as_str())
        || QUANTITIES.contains(&value.as_str());
    if known {
        return Ok(value);
    }
    let meant = did_you_mean(&value, keys.into_iter().chain(QUANTITIES));
    let message = format!(
        "{value:?} is nothing to show; there are options.KEY, {}, {}{meant}",
        keys.join(", "),
        QUANTITIES.join(", ")
    );
    Err(Wrong::at(&place, message))
}

const CLOCKS: [(&str, Clock); 2] = [("iterations", Clock::Iterations), ("seconds", Clock::Seconds)];

#[derive(Clone, Copy)]
enum Kind {
    Decay,
    Profile,
    Relation,
}

impl FigureSpec {
    pub(super) fn read(mut section: Section<'_>) -> Fits<Self> {
        let mut places = Places { shown: section.place.clone(), ..Places::default() };
        let name = name(&mut section)?;
        let title = section.text("title")?.map(|title| title.value);
        let kinds =
            [("decay", Kind::Decay), ("profile", Kind::Profile), ("relation", Kind::Relation)];
        let kind = match choice(&mut section, "kind", &kinds)? {
            Kind::Decay => FigureKind::Decay {
                x: choice(&mut section, "x", &CLOCKS)?,
                y: choice(
                    &mut section,
                    "y",
                    &[
                        ("suboptimality", Measure::Suboptimality),
                        ("gap", Measure::Gap),
                        ("energy", Measure::Energy),
                    ],
                )?,
            },
            Kind::Profile => FigureKind::Profile {
                x: choice(&mut section, "x", &CLOCKS)?,
                gap: positive(&mut section, "gap")?.unwrap_or(1e-3),
            },
            Kind::Relation => {
                let place = section.place.clone();
                let mut axis = |key: &'static str| match section.text(key)? {
                    Some(text) => {
                        let place = text.place.clone();
                        Ok((quantity(text)?, place))
                    }
                    None => Err(Wrong::at(&place, format!("a relation needs {key}"))),
                };
                let ((x, _), (y, shown)) = (axis("x")?, axis("y")?);
                places.shown = shown;
                let reference = match section.list("reference")? {
                    None => None,
                    Some(list) => match &list[..] {
                        [Placed { value: Scalar::Text(label), .. }, x, y] => {
                            match (x.value.number(), y.value.number()) {
                                (Some(x), Some(y)) => Some((label.clone(), [x, y])),
                                _ => {
                                    return Err(Wrong::at(
                                        &x.place,
                                        "reference = [\"label\", x, y]",
                                    ));
                                }
                            }
                        }
                        _ => {
                            return Err(Wrong::at(&list[0].place, "reference = [\"label\", x, y]"));
                        }
                    },
                };
                FigureKind::Relation {
                    x,
                    y,
                    gap: positive(&mut section, "gap")?,
                    panels: section.text("panels")?.map(quantity).transpose()?,
                    fit: section.truth("fit")?.unwrap_or(false),
                    logx: section.truth("log-x")?.unwrap_or(true),
                    logy: section.truth("log-y")?.unwrap_or(true),
                    reference,
                }
            }
        };
        let page = choice(&mut section, "width", &[("page", true), ("column", false)])?;
        let columns = section.count("columns", 1)?;
        let mut filter = |key: &'static str, place: &mut Range<usize>| {
            Ok(section.text(key)?.map(|text| {
                *place = text.place;
                text.value
            }))
        };
        let only = filter("only", &mut places.only)?;
        let solvers = filter("solvers", &mut places.solvers)?;
        let figure = FigureSpec {
            name,
            title,
            kind,
            page,
            columns: columns.map_or(if page { 2 } else { 1 }, |columns| columns.value as usize),
            only,
            solvers,
            places,
        };
        section.end()?;
        Ok(figure)
    }
}

impl FigureSpec {
    /// What of the cells it shows, if it shows cells.
    pub fn quantities(&self) -> Vec<&str> {
        match &self.kind {
            FigureKind::Relation { x, y, .. } => vec![x, y],
            FigureKind::Decay { .. } | FigureKind::Profile { .. } => Vec::new(),
        }
    }
}

impl TableSpec {
    /// What of the cells it lists, if it lists cells.
    pub fn quantities(&self) -> Vec<&str> {
        match &self.kind {
            TableKind::Cells { columns } => columns.iter().map(String::as_str).collect(),
            TableKind::TimeToGap { .. } => Vec::new(),
        }
    }

    pub(super) fn read(mut section: Section<'_>) -> Fits<Self> {
        let name = name(&mut section)?;
        let title = section.text("title")?.map(|title| title.value);
        let kind = if choice(&mut section, "kind", &[("time-to-gap", true), ("cells", false)])? {
            let gaps = section.list("gaps")?.unwrap_or_default();
            let gaps: Vec<f64> = gaps
                .iter()
                .map(|gap| match gap.value.number() {
                    Some(value) if value > 0.0 => Ok(value),
                    _ => Err(Wrong::at(&gap.place, "gaps must be positive numbers")),
                })
                .collect::<Fits<_>>()?;
            let targets = [("certificate", Target::Certificate), ("optimum", Target::Optimum)];
            TableKind::TimeToGap {
                to: choice(&mut section, "to", &targets)?,
                gaps: if gaps.is_empty() { vec![1e-2, 1e-3, 1e-4] } else { gaps },
            }
        } else {
            let place = section.place.clone();
            let columns =
                section.texts("columns")?.into_iter().map(quantity).collect::<Fits<Vec<_>>>()?;
            if columns.is_empty() {
                return Err(Wrong::at(&place, "a table of cells needs columns = [...]"));
            }
            TableKind::Cells { columns }
        };
        section.end()?;
        Ok(TableSpec { name, title, kind })
    }
}
