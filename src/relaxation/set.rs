//! The names of the relaxations, and what their sets can do.

use strum::{EnumIter, EnumString, VariantNames};

use super::label_metric::LabelMetric;
use crate::error::{Error, Result};
use crate::field::{Row, Tangent};

/// The relaxation of a problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumIter, EnumString, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Relaxation {
    /// The norm of all regions together, as in the paper.
    #[default]
    Frobenius,
    /// The sum of the norms of the regions.
    Separate,
    /// The largest one that leaves the energy of two labels in a face as it is.
    Envelope,
    /// The same where cuts between each two labels have a weight of their own; it has no name by which it is chosen.
    #[strum(disabled)]
    Metric(LabelMetric),
}

impl From<Relaxation> for &'static str {
    fn from(relaxation: Relaxation) -> Self {
        match relaxation {
            Relaxation::Frobenius => "frobenius",
            Relaxation::Separate => "separate",
            Relaxation::Envelope => "envelope",
            Relaxation::Metric(_) => "metric",
        }
    }
}

impl Relaxation {
    /// The weights of the pairs of labels: 1 but for `Metric`.
    pub fn label_metric(self) -> LabelMetric {
        match self {
            Relaxation::Metric(metric) => metric,
            Relaxation::Frobenius | Relaxation::Separate | Relaxation::Envelope => {
                LabelMetric::POTTS
            }
        }
    }

    /// The weights of the pairs of labels, m x m, if they are not all 1.
    pub fn weights(self) -> Option<Vec<Vec<f64>>> {
        match self {
            Relaxation::Metric(metric) => {
                Some(metric.matrix().outer_iter().map(|row| row.to_vec()).collect())
            }
            _ => None,
        }
    }

    /// Whether its set consists of balls.
    pub fn has_balls(self) -> bool {
        matches!(self, Relaxation::Frobenius | Relaxation::Separate)
    }

    /// Fails if a metric is for another number of labels than m.
    pub fn check(self, m: usize) -> Result<()> {
        match self {
            Relaxation::Metric(metric) if metric.labels() != m => Err(Error::unsuitable(format!(
                "the weights of pairs are those of {} labels, but there are {m}",
                metric.labels()
            ))),
            _ => Ok(()),
        }
    }

    /// The one that certifies labels of m regions best at the speed of the fastest: `Separate`, or, for two regions, for
    /// which all are the same, the one of the paper. Measured in `experiments/relaxations.toml`: with 4, 8 and 16 regions
    /// labels are at most 1.8, 1.6 and 0.7 % above the bound, and 2.4, 11 and 16 % above that of `Frobenius`.
    pub fn for_labels(m: usize) -> Self {
        if m > 2 { Relaxation::Separate } else { Relaxation::Frobenius }
    }
}

/// The set of a relaxation as a type, for inner loops: `with_set!` chooses it once per sweep.
pub trait DualSet: Copy + Send + Sync + 'static {
    /// The relaxation.
    fn relaxation(self) -> Relaxation;

    /// The smallest lambda for which q_j is feasible.
    fn gauge<const M: usize>(self, q: Tangent<M>) -> f64;

    /// The nearest feasible point.
    fn project<const M: usize>(self, q: Tangent<M>, lambda: f64) -> Tangent<M>;

    /// max <q_j, (K U)_j> over the set of lambda = 1, in units of length.
    fn support<const M: usize>(self, ku: Tangent<M>) -> f64;

    /// The same with corners rounded off within the radius eps_j.
    fn smoothed<const M: usize>(self, ku: Tangent<M>, radius: f64) -> f64;

    /// The gradient of lambda times `smoothed`; it is feasible.
    fn smoothed_dual<const M: usize>(self, ku: Tangent<M>, radius: f64, lambda: f64) -> Tangent<M>;
}

/// |q_jp|^2 for all p.
#[inline(always)]
pub fn squares<const M: usize>(Tangent([a, b]): Tangent<M>) -> Row<M> {
    Row::from_fn(|p| a.0[p] * a.0[p] + b.0[p] * b.0[p])
}
