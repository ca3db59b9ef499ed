//! The figures of an experiment file, as plain numbers.

use super::super::figures::{Clock, FigureKind, FigureSpec, Measure, Target};
use super::super::results::{Done, Point};
use super::super::variable::Variable;
use super::pool::{Cell, Peers, Pool, given};
use super::relation::relation;
use crate::figure::{Axis, Figure, Panel, Primitive, Series, Width};
use crate::level_sets::LevelSet;

/// A figure and the runs behind its numbers.
pub struct Drawn<'a> {
    pub figure: Figure,
    pub sources: Vec<&'a Done>,
}

/// The cells that a figure selects.
pub fn selected<'p, 'a>(pool: &'p Pool<'a>, spec: &FigureSpec) -> Vec<&'p Cell<'a>> {
    let wanted = |cell: &&Cell<'a>| {
        let contains = |label: &str, part: &Option<String>| {
            part.as_ref().is_none_or(|part| label.contains(part.as_str()))
        };
        contains(&pool.instance(cell).label, &spec.only)
            && contains(&pool.solver(cell).label, &spec.solvers)
    };
    pool.cells.iter().filter(wanted).collect()
}

/// Draws a figure of numbers. Panics if it is one of pictures.
pub fn draw<'a>(pool: &Pool<'a>, spec: &FigureSpec) -> Drawn<'a> {
    let cells = selected(pool, spec);
    let (panels, timed) = match &spec.kind {
        FigureKind::Decay { x, y } => (decay(pool, &cells, *x, *y), *x == Clock::Seconds),
        FigureKind::Profile { x, gap } => {
            (vec![profile(pool, &cells, *x, *gap)], *x == Clock::Seconds)
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
    let figure = Figure {
        panels,
        width: if spec.page { Width::Page } else { Width::Column },
        columns: spec.columns,
        note: pool.note(timed),
    };
    let counts = |run: &&Done| !timed || run.manifest.machine.host == pool.host;
    let sources = cells.iter().flat_map(|cell| cell.runs.iter().copied()).filter(counts).collect();
    Drawn { figure, sources }
}

/// A panel for each instance, a curve for each solver.
fn decay<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>], x: Clock, y: Measure) -> Vec<Panel> {
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
            Series {
                label: pool.solver(cell).label.clone(),
                style: cell.solver,
                primitive: Primitive::LineMarks,
                points: pool
                    .trace(cell, x == Clock::Seconds)
                    .iter()
                    .filter_map(|point| Some([x.of(point), measure(&peers, point)?]))
                    .filter(|[x, _]| *x > 0.0 || !logx)
                    .filter(|[_, y]| bound.is_finite() || y.is_finite())
                    .collect(),
                band: Vec::new(),
            }
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
                series.push(Series {
                    label: format!("{}: {name}", pool.solver(cell).label),
                    style: 2 * cell.solver + i,
                    primitive: Primitive::LineMarks,
                    points: sets.iter().map(|set| [set.threshold, above(energy(set))]).collect(),
                    band: Vec::new(),
                });
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
fn profile<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>], x: Clock, gap: f64) -> Panel {
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
        Series {
            label: cell.label.clone(),
            style: solver,
            primitive: Primitive::Steps,
            points,
            band: Vec::new(),
        }
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
