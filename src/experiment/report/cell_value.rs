//! The values of the variables of a cell: its keys, and the quantities of its runs.

use crate::agreement::Confusion;
use crate::evolve::{self, folds::Folds};
use crate::level_sets::LevelSet;
use crate::mesh::distance::Distances;
use crate::problem::label_gap;
use crate::solve::Summary;

use super::super::figures::{Clock, Target};
use super::super::manifest::Scores;
use super::super::results::Done;
use super::super::variable::{Quantity, Variable};
use super::pool::{Cell, Pool, Spread, number, value};

/// One value of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum CellValue {
    Number(Spread),
    Text(String),
    /// The quantity does not exist for this cell.
    Nothing,
}

impl CellValue {
    pub fn number(&self) -> Option<Spread> {
        match self {
            CellValue::Number(spread) => Some(*spread),
            CellValue::Text(_) | CellValue::Nothing => None,
        }
    }

    pub fn text(&self) -> String {
        match self {
            CellValue::Number(spread) => number(spread.median),
            CellValue::Text(text) => text.clone(),
            CellValue::Nothing => String::new(),
        }
    }
}

/// The value of a variable. With a gap, times and iterations are those until that gap.
pub fn value_of<'a>(
    pool: &Pool<'a>,
    cell: &Cell<'a>,
    variable: &Variable,
    gap: Option<f64>,
) -> CellValue {
    match variable {
        Variable::Key(key) => value_of_key(pool, cell, key),
        Variable::Quantity(quantity) => CellRuns { pool, cell }.value(*quantity, gap),
    }
}

fn value_of_key(pool: &Pool<'_>, cell: &Cell<'_>, key: &str) -> CellValue {
    // In the file it may be "auto".
    if key == "lambda"
        && let Some(summary) = cell.runs.first().and_then(|run| run.summary.labels())
    {
        return CellValue::Number(Spread::of(vec![summary.lambda]));
    }
    let (instance, solver) = (pool.instance(cell), pool.solver(cell));
    match value(&instance.keys, key).or_else(|| value(&solver.keys, key)) {
        Some(scalar) => match scalar.number() {
            Some(x) => CellValue::Number(Spread::of(vec![x])),
            None => CellValue::Text(scalar.text()),
        },
        None => CellValue::Nothing,
    }
}

/// The runs of a cell, with access to those of other cells for comparison.
struct CellRuns<'p, 'a> {
    pool: &'p Pool<'a>,
    cell: &'p Cell<'a>,
}

