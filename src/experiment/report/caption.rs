//! The caption of a figure: what it shows, how its quantities are defined, how often and where its runs were made, and what
//! is missing from it. Paper and page use the same.

use std::path::{Path, PathBuf};

use super::super::figures::{Clock, FigureKind, FigureSpec, Measure, Relation};
use super::super::results::Done;
use super::super::variable::Quantity;
use super::pool::{Cell, Pool};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::figure::{Panel, Primitive, Scale, Series};
use crate::file;

const RELATIVE_TO_B: &str = "and B the sum of the least costs of all vertices";

/// The caption of a figure of numbers.
pub fn of_numbers(
    pool: &Pool<'_>,
    spec: &FigureSpec,
    cells: &[&Cell<'_>],
    panels: &[Panel],
    timed: bool,
) -> String {
    let mut caption = Caption::of(spec);
    match &spec.kind {
        FigureKind::Decay { x, y } => {
            caption.add(measured(pool, cells, *y));
            caption.add(counted_from(pool, cells, *x));
            caption.add(coinciding(panels));
        }
        FigureKind::Profile { x, .. } => {
            caption.add(format!(
                "The share of instances that a solver solves within a multiple of the {} of the fastest one.",
                x.label()
            ));
            let last = |series: &Series| series.points.last().is_some_and(|point| point[1] < 1.0);
            if panels.iter().flat_map(|panel| &panel.series).any(last) {
                caption.add("A curve that ends below 1 is that of a solver that reached its limits first.");
            }
        }
        FigureKind::Relation(relation) => related(&mut caption, relation, panels),
        FigureKind::Thresholds => caption.add(
            "The energy of the set {u > t}, with labels at vertices and along level lines, above that of U, relative to \
             the energy of U above B, the sum of the least costs of all vertices.",
        ),
        FigureKind::Surface(_) | FigureKind::Evolution(_) | FigureKind::Photographs => {
            unreachable!("pictures have no axes")
        }
    }
    // Wall seconds say on their axis what they include.
    let has_wall_seconds = match &spec.kind {
        FigureKind::Relation(Relation { x, y, .. }) => {
            [x, y].into_iter().any(|variable| variable.is(Quantity::WallSeconds))
        }
        _ => false,
    };
    if timed && !has_wall_seconds {
        caption.add("Seconds are those in steps, without the evaluation of energies and bounds.");
    }
    if panels.iter().any(has_zeros) {
        caption.add("Values of exactly zero have no place on a logarithmic axis.");
    }
    let runs: Vec<&Done> = cells.iter().flat_map(|cell| cell.runs.iter().copied()).collect();
    caption.add(repeated(pool, cells, timed));
    let missing = (cells.len() * pool.spec.repetitions as usize).saturating_sub(runs.len());
    if missing > 0 {
        caption.add(format!("{} missing.", counted(missing, "run is", "runs are")));
    }
    caption.add(machines(pool, &runs, timed));
    caption.text
}

/// The caption of a figure of pictures, whose runs are known.
pub fn of_pictures(pool: &Pool<'_>, spec: &FigureSpec, runs: &[&Done]) -> String {
    let mut caption = Caption::of(spec);
    caption.add(machines(pool, runs, false));
    caption.text
}

fn path(folder: &Path, stem: &str) -> PathBuf {
    folder.join(format!("{stem}.caption.txt"))
}

/// Writes the caption of a figure beside it.
///
/// # Errors
/// The file cannot be written.
pub fn write(folder: &Path, stem: &str, caption: &str) -> Result<()> {
    let text = format!("{caption}\n");
    file::write(&path(folder, stem), |out| out.write_all(text.as_bytes()))
}

/// The caption that was written beside a figure, empty without one.
///
/// # Errors
/// The file is not a text.
pub fn kept(folder: &Path, stem: &str) -> Result<String> {
    let path = path(folder, stem);
    if !path.is_file() {
        return Ok(String::new());
    }
    let text = String::from_utf8(file::read(&path)?)
        .map_err(|error| Error::malformed(&path, error.to_string()))?;
    Ok(text.trim_end().to_owned())
}

/// Sentences.
struct Caption {
    text: String,
}

impl Caption {
    /// What the author says.
    fn of(spec: &FigureSpec) -> Self {
        let mut caption = Caption { text: String::new() };
        caption.add(spec.title.as_deref().unwrap_or(&spec.name));
        caption.add(spec.caption.as_deref().unwrap_or(""));
        caption
    }

    fn add(&mut self, sentence: impl AsRef<str>) {
        let sentence = sentence.as_ref().split_whitespace().collect::<Vec<_>>().join(" ");
        if sentence.is_empty() {
            return;
        }
        if !self.text.is_empty() {
            self.text.push(' ');
        }
        self.text.push_str(&sentence);
        if !sentence.ends_with(['.', '?', '!']) {
            self.text.push('.');
        }
    }
}

fn measured(pool: &Pool<'_>, cells: &[&Cell<'_>], y: Measure) -> String {
    let has_fixed_costs = cells.iter().any(|cell| pool.solver(cell).task.has_fixed_costs());
    match y {
        Measure::Suboptimality if has_fixed_costs => format!(
            "Suboptimality is (E − D*) / (E* − B), with E the energy of a sample, D* the best lower bound and E* the least \
             energy of all runs on the instance, {RELATIVE_TO_B}."
        ),
        Measure::Suboptimality => format!(
            "Suboptimality is (E − E*) / (E* − B), with E the energy of a sample, E* the least energy of all runs on the \
             instance, {RELATIVE_TO_B}."
        ),
        Measure::Gap => format!(
            "The certified gap is (E − D) / (E − B), with E the least energy and D the best lower bound of the run so far, \
             {RELATIVE_TO_B}."
        ),
        Measure::Energy | Measure::Distance | Measure::Mislabeled | Measure::SilhouetteIou => {
            String::new()
        }
    }
}

