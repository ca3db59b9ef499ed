//! What an experiment file asks to be drawn and listed.

use std::ops::Range;

use super::document::{Fits, Scalar, Section, Spanned, Wrong};
use super::nearest::did_you_mean;
use super::variable::Variable;

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
    pub spans: FigureSpans,
}

/// The spans of a figure in the file.
#[derive(Clone, Debug, Default)]
pub struct FigureSpans {
    /// What is shown: its y, or all of it.
    pub shown: Range<usize>,
    pub only: Range<usize>,
    pub solvers: Range<usize>,
}

#[derive(Clone, Debug)]
pub enum FigureKind {
    /// y over x along the traces, a panel for each instance.
    Decay {
        x: Clock,
        y: Measure,
    },
    /// The share of instances solved to a gap, over the time relative to the fastest: E. Dolan, J. Moré,
    /// *Benchmarking optimization software with performance profiles*, Math. Program. 91, 2002.
    Profile {
        x: Clock,
        gap: f64,
    },
    Relation(Relation),
}

/// One point for each cell.
#[derive(Clone, Debug)]
pub struct Relation {
    pub x: Variable,
    pub y: Variable,
    /// For `seconds` and `iterations`.
    pub gap: Option<f64>,
    /// A key by whose values there are panels.
    pub panels: Option<Variable>,
    /// Whether a power of x is fitted to each series.
    pub fit: bool,
    pub logx: bool,
    pub logy: bool,
    /// A single point that others report, and its name.
    pub reference: Option<(String, [f64; 2])>,
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
    /// Given variables of every cell.
    Cells { columns: Vec<Variable> },
}

fn choice<T: Copy>(section: &mut Section<'_>, key: &'static str, names: &[(&str, T)]) -> Fits<T> {
    let Some(Spanned { value, span }) = section.text(key)? else { return Ok(names[0].1) };
    let found = names.iter().find(|(name, _)| *name == value);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let meant = did_you_mean(&value, names.iter().map(|(name, _)| *name));
        let names: Vec<String> = names.iter().map(|(name, _)| format!("{name:?}")).collect();
        Wrong::at(&span, format!("{key} must be one of {}{meant}", names.join(", ")))
    })
}

fn name(section: &mut Section<'_>) -> Fits<String> {
    let span = section.span.clone();
    let name = section.text("name")?;
    let name = name.ok_or_else(|| Wrong::at(&span, format!("{} needs name", section.name)))?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.value.is_empty() || !name.value.chars().all(plain) {
        return Err(Wrong::at(&name.span, "name becomes a file: letters, digits, - and _ only"));
    }
    Ok(name.value)
}

fn positive(section: &mut Section<'_>, key: &'static str) -> Fits<Option<f64>> {
    match section.number(key)? {
        Some(Spanned { value, .. }) if value > 0.0 => Ok(Some(value)),
        Some(Spanned { span, .. }) => Err(Wrong::at(&span, format!("{key} must be positive"))),
        None => Ok(None),
    }
}

fn variable(Spanned { value, span }: Spanned<String>) -> Fits<Variable> {
    value.parse().map_err(|message: String| Wrong::at(&span, message))
}

const CLOCKS: [(&str, Clock); 2] = [("iterations", Clock::Iterations), ("seconds", Clock::Seconds)];

/// A kind of figure as its keys have it, and the span of what it shows, if that is less than the whole table.
type KindRead = (FigureKind, Option<Range<usize>>);