impl<'a> CellRuns<'_, 'a> {
    fn value(&self, quantity: Quantity, gap: Option<f64>) -> CellValue {
        let peers = self.pool.peers(self.cell);
        let bound = peers.bound();
        match quantity {
            Quantity::Vertices => self.of_all(|run| Some(run.summary.vertices() as f64)),
            Quantity::Faces => self.of_all(|run| Some(run.summary.faces() as f64)),
            Quantity::Iterations => self.time(Clock::Iterations, gap),
            Quantity::Seconds => self.time(Clock::Seconds, gap),
            Quantity::LabelSeconds => self.of_timed(label_seconds),
            Quantity::WallSeconds => self.of_timed(|run| run.manifest.wall_seconds),
            Quantity::Energy => self.of_all(|run| Some(run.summary.energy())),
            Quantity::Bound => self.of_labels(|summary| summary.dual_bound),
            Quantity::Gap => self.of_labels(|summary| summary.relative_gap),
            Quantity::Excess => self.of_labels(|summary| peers.share(summary.energy - bound)),
            Quantity::Bias => {
                let least = self.least_smoothed();
                self.of_all(|run| Some(peers.share(smoothed(run).and(least)? - bound)))
            }
            Quantity::OptimizationError => {
                let least = self.least_smoothed();
                self.of_all(|run| match (smoothed(run), least) {
                    (Some(energy), Some(least)) => Some(peers.share(energy - least)),
                    _ => Some(peers.share(run.summary.labels()?.energy - bound)),
                })
            }
            Quantity::RoundingError => {
                self.of_labels(|summary| peers.share(summary.rounded_energy - summary.energy))
            }
            Quantity::LabelsChanged => {
                let reference = self.reference_labels();
                let own = !self.pool.solver(self.cell).task.has_fixed_costs();
                self.of_all(|run| share_of_changes(run.labels.as_ref()?, reference?, own))
            }
            Quantity::RoundedGap => self.of_labels(|summary| summary.rounded_relative_gap),
            Quantity::LabelExcess => {
                let bound = peers.label_bound();
                self.of_labels(|summary| {
                    let baseline = summary.baseline;
                    label_gap(summary.rounded_energy - baseline, bound - baseline)
                })
            }
            Quantity::RegionsUsed => {
                self.of_labels(|summary| (summary.regions - summary.empty_regions.len()) as f64)
            }
            Quantity::Mislabeled => self.of_all(|run| run.manifest.mislabeled),
            Quantity::RandIndex => self.of_scores(|scores| Some(scores.rand_index)),
            Quantity::VariationOfInformation => {
                self.of_scores(|scores| Some(scores.variation_of_information))
            }
            Quantity::Covering => self.of_scores(|scores| Some(scores.covering)),
            Quantity::BoundaryF => self.of_scores(|scores| scores.boundary_f),
            Quantity::Binary => self.of_all(|run| run.manifest.binary),
            Quantity::CutLength => self.of_all(|run| run.manifest.cut_length),
            Quantity::ThresholdLabels => self.of_thresholds(|set| set.labels),
            Quantity::ThresholdLines => self.of_thresholds(|set| set.lines),
            Quantity::Steps => self.of_surfaces(|summary| Some(summary.steps as f64)),
            Quantity::Distance => self.of_distances(|distances| distances.mean),
            Quantity::DistanceBack => self.of_distances(|distances| distances.back),
            Quantity::Distance95 => self.of_distances(|distances| distances.percentile_95),
            Quantity::LargestDistance => self.of_distances(|distances| distances.largest),
            Quantity::SilhouetteIou => {
                self.of_surfaces(|summary| Some(summary.quality.silhouette_iou))
            }
            Quantity::Folds => self.of_surfaces(|summary| {
                let Folds { folded_edges, intersecting_pairs } = summary.quality.folds;
                Some((folded_edges + intersecting_pairs) as f64)
            }),
            Quantity::Parameters => self.parameters(),
            Quantity::Status => self.status(),
        }
    }

    fn of_all(&self, value: impl Fn(&'a Done) -> Option<f64>) -> CellValue {
        spread(self.cell.runs.iter().copied().filter_map(value))
    }

    fn of_labels(&self, value: impl Fn(&Summary) -> f64) -> CellValue {
        self.of_all(|run| run.summary.labels().map(&value))
    }

    fn of_surfaces(&self, value: impl Fn(&evolve::Summary) -> Option<f64>) -> CellValue {
        self.of_all(|run| run.summary.surface().and_then(&value))
    }

    fn of_distances(&self, value: impl Fn(&Distances) -> f64) -> CellValue {
        self.of_surfaces(|summary| summary.distances.as_ref().map(&value))
    }

    fn of_scores(&self, score: impl Fn(&Scores) -> Option<f64>) -> CellValue {
        self.of_all(|run| score(run.manifest.scores.as_ref()?))
    }

    /// The largest difference of a threshold's energy from that of U, relative to E - B.
    fn of_thresholds(&self, energy: impl Fn(&LevelSet) -> f64) -> CellValue {
        self.of_all(|run| {
            let summary = run.summary.labels()?;
            let differences = run
                .manifest
                .level_sets
                .as_ref()?
                .iter()
                .map(|set| energy(set).abs() / (summary.energy - summary.baseline));
            differences.reduce(f64::max)
        })
    }

    /// The values of the first run, in ascending order, so that the names of regions do not matter.
    fn parameters(&self) -> CellValue {
        let first = self.cell.runs.first().and_then(|run| run.manifest.parameters.clone());
        let Some(mut values) = first else { return CellValue::Nothing };
        values.sort_by(|a, b| {
            let pairs = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
            pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        let text = |value: &Vec<f64>| -> String {
            value.iter().map(|x| format!("{x:.5}")).collect::<Vec<_>>().join(" ")
        };
        CellValue::Text(values.iter().map(text).collect::<Vec<_>>().join(" / "))
    }

    /// The spread over the runs whose times are comparable.
    fn of_timed(&self, value: impl Fn(&'a Done) -> f64) -> CellValue {
        spread(self.pool.timed(self.cell).map(value))
    }

    fn time(&self, clock: Clock, gap: Option<f64>) -> CellValue {
        match (clock, gap) {
            (_, Some(gap)) => match self.pool.time_to(self.cell, clock, gap, Target::Certificate) {
                Some(spread) if spread.median.is_finite() => CellValue::Number(spread),
                _ => CellValue::Nothing,
            },
            (Clock::Iterations | Clock::Steps, None) => {
                self.of_labels(|summary| summary.iterations as f64)
            }
            (Clock::Seconds, None) => self.of_timed(|run| run.summary.seconds()),
        }
    }

    /// The minimum E_eps of all runs with the same smoothing.
    fn least_smoothed(&self) -> Option<f64> {
        let first = self.cell.runs.first()?;
        let is_same = |run: &&Done| {
            ["options.epsilon", "options.epsilon-mode"]
                .iter()
                .all(|key| run.key(key) == first.key(key))
        };
        let runs = self.pool.peers(self.cell).runs.into_iter().filter(is_same);
        runs.filter_map(smoothed).reduce(f64::min)
    }

    /// The labels of the run of minimum energy among those whose labels are kept.
    fn reference_labels(&self) -> Option<&'a [u8]> {
        let runs = self.pool.peers(self.cell).runs.into_iter();
        let labeled = runs.filter_map(|run| Some((run.summary.energy(), run.labels.as_deref()?)));
        labeled.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, labels)| labels)
    }

    fn status(&self) -> CellValue {
        let Some(run) = self.cell.runs.first() else { return CellValue::Nothing };
        CellValue::Text(run.summary.status())
    }
}

