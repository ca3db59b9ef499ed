//! The names of the relaxations, and what their sets can do.

use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::field::{Row, Tangent};

/// The relaxation of a problem.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames,
)]
#[strum(serialize_all = "lowercase")]
pub enum Relaxation {
    /// The norm of all regions together, as in the paper.
    #[default]
    Frobenius,
    /// The sum of the norms of the regions.
    Separate,
    /// The largest one that leaves the energy of two labels in a face as it is.
    Envelope,
}

impl Relaxation {
    /// The one that certifies labels of m regions best at the speed of the fastest: `Separate`, or, for two regions, for
    /// which all are the same, the one of the paper. Measured in `experiments/relaxations.toml`: with 4, 8 and 16 regions
    /// labels are at most 1.8, 1.6 and 0.7 % above the bound, and 2.4, 11 and 16 % above that of `Frobenius`.
    pub fn for_labels(m: usize) -> Self {
        if m > 2 { Relaxation::Separate } else { Relaxation::Frobenius }
    }
}

/// The set of a relaxation as a type, for inner loops: `with_set!` chooses it once per sweep.
pub trait DualSet: 'static {
    /// The relaxation.
    const RELAXATION: Relaxation;

    /// The smallest lambda for which q_j is feasible.
    fn gauge<const M: usize>(q: Tangent<M>) -> f64;

    /// The nearest feasible point.
    fn project<const M: usize>(q: Tangent<M>, lambda: f64) -> Tangent<M>;

    /// max <q_j, (K U)_j> over the set of lambda = 1, in units of length.
    fn support<const M: usize>(ku: Tangent<M>) -> f64;

    /// The same with corners rounded off within the radius eps_j.
    fn smoothed<const M: usize>(ku: Tangent<M>, radius: f64) -> f64;

    /// The gradient of lambda times `smoothed`; it is feasible.
    fn smoothed_dual<const M: usize>(ku: Tangent<M>, radius: f64, lambda: f64) -> Tangent<M>;
}

/// |q_jp|^2 for all p.
#[inline(always)]
pub fn squares<const M: usize>(Tangent([a, b]): Tangent<M>) -> Row<M> {
    Row::from_fn(|p| a.0[p] * a.0[p] + b.0[p] * b.0[p])
}
