//! The metric in which a smoothed solver's gradient is taken, and the step length it allows.
//!
//! Gradient: D^-1 (f + K^T q), the paper's equation (10) with D the mass matrix. The smoothed total
//! variation has curvature at most w_j = lambda / eps_j on face j, so the gradient is Lipschitz with
//! L = lmax(D^-1 K^T diag(w) K), bounded here in closed form (`operator/bounds.rs`); for the paper's eps,
//! w_j = 2 lambda / sqrt(eps). The consistent mass matrix is at least a quarter of its row sums
//! (face by face, its eigenvalues are A/12, A/12 and A/3), hence its factor 4.

use crate::error::Result;
use crate::field::Row;
use crate::mesh::geometry::{barycentric_areas, mixed_voronoi_areas};
use crate::operator::bounds::diagonal_above;
use crate::operator::mass::consistent_inverse;
use crate::operator::{Cholesky, Operator};
use crate::problem::{Problem, Smoothing, SmoothingMode};
use crate::solver::{OptionDescription, Options, Setup};

/// D.
pub enum Metric {
    /// The diagonal; zero at vertices without faces.
    Diagonal(Vec<f64>),
    Full(Cholesky),
}

#[derive(Clone, Copy)]
pub(super) enum MetricName {
    Barycentric,
    Voronoi,
    Consistent,
    Unit,
    Local,
}

impl Metric {
    /// The metric, and the step length tau = 1 / L in it.
    pub(super) fn new<K: Operator, const M: usize>(
        name: MetricName,
        setup: &Setup<'_, K, M>,
        smoothing: Smoothing,
    ) -> (Self, f64) {
        let k = &setup.problem.k;
        let lambda = setup.problem.lambda;
        let curvature = diagonal_above(k, |j| lambda / smoothing.radius(k.area(j)));
        let bound = |diagonal: &[f64]| {
            curvature
                .iter()
                .zip(diagonal)
                .filter(|&(_, &d)| d > 0.0)
                .map(|(above, d)| above / d)
                .fold(0.0, f64::max)
        };
        let step = |lipschitz: f64, diagonal: &[f64]| {
            if lipschitz > 0.0 { 1.0 / lipschitz } else { linear_step(setup.problem, diagonal) }
        };
        let diagonal = |diagonal: Vec<f64>| {
            let tau = step(bound(&diagonal), &diagonal);
            (Metric::Diagonal(diagonal), tau)
        };
        match name {
            MetricName::Barycentric => diagonal(barycentric_areas(setup.mesh)),
            MetricName::Voronoi => diagonal(mixed_voronoi_areas(setup.mesh)),
            MetricName::Unit => diagonal(vec![1.0; curvature.len()]),
            MetricName::Local => diagonal(curvature.clone()),
            MetricName::Consistent => {
                let lumped = barycentric_areas(setup.mesh);
                let tau = step(4.0 * bound(&lumped), &lumped);
                (Metric::Full(consistent_inverse(setup.mesh)), tau)
            }
        }
    }
}

/// Without total variation the energy is linear and L = 0. A step that crosses the simplex wherever the
/// choice between regions weighs at least a millionth of the average.
fn linear_step<K: Operator, const M: usize>(problem: &Problem<K, M>, d: &[f64]) -> f64 {
    let step = 1e6 * d.iter().sum::<f64>() / problem.spread();
    if step.is_finite() && step > 0.0 { step } else { 1.0 }
}

pub(super) const EPSILON: OptionDescription = OptionDescription {
    key: "epsilon",
    values: "NUMBER",
    default: "from the mesh",
    help: "eps of the smoothing",
};

pub(super) const EPSILON_MODE: OptionDescription = OptionDescription {
    key: "epsilon-mode",
    values: "intrinsic|paper",
    default: "intrinsic",
    help: "intrinsic: A sqrt(|grad u|^2 + eps); paper: (1/2) sqrt(xi + eps), as printed",
};

/// The smoothing asked for by the options `epsilon` and `epsilon-mode`.
pub(super) fn smoothing(options: &Options, k: &impl Operator) -> Result<Smoothing> {
    let mode = options.choice(
        "epsilon-mode",
        &[("intrinsic", SmoothingMode::Intrinsic), ("paper", SmoothingMode::Paper)],
    )?;
    match options.number("epsilon", f64::MIN_POSITIVE..)? {
        Some(epsilon) => Smoothing::new(mode, epsilon),
        None => Ok(Smoothing::default_for(k, mode)),
    }
}

/// u - tau D^-1 g at one vertex of a diagonal metric. Where D is zero nothing but g decides: the step
/// goes to the best region at once.
#[inline(always)]
pub(super) fn descend<const M: usize>(u: Row<M>, g: Row<M>, tau: f64, d: f64) -> Row<M> {
    if d > 0.0 {
        u + g * (-tau / d)
    } else if g.max() > g.min() {
        Row::one_hot(g.argmin())
    } else {
        u
    }
}
