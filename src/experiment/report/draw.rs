//! The figures of an experiment file, as plain numbers.

use std::collections::BTreeSet;

use super::super::figures::{Clock, FigureKind, FigureSpec, Measure, Target};
use super::super::results::{Done, Point};
use super::super::variable::Variable;
use super::caption;
use super::pool::{Cell, Peers, Pool, given};
use super::relation::relation;
use crate::figure::{Axis, COLOR_COUNT, Figure, Panel, Primitive, Series, Width};
use crate::level_sets::LevelSet;

/// A figure, its caption and the runs behind its numbers.
pub struct Drawn<'a> {
    pub figure: Figure,
    pub caption: String,
    pub sources: Vec<&'a Done>,
}

/// Draws a figure of numbers. Panics if it is one of pictures.
pub fn draw<'a>(pool: &Pool<'a>, spec: &FigureSpec) -> Drawn<'a> {
    let cells = pool.selected(&spec.selection);
    let styles = styles(pool, &cells);
    let (panels, timed) = match &spec.kind {
        FigureKind::Decay { x, y } => (decay(pool, &cells, &styles, *x, *y), *x == Clock::Seconds),
        FigureKind::Profile { x, gap } => {
            (vec![profile(pool, &cells, &styles, *x, *gap)], *x == Clock::Seconds)
        }
        FigureKind::Relation(spec) => {
            let timed = [&spec.x, &spec.y].into_iter().any(Variable::is_time);
            (relation(pool, &cells, spec), timed)
        }
        FigureKind::Thresholds => (thresholds(pool, &cells), false),
        FigureKind::Surface(_) | FigureKind::Evolution(_) | FigureKind::Photographs => {
            unreachable!("pictures have files of their own")
        }
    };
    let caption = caption::of_numbers(pool, spec, &cells, &panels, timed);
    let width = if spec.page { Width::Page } else { Width::Column };
    // Panels of a relation are compared; those of other figures are different problems.
    let shared = matches!(spec.kind, FigureKind::Relation(_));
    let figure = Figure { panels, width, columns: spec.columns, shared };
    let counts = |run: &&Done| !timed || run.manifest.machine.host == pool.host;
    let sources = cells.iter().flat_map(|cell| cell.runs.iter().copied()).filter(counts).collect();
    Drawn { figure, caption, sources }
}

/// The style of each solver: its index in the file, as in all figures and on the page. If this gives two solvers of a
/// figure the same color, its solvers are numbered by themselves.
fn styles(pool: &Pool<'_>, cells: &[&Cell<'_>]) -> Vec<usize> {
    let mut styles: Vec<usize> = (0..pool.spec.solvers.len()).collect();
    let shown: BTreeSet<usize> = cells.iter().map(|cell| cell.solver).collect();
    let colors: BTreeSet<usize> = shown.iter().map(|solver| solver % COLOR_COUNT).collect();
    if colors.len() < shown.len() {
        for (rank, solver) in shown.into_iter().enumerate() {
            styles[solver] = rank;
        }
    }
    styles
}

/// A panel for each instance, a curve for each solver.
fn decay<'a>(
    pool: &Pool<'a>,
    cells: &[&Cell<'a>],
    styles: &[usize],
    x: Clock,
    y: Measure,
) -> Vec<Panel> {
    let mut instances: Vec<usize> = cells.iter().map(|cell| cell.instance).collect();
    instances.dedup();
    let measure = |peers: &Peers<'_>, point: &Point| match y {
        Measure::Suboptimality => Some(peers.suboptimality(point.energy)),
        Measure::Gap => point.relative_gap,
        Measure::Energy => Some(point.energy),
        Measure::Distance => point.distance,
        Measure::Mislabeled => point.mislabeled,
        Measure::SilhouetteIou => point.silhouette_iou,
    };
    // Surfaces are also measured before the first step.
    let logx = x != Clock::Steps && !y.is_of_surfaces();
    let panel = |instance: usize| {
        let series = cells.iter().filter(|cell| cell.instance == instance).map(|cell| {
            let peers = pool.peers(cell);
            let bound = peers.bound();
            let points = pool
                .trace(cell, x == Clock::Seconds)
                .iter()
                // The start has a time if coarser meshes were solved before, but nothing was done with it yet.
                .filter(|point| point.iteration > 0 || !logx)
                .filter_map(|point| Some([x.of(point), measure(&peers, point)?]))
                .filter(|[x, _]| *x > 0.0 || !logx)
                .filter(|[_, y]| bound.is_finite() || y.is_finite())
                .collect();
            let label = &pool.solver(cell).label;
            Series::new(label, styles[cell.solver], Primitive::LineMarks, points)
        });
        let series: Vec<Series> = series.filter(|series| !series.points.is_empty()).collect();
        (!series.is_empty()).then(|| Panel {
            title: Some(pool.spec.instances[instance].label.clone()),
            x: Axis::new(x.label(), logx),
            y: Axis::new(y.label(), y.is_logarithmic()),
            series,
        })
    };
    instances.into_iter().filter_map(panel).collect()
}