fn spread(values: impl Iterator<Item = f64>) -> CellValue {
    let values: Vec<f64> = values.filter(|x| !x.is_nan()).collect();
    if values.is_empty() { CellValue::Nothing } else { CellValue::Number(Spread::of(values)) }
}

/// E_eps of the last sample.
fn smoothed(run: &Done) -> Option<f64> {
    run.trace.last().and_then(|point| point.smoothed_energy)
}

/// The time of steps and rounding; NaN where it was not measured. External solvers make labels in their steps.
fn label_seconds(run: &Done) -> f64 {
    let Some(summary) = run.summary.labels() else { return f64::NAN };
    let rounding = match summary.solver == "external" {
        true => Some(0.0),
        false => summary.rounding.as_ref().and_then(|record| record.rounding_seconds),
    };
    summary.seconds + rounding.unwrap_or(f64::NAN)
}

/// The share of labels that differ; with regions of their own, under the best matching.
fn share_of_changes(labels: &[u8], reference: &[u8], own_regions: bool) -> Option<f64> {
    if own_regions {
        let integers = |labels: &[u8]| labels.iter().map(|&p| i64::from(p)).collect::<Vec<_>>();
        let weights = vec![1.0; labels.len()];
        let confusion = Confusion::new(&integers(labels), &integers(reference), &weights).ok()?;
        return Some(1.0 - confusion.accuracy());
    }
    let changed = labels.iter().zip(reference).filter(|(a, b)| a != b).count();
    Some(changed as f64 / labels.len() as f64)
}
