//! The figures and tables that an experiment file requests.

use std::ops::Range;

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::document::{Scalar, Section, SpanError, SpanResult, Spanned};
use super::nearest::did_you_mean;
use super::variable::Variable;
use crate::names::{Named, must_be_one_of};
use crate::render::View;
use crate::render::panels::Shown;

/// What a figure or a table shows: parts of labels, or `=` and a whole label; all if there are none.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Of instances.
    pub only: Vec<Spanned<String>>,
    /// Of solvers.
    pub solvers: Vec<Spanned<String>>,
}

/// `[[figure]]`.
#[derive(Clone, Debug)]
pub struct FigureSpec {
    pub name: String,
    pub title: Option<String>,
    pub kind: FigureKind,
    /// Whether it is as wide as a page; otherwise as a column.
    pub page: bool,
    /// Panels in a row.
    pub columns: usize,
    pub selection: Selection,
    /// What the author says in the caption, after the title.
    pub caption: Option<String>,
    /// The span of the content in the file: the key y, or the whole table.
    pub shown: Range<usize>,
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
    Surface(SurfaceFigure),
    Evolution(EvolutionFigure),
    /// Silhouettes and cuts of reconstructed surfaces in some of their photographs, one run below the other.
    Photographs,
    /// (E(t) - E) / (E - B) over the thresholds t of two regions, of labels and of level lines, a panel for each instance.
    Thresholds,
}

impl FigureKind {
    /// Whether it is a PNG file, not drawn from numbers.
    pub fn is_picture(&self) -> bool {
        matches!(self, FigureKind::Surface(_) | FigureKind::Evolution(_) | FigureKind::Photographs)
    }
}

/// Pictures of the instances, a row for each: what needs no regions once, all else for each solver.
#[derive(Clone, Debug)]
pub struct SurfaceFigure {
    /// The quantities, at least one.
    pub show: Vec<Shown>,
    /// From where each surface is seen, at least one.
    pub views: Vec<View>,
}

/// Surfaces on the way: a row for each reconstruction, and a column for each number of steps, for its end and for the truth.
#[derive(Clone, Debug)]
pub struct EvolutionFigure {
    /// Numbers of steps, ascending.
    pub steps: Vec<usize>,
    /// From where each surface is seen, at least one.
    pub views: Vec<View>,
}

/// One point for each cell.
#[derive(Clone, Debug)]
pub struct Relation {
    pub x: Variable,
    pub y: Variable,
    /// For `seconds` and `iterations`.
    pub gap: Option<f64>,
    /// A key with one panel for each of its values.
    pub panels: Option<Variable>,
    /// Whether a power of x is fitted to each series.
    pub fit: bool,
    pub logx: bool,
    pub logy: bool,
    /// A point from the literature and its name.
    pub reference: Option<(String, [f64; 2])>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Clock {
    Iterations,
    Seconds,
    /// Of a surface.
    Steps,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Measure {
    Suboptimality,
    Gap,
    Energy,
    /// Of a surface, as the next two.
    Distance,
    Mislabeled,
    SilhouetteIou,
}

impl Measure {
    /// The label of its axis.
    pub fn label(self) -> &'static str {
        match self {
            Measure::Suboptimality => "suboptimality",
            Measure::Gap => "certified gap",
            Measure::Energy => "energy",
            Measure::Distance => "mean distance to the truth / diagonal",
            Measure::Mislabeled => "share that is mislabeled",
            Measure::SilhouetteIou => "agreement of silhouettes",
        }
    }

    /// Whether only surfaces that evolve have it.
    pub fn is_of_surfaces(self) -> bool {
        matches!(self, Measure::Distance | Measure::Mislabeled | Measure::SilhouetteIou)
    }

    /// Whether its axis is logarithmic.
    pub fn is_logarithmic(self) -> bool {
        !matches!(self, Measure::Energy | Measure::SilhouetteIou)
    }
}

/// The bound that a gap is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Target {
    /// (E - D) / (E - B), D the bound of the run.
    Certificate,
    /// (E - D*) / (E* - B), D* the best bound and E* the minimum energy of all runs of the instance.
    Optimum,
}