/// Where the curves start, and what coarser meshes count for.
fn counted_from(pool: &Pool<'_>, cells: &[&Cell<'_>], x: Clock) -> String {
    if x == Clock::Steps {
        return String::new();
    }
    let first = |cell: &&Cell<'_>| {
        let trace = &cell.runs.first()?.trace;
        trace.iter().map(|point| point.iteration).find(|&iteration| iteration > 0)
    };
    let mut firsts: Vec<u64> = cells.iter().filter_map(first).collect();
    firsts.sort_unstable();
    let mut sentence = match (firsts.first(), firsts.last()) {
        (Some(least), Some(most)) if least == most => {
            format!(
                "Curves start at the first sample, after {}.",
                counted(*least as usize, "iteration", "iterations")
            )
        }
        (Some(least), Some(most)) => format!(
            "Curves start at the first sample of each run, after {least} to {}.",
            counted(*most as usize, "iteration", "iterations")
        ),
        _ => String::new(),
    };
    if cells.iter().any(|cell| pool.solver(cell).coarse_to_fine) {
        sentence += match x {
            Clock::Iterations | Clock::Steps => {
                " Coarse to fine counts the iterations on the finest mesh."
            }
            Clock::Seconds => " Coarse to fine counts the seconds on all meshes.",
        };
    }
    sentence
}

fn related(caption: &mut Caption, relation: &Relation, panels: &[Panel]) {
    let series = || panels.iter().flat_map(|panel| &panel.series);
    if relation.y.is(Quantity::Excess) || relation.y.is(Quantity::Bias) {
        caption.add(format!(
            "The best bound D* is that of all runs on the instance; differences are relative to E* − B, with E* the least \
             energy of these runs, {RELATIVE_TO_B}."
        ));
    }
    if series().any(|series| !series.band.is_empty()) {
        caption.add("Bars reach from the first to the third quartile.");
    }
    if series().any(|series| !series.beyond.is_empty()) {
        caption.add("Arrows start where runs ended that did not reach the gap.");
    }
    if series().any(|series| series.primitive == Primitive::Reference) {
        caption.add("Dashed lines in the colors of the marks are powers of x, fitted by least squares of the logarithms.");
    }
    if let Some((label, _)) = &relation.reference {
        caption.add(format!("The mark \u{201c}{label}\u{201d} is taken from the literature."));
    }
}

fn has_zeros(panel: &Panel) -> bool {
    panel.y.scale == Scale::Log
        && panel.series.iter().flat_map(|series| &series.points).any(|point| point[1] == 0.0)
}

/// How close curves that coincide are, as ratios of their values.
const ALIKE: f64 = 1e-2;

