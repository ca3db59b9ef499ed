//! The runs of an experiment grouped by cell, from which figures and tables are drawn.

use std::cmp::Ordering;

use super::super::document::Scalar;
use super::super::figures::{Clock, Selection, Target};
use super::super::plan::run_toml;
use super::super::results::{Done, Point};
use super::super::spec::{InstanceCell, SolverCell, Spec};
use crate::solve::Summary;

/// All repetitions of one solver on one instance.
pub struct Cell<'a> {
    /// Indices in the file.
    pub instance: usize,
    pub solver: usize,
    pub runs: Vec<&'a Done>,
}

pub struct Pool<'a> {
    pub spec: &'a Spec,
    pub cells: Vec<Cell<'a>>,
    /// The host of the first run; times of other hosts are not comparable.
    pub host: String,
}

/// The runs of an instance whose energies are comparable: those with the costs of the instance, or those with parameters
/// of their own, which have no common bound. There are none for a surface, which has no bound at all: bounds and shares are
/// not finite.
pub struct Peers<'a> {
    fixed_costs: bool,
    pub runs: Vec<&'a Done>,
}

impl Peers<'_> {
    fn summaries(&self) -> impl Iterator<Item = &Summary> {
        self.runs.iter().filter_map(|run| run.summary.labels())
    }

    /// D*, the best bound of any solver; with parameters of their own E*.
    pub fn bound(&self) -> f64 {
        match self.fixed_costs {
            true => {
                let bounds = self.summaries().map(|summary| summary.dual_bound);
                bounds.fold(f64::NEG_INFINITY, f64::max)
            }
            false => self.energy(),
        }
    }

    /// L*, the best bound of any solver for labels; with parameters of their own the minimum energy of labels.
    pub fn label_bound(&self) -> f64 {
        let summaries = self.summaries();
        match self.fixed_costs {
            true => {
                let bound = |it: &Summary| match &it.rounding {
                    Some(rounding) => rounding.label_bound,
                    None => it.dual_bound,
                };
                summaries.map(bound).fold(f64::NEG_INFINITY, f64::max)
            }
            false => summaries.map(|it| it.rounded_energy).fold(f64::INFINITY, f64::min),
        }
    }

    /// E*, the minimum energy of any solver.
    pub fn energy(&self) -> f64 {
        self.summaries().map(|summary| summary.energy).fold(f64::INFINITY, f64::min)
    }

    /// (E - D*) / (E* - B).
    pub fn suboptimality(&self, energy: f64) -> f64 {
        self.share(energy - self.bound())
    }

    /// A difference of energies, relative to E* - B.
    pub fn share(&self, difference: f64) -> f64 {
        let baselines = self.summaries().map(|summary| summary.baseline);
        let baseline = baselines.fold(f64::INFINITY, f64::min);
        if difference == 0.0 { 0.0 } else { difference / (self.energy() - baseline) }
    }
}

/// Median and quartiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub low: f64,
    pub median: f64,
    pub high: f64,
}

impl Spread {
    /// The spread of at least one number, none NaN; quartiles are interpolated linearly.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let index = share * (values.len() - 1) as f64;
            let (below, above) = (values[index.floor() as usize], values[index.ceil() as usize]);
            // Interpolation between two infinities would give NaN.
            if below == above { below } else { below + (above - below) * index.fract() }
        };
        Spread { low: at(0.25), median: at(0.5), high: at(0.75) }
    }
}

impl<'a> Pool<'a> {
    /// The runs of the current file; others in the folder belong to former versions of it.
    pub fn of(spec: &'a Spec, done: &'a [Done]) -> Self {
        let mut cells = Vec::new();
        for (i, instance) in spec.instances.iter().enumerate() {
            for (s, solver) in spec.solvers.iter().enumerate() {
                if !spec.includes(instance, solver) {
                    continue;
                }
                let toml = run_toml(spec, instance, solver);
                let wanted: toml::Table = toml.parse().expect("the program wrote it");
                let mut runs: Vec<&Done> = done.iter().filter(|done| done.spec == wanted).collect();
                // Keeps the newest run of each repetition.
                runs.reverse();
                let mut seen = Vec::new();
                runs.retain(|run| {
                    let new = !seen.contains(&run.manifest.repetition);
                    seen.push(run.manifest.repetition);
                    new
                });
                runs.sort_by_key(|run| run.manifest.repetition);
                cells.push(Cell { instance: i, solver: s, runs });
            }
        }
        let first = cells.iter().flat_map(|cell| &cell.runs).min_by_key(|run| &run.manifest.start);
        let host = first.map_or(String::new(), |run| run.manifest.machine.host.clone());
        Pool { spec, cells, host }
    }

    pub fn instance(&self, cell: &Cell<'_>) -> &'a InstanceCell {
        &self.spec.instances[cell.instance]
    }

    pub fn solver(&self, cell: &Cell<'_>) -> &'a SolverCell {
        &self.spec.solvers[cell.solver]
    }

    /// The cells of a selection.
    pub fn selected(&self, selection: &Selection) -> Vec<&Cell<'a>> {
        let is_selected = |cell: &&Cell<'a>| {
            selection.has_instance(&self.instance(cell).label)
                && selection.has_solver(&self.solver(cell).label)
        };
        self.cells.iter().filter(is_selected).collect()
    }