/// `[[table]]`.
#[derive(Clone, Debug)]
pub struct TableSpec {
    pub name: String,
    pub title: Option<String>,
    pub kind: TableKind,
    pub selection: Selection,
    /// Columns of names that are left out in LaTeX.
    pub without: Vec<NameColumn>,
}

/// The columns of a table that name its rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum NameColumn {
    Instance,
    Solver,
}

#[derive(Clone, Debug)]
pub enum TableKind {
    /// Time and iterations to gaps for every instance and solver: to the gaps that each run certifies itself, or to
    /// gaps from the best bound of all runs.
    TimeToGap {
        gaps: Vec<f64>,
        to: Target,
        /// Both, or one.
        clocks: Vec<Clock>,
    },
    /// Given variables of every cell.
    Cells { columns: Vec<Variable> },
}

/// The values of the key `kind` of a figure.
#[derive(Clone, Copy, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
enum FigureKindName {
    Decay,
    Profile,
    Relation,
    Surface,
    Evolution,
    Photographs,
    Thresholds,
}

/// The values of the key `width` of a figure.
#[derive(Clone, Copy, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
enum WidthName {
    Page,
    Column,
}

/// The values of the key `kind` of a table.
#[derive(Clone, Copy, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
enum TableKindName {
    TimeToGap,
    Cells,
}

fn choice<T: Named>(section: &mut Section<'_>, key: &'static str, default: T) -> SpanResult<T> {
    section.text(key)?.map_or(Ok(default), |text| one_of(key, text))
}

/// The clocks of a table of times, by default iterations and seconds.
fn clocks(section: &mut Section<'_>) -> SpanResult<Vec<Clock>> {
    Ok(match section.text("clock")? {
        None => vec![Clock::Iterations, Clock::Seconds],
        Some(text) => match one_of("clock", text.clone())? {
            Clock::Steps => {
                let message = "clock must be iterations or seconds; steps are those of surfaces";
                return Err(SpanError::at(&text.span, message));
            }
            clock => vec![clock],
        },
    })
}

fn one_of<T: Named>(key: &str, Spanned { value, span }: Spanned<String>) -> SpanResult<T> {
    T::named(&value).ok_or_else(|| {
        let meant = did_you_mean(&value, T::names().iter().copied());
        let quoted = T::names().iter().map(|name| format!("{name:?}"));
        SpanError::at(&span, format!("{key} {}{meant}", must_be_one_of(quoted)))
    })
}

fn name(section: &mut Section<'_>) -> SpanResult<String> {
    let span = section.span.clone();
    let name = section.text("name")?;
    let name = name.ok_or_else(|| SpanError::at(&span, format!("{} needs name", section.name)))?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.value.is_empty() || !name.value.chars().all(plain) {
        return Err(SpanError::at(
            &name.span,
            "name becomes a file name: only letters, digits, - and _ are allowed",
        ));
    }
    Ok(name.value)
}

fn positive(section: &mut Section<'_>, key: &'static str) -> SpanResult<Option<f64>> {
    match section.number(key)? {
        Some(Spanned { value, .. }) if value > 0.0 => Ok(Some(value)),
        Some(Spanned { span, .. }) => Err(SpanError::at(&span, format!("{key} must be positive"))),
        None => Ok(None),
    }
}

fn variable(Spanned { value, span }: Spanned<String>) -> SpanResult<Variable> {
    value.parse().map_err(|message: String| SpanError::at(&span, message))
}

/// A kind of figure with its settings, and the span of its content if that is not the whole table.
type KindRead = (FigureKind, Option<Range<usize>>);

fn read_decay(section: &mut Section<'_>) -> SpanResult<KindRead> {
    let x = choice(section, "x", Clock::Iterations)?;
    let y = choice(section, "y", Measure::Suboptimality)?;
    Ok((FigureKind::Decay { x, y }, None))
}

fn read_profile(section: &mut Section<'_>) -> SpanResult<KindRead> {
    let x = choice(section, "x", Clock::Iterations)?;
    let gap = positive(section, "gap")?.unwrap_or(1e-3);
    Ok((FigureKind::Profile { x, gap }, None))
}