/// A panel for each instance, for each solver the labels and the level lines of its thresholds.
fn thresholds<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>]) -> Vec<Panel> {
    let of_instance = |cells: &[&Cell<'a>]| {
        let mut series = Vec::new();
        for cell in cells {
            let found =
                cell.runs.iter().find_map(|run| Some((run, run.manifest.level_sets.as_ref()?)));
            let Some((run, sets)) = found else { continue };
            let Some(summary) = run.summary.labels() else { continue };
            let above = |difference: f64| difference / (summary.energy - summary.baseline);
            type Energy = fn(&LevelSet) -> f64;
            let kinds: [(&str, Energy); 2] =
                [("labels", |set| set.labels), ("level lines", |set| set.lines)];
            for (i, (name, energy)) in kinds.into_iter().enumerate() {
                let label = format!("{}: {name}", pool.solver(cell).label);
                let points = sets.iter().map(|set| [set.threshold, above(energy(set))]).collect();
                series.push(Series::new(label, 2 * cell.solver + i, Primitive::LineMarks, points));
            }
        }
        (!series.is_empty()).then(|| Panel {
            title: Some(pool.instance(cells[0]).label.clone()),
            x: Axis::new("threshold t", false),
            y: Axis::new("energy of {u > t} above E(U)", false),
            series,
        })
    };
    cells.chunk_by(|a, b| a.instance == b.instance).filter_map(of_instance).collect()
}

/// The share of instances that a solver solves to a gap within a multiple of the time of the fastest solver.
fn profile<'a>(
    pool: &Pool<'a>,
    cells: &[&Cell<'a>],
    styles: &[usize],
    x: Clock,
    gap: f64,
) -> Panel {
    let time = |cell: &Cell<'a>| {
        pool.time_to(cell, x, gap, Target::Certificate)
            .map_or(f64::INFINITY, |spread| spread.median)
    };
    let mut instances: Vec<usize> = cells.iter().map(|cell| cell.instance).collect();
    instances.dedup();
    let fastest = |instance: usize| {
        let own = cells.iter().filter(|cell| cell.instance == instance);
        own.map(|cell| time(cell)).fold(f64::INFINITY, f64::min)
    };
    let best: Vec<(usize, f64)> = instances.iter().map(|&i| (i, fastest(i))).collect();
    let ratio = |cell: &Cell<'a>| {
        let (_, best) = best.iter().find(|(instance, _)| *instance == cell.instance)?;
        let ratio = time(cell) / best;
        ratio.is_finite().then_some(ratio)
    };
    let last = cells.iter().filter_map(|cell| ratio(cell)).fold(1.0, f64::max) * 1.3;
    let present = |solver: &usize| cells.iter().any(|cell| cell.solver == *solver);
    let series = (0..pool.spec.solvers.len()).filter(present).map(|solver| {
        let cell = &pool.spec.solvers[solver];
        let own = cells.iter().filter(|cell| cell.solver == solver);
        let mut ratios: Vec<f64> = own.filter_map(|cell| ratio(cell)).collect();
        ratios.sort_by(f64::total_cmp);
        let share = |n: usize| n as f64 / instances.len() as f64;
        let at_one = ratios.iter().filter(|&&ratio| ratio <= 1.0).count();
        let mut points = vec![[1.0, share(at_one)]];
        points.extend(
            ratios.iter().enumerate().skip(at_one).map(|(n, &ratio)| [ratio, share(n + 1)]),
        );
        points.push([last, share(ratios.len())]);
        Series::new(&cell.label, styles[solver], Primitive::Steps, points)
    });
    Panel {
        title: None,
        x: Axis::new(
            format!("{} to a gap of {}, relative to the fastest", x.label(), given(gap)),
            true,
        ),
        y: Axis::new(format!("share of {} instances", instances.len()), false),
        series: series.collect(),
    }
}
