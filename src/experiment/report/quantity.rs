//! What can be shown of a cell: its keys, and what its runs reached.

use super::super::figures::{Clock, Target};
use super::super::results::Done;
use super::pool::{Cell, Pool, Spread, number, value};

/// One value of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    Number(Spread),
    Text(String),
    /// The quantity does not exist for this cell.
    Nothing,
}

impl Shown {
    pub fn number(&self) -> Option<Spread> {
        match self {
            Shown::Number(spread) => Some(*spread),
            Shown::Text(_) | Shown::Nothing => None,
        }
    }

    pub fn text(&self) -> String {
        match self {
            Shown::Number(spread) => number(spread.median),
            Shown::Text(text) => text.clone(),
            Shown::Nothing => String::new(),
        }
    }
}

/// `name` is a key of the cells or one of [`super::super::figures::QUANTITIES`]; a gap makes times those until it.
pub fn quantity<'a>(pool: &Pool<'a>, cell: &Cell<'a>, name: &str, gap: Option<f64>) -> Shown {
    let (instance, solver) = (pool.instance(cell), pool.solver(cell));
    // In the file it may be a word.
    if name == "lambda"
        && let Some(run) = cell.runs.first()
    {
        return Shown::Number(Spread::of(vec![run.summary.lambda]));
    }
    let own = value(&instance.keys, name).or_else(|| value(&solver.keys, name));
    if let Some(own) = own {
        return match own.number() {
            Some(x) => Shown::Number(Spread::of(vec![x])),
            None => Shown::Text(own.text()),
        };
    }
    let bound = pool.bound(cell.instance);
    let share = |difference: f64| pool.share(cell.instance, difference);
    let of = |runs: Vec<&'a Done>, value: &dyn Fn(&'a Done) -> Option<f64>| {
        let values: Vec<f64> = runs.into_iter().filter_map(value).filter(|x| !x.is_nan()).collect();
        if values.is_empty() { Shown::Nothing } else { Shown::Number(Spread::of(values)) }
    };
    let all = |value: &dyn Fn(&'a Done) -> Option<f64>| of(cell.runs.clone(), value);
    let time = |clock: Clock| match gap {
        Some(gap) => match pool.time_to(cell, clock, gap, Target::Certificate) {
            Some(spread) if spread.median.is_finite() => Shown::Number(spread),
            _ => Shown::Nothing,
        },
        None => match clock {
            Clock::Iterations => all(&|run| Some(run.summary.iterations as f64)),
            Clock::Seconds => of(pool.timed(cell).collect(), &|run| Some(run.summary.seconds)),
        },
    };
    let smoothed = |run: &Done| run.trace.last().and_then(|point| point.smoothed_energy);
    let least_smoothed = || {
        // Of all that minimize the same E_eps.
        let key = |run: &Done, key: &str| run.key(key).cloned();
        let first = cell.runs.first()?;
        let same = |run: &&Done| {
            ["options.epsilon", "options.epsilon-mode"]
                .iter()
                .all(|name| key(run, name) == key(first, name))
        };
        let energies = pool.of_instance(cell.instance).filter(same).filter_map(smoothed);
        energies.reduce(f64::min)
    };
    match name {
        "vertices" => all(&|run| Some(run.summary.vertices as f64)),
        "faces" => all(&|run| Some(run.summary.faces as f64)),
        "iterations" => time(Clock::Iterations),
        "seconds" => time(Clock::Seconds),
        "wall-seconds" => of(pool.timed(cell).collect(), &|run| Some(run.manifest.wall_seconds)),
        "energy" => all(&|run| Some(run.summary.energy)),
        "bound" => all(&|run| Some(run.summary.dual_bound)),
        "gap" => all(&|run| Some(run.summary.relative_gap)),
        "rounded-gap" => all(&|run| Some(run.summary.rounded_relative_gap)),
        "excess" => all(&|run| Some(share(run.summary.energy - bound))),
        "rounding-error" => {
            all(&|run| Some(share(run.summary.rounded_energy - run.summary.energy)))
        }
        "optimization-error" => {
            let least = least_smoothed();
            all(&|run| match (smoothed(run), least) {
                (Some(energy), Some(least)) => Some(share(energy - least)),
                _ => Some(share(run.summary.energy - bound)),
            })
        }
        "bias" => {
            let least = least_smoothed();
            all(&|run| Some(share(smoothed(run).and(least)? - bound)))
        }
        "labels-changed" => {
            let best = pool
                .of_instance(cell.instance)
                .filter(|run| run.labels.is_some())
                .min_by(|a, b| a.summary.energy.total_cmp(&b.summary.energy));
            all(&|run| {
                let (own, reference) = (run.labels.as_ref()?, best?.labels.as_ref()?);
                let changed = own.iter().zip(reference).filter(|(a, b)| a != b).count();
                Some(changed as f64 / own.len() as f64)
            })
        }
        "regions-used" => {
            all(&|run| Some((run.summary.regions - run.summary.empty_regions.len()) as f64))
        }
        "mislabeled" => all(&|run| run.manifest.mislabeled),
        "status" => cell.runs.first().map_or(Shown::Nothing, |run| {
            let status = serde_json::to_value(run.summary.status).expect("a plain name");
            Shown::Text(status.as_str().expect("a plain name").to_owned())
        }),
        _ => Shown::Nothing,
    }
}