/// Which curves lie under others.
fn coinciding(panels: &[Panel]) -> String {
    let mut sentences = Vec::new();
    for panel in panels {
        for (i, upper) in panel.series.iter().enumerate() {
            if let Some(lower) = panel.series[..i].iter().find(|lower| coincide(lower, upper)) {
                let place = match &panel.title {
                    Some(title) if panels.len() > 1 => format!("In {title}, "),
                    _ => String::new(),
                };
                sentences.push(format!(
                    "{place}\u{201c}{}\u{201d} lies on \u{201c}{}\u{201d}.",
                    upper.label, lower.label
                ));
            }
        }
    }
    // The same pair in several panels is said once.
    let pairs: Vec<&str> =
        sentences.iter().filter_map(|s| Some(&s[s.find('\u{201c}')?..])).collect();
    match pairs.split_first() {
        Some((first, others)) if !others.is_empty() && others.iter().all(|pair| pair == first) => {
            let count = sentences.len();
            format!(
                "In {} panels, {first}",
                if count == panels.len() { "all".into() } else { count.to_string() }
            )
        }
        _ => sentences.join(" "),
    }
}

fn coincide(a: &Series, b: &Series) -> bool {
    let alike = |a: f64, b: f64| a == b || (a / b - 1.0).abs() < ALIKE;
    let shared = a.points.len().min(b.points.len());
    shared > 2
        && a.points.len().abs_diff(b.points.len()) * 10 <= shared
        && a.points.iter().zip(&b.points).all(|(a, b)| alike(a[0], b[0]) && alike(a[1], b[1]))
}

fn repeated(pool: &Pool<'_>, cells: &[&Cell<'_>], timed: bool) -> String {
    let counts = cells.iter().map(|cell| match timed {
        true => pool.timed(cell).count(),
        false => cell.runs.len(),
    });
    let counts: Vec<usize> = counts.filter(|&count| count > 0).collect();
    match (counts.iter().min(), counts.iter().max()) {
        (Some(1), Some(1)) => "Each run was made once.".to_owned(),
        (Some(least), Some(most)) if least == most => format!("Medians of {most} runs."),
        (Some(least), Some(most)) => format!("Medians of {least} to {most} runs."),
        _ => String::new(),
    }
}

/// The program, and for times the machine and its load.
fn machines(pool: &Pool<'_>, runs: &[&Done], timed: bool) -> String {
    let mut versions: Vec<&str> =
        runs.iter().map(|run| &run.manifest.program.version[..]).collect();
    versions.sort_unstable();
    versions.dedup();
    let mut sentence = format!("Made by meshseg {}", versions.join(" and "));
    let on_host = |run: &&&Done| run.manifest.machine.host == pool.host;
    if timed && let Some(run) = runs.iter().find(on_host) {
        let machine = &run.manifest.machine;
        sentence += &format!(" on {} ({})", machine.cpu, counted(machine.cores, "core", "cores"));
    }
    sentence.push('.');
    if timed && let Some(note) = pool.note() {
        sentence += &format!(" {note}");
    }
    sentence
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Axis;

    fn panel(title: &str, curves: &[(&str, f64)]) -> Panel {
        let series = curves.iter().enumerate().map(|(style, &(label, factor))| {
            let points = (1..20).map(|i| [f64::from(i), factor / f64::from(i)]).collect();
            Series::new(label, style, Primitive::Line, points)
        });
        Panel {
            title: Some(title.to_owned()),
            x: Axis::new("x", true),
            y: Axis::new("y", true),
            series: series.collect(),
        }
    }

    #[test]
    fn curves_that_lie_on_others_are_named() {
        let apart = panel("a", &[("p", 1.0), ("q", 1.1)]);
        let alike = |title| panel(title, &[("p", 1.0), ("q", 1.001)]);
        assert_eq!(coinciding(&[panel("a", &[]), apart]), "");
        let pair = "\u{201c}q\u{201d} lies on \u{201c}p\u{201d}.";
        assert_eq!(coinciding(&[alike("a")]), pair);
        let apart = panel("c", &[("p", 1.0), ("q", 2.0)]);
        assert_eq!(coinciding(&[alike("a"), apart]), format!("In a, {pair}"));
        assert_eq!(coinciding(&[alike("a"), alike("b")]), format!("In all panels, {pair}"));
    }

    #[test]
    fn zeros_without_a_place_are_noticed() {
        let mut one = panel("a", &[("p", 1.0)]);
        assert!(!has_zeros(&one));
        one.series[0].points.push([30.0, 0.0]);
        assert!(has_zeros(&one));
        one.y = Axis::new("y", false);
        assert!(!has_zeros(&one));
    }
}
