//! The figures that a file asks for, as plain numbers.

use super::super::figures::{Clock, FigureKind, FigureSpec, Measure, Target};
use super::super::results::{Done, Point};
use super::pool::{Cell, Pool, given, value};
use super::quantity::quantity;
use crate::figure::{Axis, Figure, Panel, Scale, Series, Shape, Width};

/// A figure and the runs that its numbers are of.
pub struct Drawn<'a> {
    pub figure: Figure,
    pub sources: Vec<&'a Done>,
}

pub fn draw<'a>(pool: &Pool<'a>, spec: &FigureSpec) -> Drawn<'a> {
    let wanted = |cell: &&Cell<'a>| {
        let contains = |label: &str, part: &Option<String>| {
            part.as_ref().is_none_or(|part| label.contains(part.as_str()))
        };
        contains(&pool.instance(cell).label, &spec.only)
            && contains(&pool.solver(cell).label, &spec.solvers)
    };
    let cells: Vec<&Cell<'a>> = pool.cells.iter().filter(wanted).collect();
    let (panels, timed) = match &spec.kind {
        FigureKind::Decay { x, y } => (decay(pool, &cells, *x, *y), *x == Clock::Seconds),
        FigureKind::Profile { x, gap } => {
            (vec![profile(pool, &cells, *x, *gap)], *x == Clock::Seconds)
        }
        FigureKind::Relation { x, y, .. } => {
            let timed = [x, y].iter().any(|name| name.contains("seconds"));
            (relation(pool, &cells, &spec.kind), timed)
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

fn axis(label: impl Into<String>, log: bool) -> Axis {
    Axis { label: label.into(), scale: if log { Scale::Log } else { Scale::Linear } }
}

/// A panel for each instance, a curve for each solver.
fn decay<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>], x: Clock, y: Measure) -> Vec<Panel> {
    let mut instances: Vec<usize> = cells.iter().map(|cell| cell.instance).collect();
    instances.dedup();
    let measure = |instance: usize, point: &Point| match y {
        Measure::Suboptimality => pool.suboptimality(instance, point.energy),
        Measure::Gap => point.relative_gap,
        Measure::Energy => point.energy,
    };
    let label = match y {
        Measure::Suboptimality => "suboptimality",
        Measure::Gap => "certified gap",
        Measure::Energy => "energy",
    };
    let panel = |instance: usize| {
        let bound = pool.bound(instance);
        let series = cells.iter().filter(|cell| cell.instance == instance).map(|cell| Series {
            label: pool.solver(cell).label.clone(),
            style: cell.solver,
            shape: Shape::LineMarks,
            points: pool
                .trace(cell, x == Clock::Seconds)
                .iter()
                .map(|point| [x.of(point), measure(instance, point)])
                .filter(|[x, y]| *x > 0.0 && (bound.is_finite() || y.is_finite()))
                .collect(),
            band: Vec::new(),
        });
        Panel {
            title: Some(pool.spec.instances[instance].label.clone()),
            x: axis(x.label(), true),
            y: axis(label, y != Measure::Energy),
            series: series.collect(),
        }
    };
    instances.into_iter().map(panel).collect()
}

/// The share of the instances that a solver brings to a gap within a multiple of the time of the fastest.
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
            shape: Shape::Steps,
            points,
            band: Vec::new(),
        }
    });
    Panel {
        title: None,
        x: axis(format!("{} to a gap of {}, relative to the fastest", x.label(), given(gap)), true),
        y: axis(format!("share of {} instances", instances.len()), false),
        series: series.collect(),
    }
}