    /// All runs.
    pub fn runs(&self) -> impl Iterator<Item = &'a Done> {
        self.cells.iter().flat_map(|cell| cell.runs.iter().copied())
    }

    /// Runs whose times are comparable.
    pub fn timed(&self, cell: &Cell<'a>) -> impl Iterator<Item = &'a Done> {
        let host = self.host.clone();
        cell.runs.clone().into_iter().filter(move |run| run.manifest.machine.host == host)
    }

    /// The runs with which a cell is compared, see [`Peers`].
    pub fn peers(&self, cell: &Cell<'_>) -> Peers<'a> {
        let solves = |cell: &Cell<'_>| self.solver(cell).task.has_fixed_costs();
        let fixed_costs = solves(cell);
        let evolves = |cell: &Cell<'_>| self.solver(cell).task.evolution().is_some();
        let comparable = |other: &Cell<'_>| solves(other) == fixed_costs && !evolves(other);
        let same = |other: &&Cell<'a>| {
            other.instance == cell.instance && comparable(other) && !evolves(cell)
        };
        let runs = self.cells.iter().filter(same).flat_map(|cell| cell.runs.clone()).collect();
        Peers { fixed_costs, runs }
    }

    /// Iterations or seconds until a gap, infinite for runs that do not reach it; `None` without runs.
    pub fn time_to(
        &self,
        cell: &Cell<'a>,
        clock: Clock,
        gap: f64,
        target: Target,
    ) -> Option<Spread> {
        let peers = self.peers(cell);
        let reached = |point: &&Point| match target {
            Target::Certificate => point.relative_gap.is_some_and(|own| own <= gap),
            Target::Optimum => peers.suboptimality(point.energy) <= gap,
        };
        let at = |run: &Done| {
            let first = run.trace.iter().find(reached);
            first.map_or(f64::INFINITY, |point| clock.of(point))
        };
        let times: Vec<f64> = match clock {
            Clock::Iterations | Clock::Steps => cell.runs.iter().map(|run| at(run)).collect(),
            Clock::Seconds => self.timed(cell).map(at).collect(),
        };
        (!times.is_empty()).then(|| Spread::of(times))
    }

    /// Samples with the median seconds of all repetitions; a solver samples at the same iterations in each.
    pub fn trace(&self, cell: &Cell<'a>, timed: bool) -> Vec<Point> {
        let all: Vec<&Done> = if timed { self.timed(cell).collect() } else { cell.runs.clone() };
        let Some(first) = all.first() else { return Vec::new() };
        let length = all.iter().map(|run| run.trace.len()).min().unwrap_or(0);
        (0..length)
            .map(|i| {
                let seconds = all.iter().map(|run| run.trace[i].seconds).collect();
                Point { seconds: Spread::of(seconds).median, ..first.trace[i] }
            })
            .collect()
    }

    /// What makes the times of some runs unusable or doubtful.
    pub fn note(&self) -> Option<String> {
        let mut notes = Vec::new();
        let all = self.runs().count();
        let elsewhere = self.runs().filter(|run| run.manifest.machine.host != self.host).count();
        let loaded = self.runs().filter(|run| run.manifest.loaded).count();
        if elsewhere > 0 {
            notes.push(format!("{elsewhere} of {all} runs are of another machine and left out"));
        }
        if loaded > 0 {
            notes.push(format!("{loaded} of {all} runs were made while others used the machine"));
        }
        (!notes.is_empty()).then(|| notes.join("; ") + ".")
    }

    /// Keys that take several values among the instances of some cells.
    pub fn varying(&self, cells: &[&Cell<'a>]) -> Vec<&'a str> {
        let all: Vec<&InstanceCell> = cells.iter().map(|cell| self.instance(cell)).collect();
        let mut keys: Vec<&str> = Vec::new();
        for (key, _) in all.iter().flat_map(|instance| &instance.keys) {
            let values = |instance: &InstanceCell| value(&instance.keys, key);
            let varies = all.windows(2).any(|pair| values(pair[0]) != values(pair[1]));
            if varies && !keys.contains(&key.as_str()) {
                keys.push(key);
            }
        }
        keys
    }
}

impl Clock {
    pub fn of(self, point: &Point) -> f64 {
        match self {
            Clock::Iterations | Clock::Steps => point.iteration as f64,
            Clock::Seconds => point.seconds,
        }
    }

    pub fn label(self) -> &'static str {
        self.into()
    }
}

pub fn value(keys: &[(String, Scalar)], key: &str) -> Option<Scalar> {
    keys.iter().find(|(name, _)| name == key).map(|(_, value)| value.clone())
}

/// Formats a given number: 1e-3, 0.25, 40.
pub fn given(x: f64) -> String {
    if x != 0.0 && (x.abs() < 0.1 || x.abs() >= 1e6) { format!("{x:e}") } else { x.to_string() }
}

/// Formats a measured number for LaTeX, with three digits.
pub fn latex(x: f64) -> String {
    let text = number(x);
    match text.split_once('e') {
        Some((factor, exponent)) => format!("\\ensuremath{{{factor}\\cdot10^{{{exponent}}}}}"),
        None if x.is_infinite() => text.replace("inf", "\\ensuremath{\\infty}"),
        None if x < 0.0 => format!("\\ensuremath{{{text}}}"),
        None => text,
    }
}

/// Formats a measured number for tables and text, with three digits.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == x.trunc() && size < 1e7 {
        format!("{x:.0}")
    } else if size.partial_cmp(&1e-3) == Some(Ordering::Less) || size >= 1e6 {
        format!("{x:.2e}")
    } else {
        let digits = (3 - 1 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    }
}