fn read_relation(section: &mut Section<'_>) -> SpanResult<KindRead> {
    let table = section.span.clone();
    let mut axis = |key: &'static str| match section.text(key)? {
        Some(text) => Ok((text.span.clone(), variable(text)?)),
        None => Err(SpanError::at(&table, format!("a relation needs {key}"))),
    };
    let (_, x) = axis("x")?;
    let (shown, y) = axis("y")?;
    let reference = section.list("reference")?.map(read_reference).transpose()?;
    let relation = Relation {
        x,
        y,
        gap: positive(section, "gap")?,
        panels: section.text("panels")?.map(variable).transpose()?,
        fit: section.boolean("fit")?.unwrap_or(false),
        logx: section.boolean("log-x")?.unwrap_or(true),
        logy: section.boolean("log-y")?.unwrap_or(true),
        reference,
    };
    Ok((FigureKind::Relation(relation), Some(shown)))
}

fn read_surface(section: &mut Section<'_>) -> SpanResult<KindRead> {
    let table = section.span.clone();
    let parsed = |Spanned { value, span }: Spanned<String>| {
        value.parse().map_err(|message: String| SpanError::at(&span, format!("show {message}")))
    };
    let show: Vec<Shown> =
        section.texts("show")?.into_iter().map(parsed).collect::<SpanResult<_>>()?;
    if show.is_empty() {
        let message = format!("a figure of surfaces needs show = [...]: {}", Shown::SYNTAX);
        return Err(SpanError::at(&table, message));
    }
    let views = read_views(section)?;
    Ok((FigureKind::Surface(SurfaceFigure { show, views }), None))
}

fn read_views(section: &mut Section<'_>) -> SpanResult<Vec<View>> {
    let parsed = |Spanned { value, span }: Spanned<String>| {
        value.parse().map_err(|message: String| SpanError::at(&span, format!("views {message}")))
    };
    let mut views: Vec<View> =
        section.texts("views")?.into_iter().map(parsed).collect::<SpanResult<_>>()?;
    if views.is_empty() {
        views.push(View::Auto);
    }
    Ok(views)
}

/// The columns of an evolution, without those of its end and of the truth.
const DEFAULT_STEPS: [usize; 4] = [0, 5, 10, 20];

fn read_evolution(section: &mut Section<'_>) -> SpanResult<KindRead> {
    let steps = match section.list("steps")? {
        None => DEFAULT_STEPS.to_vec(),
        Some(list) => {
            let mut steps: Vec<usize> = Vec::new();
            for Spanned { value, span } in list {
                let step = match value {
                    Scalar::Integer(step) => usize::try_from(step).ok(),
                    _ => None,
                };
                let step = step.filter(|step| steps.last().is_none_or(|last| last < step));
                steps.push(step.ok_or_else(|| {
                    SpanError::at(&span, "steps must be whole numbers in ascending order")
                })?);
            }
            steps
        }
    };
    Ok((FigureKind::Evolution(EvolutionFigure { steps, views: read_views(section)? }), None))
}

impl Selection {
    fn read(section: &mut Section<'_>) -> SpanResult<Self> {
        Ok(Selection { only: section.texts("only")?, solvers: section.texts("solvers")? })
    }

    /// Whether it has an instance with a label.
    pub fn has_instance(&self, label: &str) -> bool {
        is_selected(label, &self.only)
    }

    /// Whether it has a solver with a label.
    pub fn has_solver(&self, label: &str) -> bool {
        is_selected(label, &self.solvers)
    }
}

fn is_selected(label: &str, wanted: &[Spanned<String>]) -> bool {
    wanted.is_empty() || wanted.iter().any(|wanted| matches(label, &wanted.value))
}

/// Whether a label is what follows `=`, or contains what is wanted.
pub fn matches(label: &str, wanted: &str) -> bool {
    match wanted.strip_prefix('=') {
        Some(whole) => label == whole,
        None => label.contains(wanted),
    }
}

