//! A figure of the kind `relation`: one mark for each cell; cells that differ only in x form a series.

use super::super::figures::Relation;
use super::super::variable::{Quantity, Variable};
use super::cell_value::value_of;
use super::pool::{Cell, Pool, given, value};
use crate::figure::{Axis, Panel, Primitive, Series};

/// A panel for each value of the key of the panels, or one.
pub fn relation<'a>(pool: &Pool<'a>, cells: &[&Cell<'a>], relation: &Relation) -> Vec<Panel> {
    let varying = pool.varying(cells);
    let varying: Vec<&str> = varying.into_iter().filter(|key| !hides(relation, key)).collect();
    let member = |cell: &&Cell<'a>| Member {
        series: series_name(pool, cell, relation, &varying),
        panel: relation.panels.as_ref().map(|key| value_of(pool, cell, key, None).text()),
        marked: marked(pool, cell, relation),
        solver: cell.solver,
    };
    let members: Vec<Member> = cells.iter().map(member).collect();
    let names = distinct(members.iter().map(|member| &member.series));
    let styles = styles(&names, &members);
    let panel = |value: &Option<String>| {
        let within = || members.iter().filter(|member| member.panel == *value);
        let mut series: Vec<Series> = styles
            .iter()
            .zip(&names)
            .flat_map(|(&style, &name)| {
                let own = within().filter(|member| member.series == *name);
                marks_and_fit(name, style, own.filter_map(|member| member.marked), relation.fit)
            })
            .collect();
        if let Some((label, point)) = &relation.reference {
            let unused = styles.iter().max().map_or(0, |last| last + 1);
            series.push(Series::new(label, unused, Primitive::Marks, vec![*point]));
        }
        let title = relation.panels.as_ref().zip(value.as_ref());
        Panel {
            title: title.map(|(key, value)| format!("{} {value}", key.short_name())),
            x: Axis::new(axis_label(&relation.x, None), relation.logx),
            y: Axis::new(axis_label(&relation.y, relation.gap), relation.logy),
            series,
        }
    };
    // Cells without the key of the panels, such as those of a reference solver, may have no panel.
    let values = distinct(members.iter().map(|member| &member.panel));
    values.into_iter().map(panel).filter(|panel| !panel.series.is_empty()).collect()
}

/// A cell with its series and its panel.
struct Member {
    series: String,
    /// The value of the key of the panels.
    panel: Option<String>,
    /// `None` without x or y.
    marked: Option<Marked>,
    solver: usize,
}

/// The median, and x with both quartiles of y.
#[derive(Clone, Copy)]
struct Marked {
    point: [f64; 2],
    bar: [f64; 3],
    /// Whether the gap was reached; otherwise y is where the runs ended.
    reached: bool,
}

fn marked<'a>(pool: &Pool<'a>, cell: &Cell<'a>, relation: &Relation) -> Option<Marked> {
    let x = value_of(pool, cell, &relation.x, None).number()?.median;
    let value = value_of(pool, cell, &relation.y, relation.gap);
    let reached = value.number();
    let y = match (reached, relation.gap) {
        (None, Some(_)) => value_of(pool, cell, &relation.y, None).number()?,
        _ => reached?,
    };
    Some(Marked { point: [x, y.median], bar: [x, y.low, y.high], reached: reached.is_some() })
}

fn distinct<'m, T: PartialEq>(all: impl Iterator<Item = &'m T>) -> Vec<&'m T> {
    let mut distinct = Vec::new();
    for one in all {
        if !distinct.contains(&one) {
            distinct.push(one);
        }
    }
    distinct
}

/// Whether the x-axis or the panels show the values of a key, so that the names of series need not.
fn hides(relation: &Relation, key: &str) -> bool {
    let size = || relation.x.is(Quantity::Faces) || relation.x.is(Quantity::Vertices);
    relation.x.is_key(key)
        || relation.panels.as_ref().is_some_and(|panels| panels.is_key(key))
        || (key == "mesh" && size())
}

/// The solver and all values that distinguish its cells from those of other series.
fn series_name(pool: &Pool<'_>, cell: &Cell<'_>, relation: &Relation, varying: &[&str]) -> String {
    let (instance, solver) = (pool.instance(cell), pool.solver(cell));
    let mut name = solver.base.clone();
    for (key, value) in solver.varied.iter().filter(|(key, _)| !hides(relation, key)) {
        let key = key.strip_prefix("options.").unwrap_or(key);
        name += &format!(", {key} {}", value.text());
    }
    for key in varying {
        // Not every instance has every key.
        let Some(value) = value(&instance.keys, key) else { continue };
        name += &match *key {
            "mesh" | "data" => format!(", {}", value.text()),
            key => format!(", {key} {}", value.text()),
        };
    }
    name
}

/// A style for each series: that of its solver, as in all other figures, if these are distinct.
fn styles(names: &[&String], members: &[Member]) -> Vec<usize> {
    let of_solver = |name: &&String| {
        let first = members.iter().find(|member| member.series == **name);
        first.map_or(0, |member| member.solver)
    };
    let styles: Vec<usize> = names.iter().map(of_solver).collect();
    let distinct = (1..styles.len()).all(|i| !styles[..i].contains(&styles[i]));
    if distinct { styles } else { (0..names.len()).collect() }
}

/// The marks of a series, preceded by the power of x fitted to it, if requested.
fn marks_and_fit(
    name: &str,
    style: usize,
    marked: impl Iterator<Item = Marked>,
    fit: bool,
) -> Vec<Series> {
    let (mut marked, unreached): (Vec<Marked>, Vec<Marked>) = marked.partition(|it| it.reached);
    marked.sort_by(|a, b| a.point[0].total_cmp(&b.point[0]));
    let beyond: Vec<[f64; 2]> = unreached.iter().map(|marked| marked.point).collect();
    let points: Vec<[f64; 2]> = marked.iter().map(|marked| marked.point).collect();
    let bars = marked.iter().map(|marked| marked.bar).filter(|[_, low, high]| low < high);
    let mut label = name.to_owned();
    let mut series = Vec::new();
    if let Some((exponent, factor)) = fit.then(|| power(&points)).flatten() {
        label = format!("{label} (exponent {exponent:.2})");
        let ends = [points[0][0], points[points.len() - 1][0]];
        let line = ends.map(|x| [x, factor * x.powf(exponent)]).to_vec();
        series.push(Series::new("", style, Primitive::Reference, line));
    }
    if !points.is_empty() || !beyond.is_empty() {
        let primitive = if fit { Primitive::Marks } else { Primitive::LineMarks };
        series.push(Series { label, style, primitive, points, band: bars.collect(), beyond });
    }
    series
}

/// Exponent and factor of y = factor x^exponent by least squares of the logarithms, for at least two points.
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

fn axis_label(variable: &Variable, gap: Option<f64>) -> String {
    let label = variable.label();
    match gap {
        Some(gap) if variable.is(Quantity::Seconds) || variable.is(Quantity::Iterations) => {
            format!("{label} to a gap of {}", given(gap))
        }
        _ => label.to_owned(),
    }
}