/// One mark for each cell; cells that differ in nothing but x are one series.
fn relation<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>], kind: &FigureKind) -> Vec<Panel> {
    let FigureKind::Relation { x, y, gap, panels, fit, logx, logy, reference } = kind else {
        unreachable!("it is called for relations");
    };
    let hidden = |key: &str| {
        key == x
            || panels.as_deref() == Some(key)
            || (key == "mesh" && ["faces", "vertices"].contains(&x.as_str()))
    };
    let varying: Vec<&str> = pool.varying(cells).into_iter().filter(|key| !hidden(key)).collect();
    let name = |cell: &Cell<'a>| {
        let (instance, solver) = (pool.instance(cell), pool.solver(cell));
        let mut label = solver.base.clone();
        for (key, value) in solver.varied.iter().filter(|(key, _)| !hidden(key)) {
            let key = key.strip_prefix("options.").unwrap_or(key);
            label += &format!(", {key} {}", value.text());
        }
        for key in &varying {
            // Not every instance has every key.
            let Some(value) = value(&instance.keys, key) else { continue };
            label += &match *key {
                "mesh" | "data" => format!(", {}", value.text()),
                key => format!(", {key} {}", value.text()),
            };
        }
        label
    };
    let panel_of =
        |cell: &Cell<'a>| panels.as_ref().map(|key| quantity(pool, cell, key, None).text());
    let (mut names, mut titles): (Vec<String>, Vec<Option<String>>) = (Vec::new(), Vec::new());
    for cell in cells {
        let (name, title) = (name(cell), panel_of(cell));
        if !names.contains(&name) {
            names.push(name);
        }
        if !titles.contains(&title) {
            titles.push(title);
        }
    }
    // The looks of its solver, as in all other figures, where no other series has them.
    let first = |label: &String| {
        let own = cells.iter().find(|cell| name(cell) == *label);
        own.map_or(0, |cell| cell.solver)
    };
    let mut styles: Vec<usize> = names.iter().map(first).collect();
    let distinct = (1..styles.len()).all(|i| !styles[..i].contains(&styles[i]));
    if !distinct {
        styles = (0..names.len()).collect();
    }
    let unused = styles.iter().max().map_or(0, |last| last + 1);
    let panel = |title: &Option<String>| {
        let mut series = Vec::new();
        for (&style, label) in styles.iter().zip(&names) {
            let own = cells.iter().filter(|cell| name(cell) == *label && panel_of(cell) == *title);
            let mut marks: Vec<([f64; 2], [f64; 3])> = own
                .filter_map(|cell| {
                    let x = quantity(pool, cell, x, None).number()?.median;
                    let y = quantity(pool, cell, y, *gap).number()?;
                    Some(([x, y.median], [x, y.low, y.high]))
                })
                .collect();
            marks.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
            let points: Vec<[f64; 2]> = marks.iter().map(|mark| mark.0).collect();
            let band =
                marks.iter().map(|mark| mark.1).filter(|[_, low, high]| low < high).collect();
            let line = fit.then(|| power(&points)).flatten();
            let label = match line {
                Some((exponent, _)) => format!("{label} (exponent {exponent:.2})"),
                None => label.clone(),
            };
            let shape = if *fit { Shape::Marks } else { Shape::LineMarks };
            if let Some((exponent, factor)) = line {
                let ends = [points[0][0], points[points.len() - 1][0]];
                let points = ends.map(|x| [x, factor * x.powf(exponent)]).to_vec();
                let label = String::new();
                series.push(Series {
                    label,
                    style,
                    shape: Shape::Reference,
                    points,
                    band: Vec::new(),
                });
            }
            if !points.is_empty() {
                series.push(Series { label, style, shape, points, band });
            }
        }
        if let Some((label, point)) = reference {
            let (label, points) = (label.clone(), vec![*point]);
            let style = unused;
            series.push(Series { label, style, shape: Shape::Marks, points, band: Vec::new() });
        }
        let title = match (panels, title) {
            (Some(key), Some(title)) => {
                Some(format!("{} {title}", key.strip_prefix("options.").unwrap_or(key)))
            }
            _ => None,
        };
        Panel { title, x: axis(words(x, None), *logx), y: axis(words(y, *gap), *logy), series }
    };
    // Cells without the key of the panels, such as a reference solver, have nothing to show.
    titles.iter().map(panel).filter(|panel| !panel.series.is_empty()).collect()
}

/// Exponent and factor of y = factor x^exponent by least squares of the logarithms, for two points and more.
pub fn power(points: &[[f64; 2]]) -> Option<(f64, f64)> {
    let logs: Vec<[f64; 2]> = points
        .iter()
        .filter(|[x, y]| *x > 0.0 && *y > 0.0 && y.is_finite())
        .map(|point| point.map(f64::ln))
        .collect();
    let n = logs.len() as f64;
    let mean = |i: usize| logs.iter().map(|log| log[i]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let variance: f64 = logs.iter().map(|log| (log[0] - x).powi(2)).sum();
    if logs.len() < 2 || variance == 0.0 {
        return None;
    }
    let exponent = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum::<f64>() / variance;
    Some((exponent, (y - exponent * x).exp()))
}

/// The label of an axis.
fn words(name: &str, gap: Option<f64>) -> String {
    let words = match name {
        "excess" => "energy above the best bound",
        "bias" => "least smoothed energy above the best bound",
        "optimization-error" => "optimization error",
        "rounding-error" => "rounding error",
        "labels-changed" => "share of labels changed",
        "regions-used" => "regions that are used",
        "mislabeled" => "share of vertices that are mislabeled",
        "rounded-gap" => "certified gap of the labels",
        "gap" => "certified gap",
        "bound" => "lower bound",
        "wall-seconds" => "seconds, certificates included",
        name => name.strip_prefix("options.").unwrap_or(name),
    };
    match gap {
        Some(gap) if ["seconds", "iterations"].contains(&name) => {
            format!("{words} to a gap of {}", given(gap))
        }
        _ => words.to_owned(),
    }
}