/// A point and its label.
fn read_reference(list: Vec<Spanned<Scalar>>) -> SpanResult<(String, [f64; 2])> {
    let wrong = |span| SpanError::at(span, "reference = [\"label\", x, y]");
    let [Spanned { value: Scalar::Text(label), .. }, x, y] = &list[..] else {
        return Err(wrong(&list[0].span));
    };
    match (x.value.number(), y.value.number()) {
        (Some(x), Some(y)) => Ok((label.clone(), [x, y])),
        _ => Err(wrong(&x.span)),
    }
}

impl FigureSpec {
    pub(super) fn read(mut section: Section<'_>) -> SpanResult<Self> {
        let table = section.span.clone();
        let name = name(&mut section)?;
        let title = section.text("title")?.map(|title| title.value);
        let (kind, shown) = match choice(&mut section, "kind", FigureKindName::Decay)? {
            FigureKindName::Decay => read_decay(&mut section),
            FigureKindName::Profile => read_profile(&mut section),
            FigureKindName::Relation => read_relation(&mut section),
            FigureKindName::Surface => read_surface(&mut section),
            FigureKindName::Evolution => read_evolution(&mut section),
            FigureKindName::Photographs => Ok((FigureKind::Photographs, None)),
            FigureKindName::Thresholds => Ok((FigureKind::Thresholds, None)),
        }?;
        let page = choice(&mut section, "width", WidthName::Page)? == WidthName::Page;
        let columns = section.count("columns", 1)?;
        let selection = Selection::read(&mut section)?;
        let caption = section.text("caption")?.map(|caption| caption.value);
        section.end()?;
        Ok(FigureSpec {
            name,
            title,
            kind,
            page,
            columns: columns.map_or(if page { 2 } else { 1 }, |columns| columns.value as usize),
            selection,
            caption,
            shown: shown.unwrap_or(table),
        })
    }

    /// The variables of the cells that it shows.
    pub fn variables(&self) -> Vec<&Variable> {
        match &self.kind {
            FigureKind::Relation(Relation { x, y, .. }) => vec![x, y],
            FigureKind::Decay { .. }
            | FigureKind::Profile { .. }
            | FigureKind::Surface(_)
            | FigureKind::Evolution(_)
            | FigureKind::Photographs
            | FigureKind::Thresholds => Vec::new(),
        }
    }
}

impl TableSpec {
    /// The variables of the cells that it lists.
    pub fn variables(&self) -> Vec<&Variable> {
        match &self.kind {
            TableKind::Cells { columns } => columns.iter().collect(),
            TableKind::TimeToGap { .. } => Vec::new(),
        }
    }

    pub(super) fn read(mut section: Section<'_>) -> SpanResult<Self> {
        let name = name(&mut section)?;
        let title = section.text("title")?.map(|title| title.value);
        let kind = match choice(&mut section, "kind", TableKindName::TimeToGap)? {
            TableKindName::TimeToGap => {
                let gaps = section.list("gaps")?.unwrap_or_default();
                let gaps: Vec<f64> = gaps
                    .iter()
                    .map(|gap| match gap.value.number() {
                        Some(value) if value > 0.0 => Ok(value),
                        _ => Err(SpanError::at(&gap.span, "gaps must be positive numbers")),
                    })
                    .collect::<SpanResult<_>>()?;
                TableKind::TimeToGap {
                    clocks: clocks(&mut section)?,
                    to: choice(&mut section, "to", Target::Certificate)?,
                    gaps: if gaps.is_empty() { vec![1e-2, 1e-3, 1e-4] } else { gaps },
                }
            }
            TableKindName::Cells => {
                let span = section.span.clone();
                let columns = section
                    .texts("columns")?
                    .into_iter()
                    .map(variable)
                    .collect::<SpanResult<Vec<_>>>()?;
                if columns.is_empty() {
                    return Err(SpanError::at(&span, "a table of cells needs columns = [...]"));
                }
                TableKind::Cells { columns }
            }
        };
        let selection = Selection::read(&mut section)?;
        let without = section.texts("without")?;
        let without = without.into_iter().map(|text| one_of("without", text));
        let without = without.collect::<SpanResult<_>>()?;
        section.end()?;
        Ok(TableSpec { name, title, kind, selection, without })
    }
}