type KindReader = fn(&mut Section<'_>) -> Fits<KindRead>;

fn read_decay(section: &mut Section<'_>) -> Fits<KindRead> {
    let measures = [
        ("suboptimality", Measure::Suboptimality),
        ("gap", Measure::Gap),
        ("energy", Measure::Energy),
    ];
    let x = choice(section, "x", &CLOCKS)?;
    let y = choice(section, "y", &measures)?;
    Ok((FigureKind::Decay { x, y }, None))
}

fn read_profile(section: &mut Section<'_>) -> Fits<KindRead> {
    let x = choice(section, "x", &CLOCKS)?;
    let gap = positive(section, "gap")?.unwrap_or(1e-3);
    Ok((FigureKind::Profile { x, gap }, None))
}

fn read_relation(section: &mut Section<'_>) -> Fits<KindRead> {
    let table = section.span.clone();
    let mut axis = |key: &'static str| match section.text(key)? {
        Some(text) => Ok((text.span.clone(), variable(text)?)),
        None => Err(Wrong::at(&table, format!("a relation needs {key}"))),
    };
    let (_, x) = axis("x")?;
    let (shown, y) = axis("y")?;
    let reference = section.list("reference")?.map(read_reference).transpose()?;
    let relation = Relation {
        x,
        y,
        gap: positive(section, "gap")?,
        panels: section.text("panels")?.map(variable).transpose()?,
        fit: section.truth("fit")?.unwrap_or(false),
        logx: section.truth("log-x")?.unwrap_or(true),
        logy: section.truth("log-y")?.unwrap_or(true),
        reference,
    };
    Ok((FigureKind::Relation(relation), Some(shown)))
}

/// A point and its label.
fn read_reference(list: Vec<Spanned<Scalar>>) -> Fits<(String, [f64; 2])> {
    let wrong = |span| Wrong::at(span, "reference = [\"label\", x, y]");
    let [Spanned { value: Scalar::Text(label), .. }, x, y] = &list[..] else {
        return Err(wrong(&list[0].span));
    };
    match (x.value.number(), y.value.number()) {
        (Some(x), Some(y)) => Ok((label.clone(), [x, y])),
        _ => Err(wrong(&x.span)),
    }
}

impl FigureSpec {
    pub(super) fn read(mut section: Section<'_>) -> Fits<Self> {
        let table = section.span.clone();
        let name = name(&mut section)?;
        let title = section.text("title")?.map(|title| title.value);
        let kinds: [(&str, KindReader); 3] =
            [("decay", read_decay), ("profile", read_profile), ("relation", read_relation)];
        let (kind, shown) = choice(&mut section, "kind", &kinds)?(&mut section)?;
        let page = choice(&mut section, "width", &[("page", true), ("column", false)])?;
        let columns = section.count("columns", 1)?;
        let only = section.text("only")?;
        let solvers = section.text("solvers")?;
        section.end()?;
        let span = |text: &Option<Spanned<String>>| {
            text.as_ref().map_or(Range::default(), |text| text.span.clone())
        };
        Ok(FigureSpec {
            name,
            title,
            kind,
            page,
            columns: columns.map_or(if page { 2 } else { 1 }, |columns| columns.value as usize),
            spans: FigureSpans {
                shown: shown.unwrap_or(table),
                only: span(&only),
                solvers: span(&solvers),
            },
            only: only.map(|text| text.value),
            solvers: solvers.map(|text| text.value),
        })
    }
}

impl FigureSpec {
    /// What of the cells it shows, if it shows cells.
    pub fn variables(&self) -> Vec<&Variable> {
        match &self.kind {
            FigureKind::Relation(Relation { x, y, .. }) => vec![x, y],
            FigureKind::Decay { .. } | FigureKind::Profile { .. } => Vec::new(),
        }
    }
}

impl TableSpec {
    /// What of the cells it lists, if it lists cells.
    pub fn variables(&self) -> Vec<&Variable> {
        match &self.kind {
            TableKind::Cells { columns } => columns.iter().collect(),
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
                    _ => Err(Wrong::at(&gap.span, "gaps must be positive numbers")),
                })
                .collect::<Fits<_>>()?;
            let targets = [("certificate", Target::Certificate), ("optimum", Target::Optimum)];
            TableKind::TimeToGap {
                to: choice(&mut section, "to", &targets)?,
                gaps: if gaps.is_empty() { vec![1e-2, 1e-3, 1e-4] } else { gaps },
            }
        } else {
            let span = section.span.clone();
            let columns =
                section.texts("columns")?.into_iter().map(variable).collect::<Fits<Vec<_>>>()?;
            if columns.is_empty() {
                return Err(Wrong::at(&span, "a table of cells needs columns = [...]"));
            }
            TableKind::Cells { columns }
        };
        section.end()?;
        Ok(TableSpec { name, title, kind })
    }
}
