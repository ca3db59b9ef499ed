//! The metric D in which the gradient of the smoothed energy is taken, and the step length that it allows.
//!
//! The gradient is D^-1 (f + K^T q), the paper's equation (10) with D the mass matrix. The smoothed total variation has
//! curvature at most w_j = lambda / eps_j on face j, so the gradient is Lipschitz continuous with constant
//! L = lmax(D^-1 K^T diag(w) K), bounded here in closed form (`operator/bounds.rs`). For the paper's eps,
//! w_j = 2 lambda / sqrt(eps). The consistent mass matrix is at least a quarter of its row sums (its eigenvalues on a
//! face are A/12, A/12 and A/3), hence its factor 4.

use crate::domain::Domain;
use crate::error::Result;
use crate::field::Row;
use crate::operator::bounds::diagonal_above;
use crate::operator::mass::consistent_inverse;
use crate::operator::{Cholesky, Mass, Operator};
use crate::problem::{Problem, Smoothing, SmoothingMode};
use crate::solver::{Setting, Setup};

/// The metric D.
pub enum Metric {
    /// The diagonal; zero at vertices without faces.
    Diagonal(Vec<f64>),
    Full(Cholesky),
}

/// The choices of D.
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
            MetricName::Barycentric => diagonal(setup.domain.weights(Mass::Barycentric)),
            MetricName::Voronoi => diagonal(setup.domain.weights(Mass::Voronoi)),
            MetricName::Unit => diagonal(vec![1.0; curvature.len()]),
            MetricName::Local => diagonal(curvature.clone()),
            MetricName::Consistent => {
                let lumped = setup.domain.weights(Mass::Consistent);
                match setup.domain {
                    Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => {
                        let tau = step(4.0 * bound(&lumped), &lumped);
                        (Metric::Full(consistent_inverse(mesh)), tau)
                    }
                    Domain::Faces(_) => diagonal(lumped),
                }
            }
        }
    }
}

/// The step length without total variation, where the energy is linear and L = 0: a step crosses the simplex wherever
/// the costs of regions differ by at least a millionth of the average.
fn linear_step<K: Operator, const M: usize>(problem: &Problem<K, M>, d: &[f64]) -> f64 {
    let step = 1e6 * d.iter().sum::<f64>() / problem.spread();
    if step.is_finite() && step > 0.0 { step } else { 1.0 }
}

/// The settings `epsilon` and `epsilon-mode`.
pub(super) fn settings<'a>(
    epsilon: &'a mut Option<f64>,
    mode: &'a mut SmoothingMode,
) -> [Setting<'a>; 2] {
    [
        Setting::optional(
            "epsilon",
            epsilon,
            f64::MIN_POSITIVE..,
            "from the mesh",
            "eps of the smoothing",
        ),
        Setting::choice(
            "epsilon-mode",
            mode,
            "intrinsic: A sqrt(|grad u|^2 + eps); paper: (1/2) sqrt(xi + eps), as printed",
        ),
    ]
}

/// The smoothing with the given eps, or with the default for the mesh.
pub(super) fn smoothing(
    epsilon: Option<f64>,
    mode: SmoothingMode,
    k: &impl Operator,
) -> Result<Smoothing> {
    match epsilon {
        Some(epsilon) => Smoothing::new(mode, epsilon),
        None => Ok(Smoothing::default_for(k, mode)),
    }
}

/// u - tau D^-1 g at one vertex, in a diagonal metric. If D is zero there, the step goes straight to the region with
/// the smallest g.
#[inline(always)]
pub(super) fn descend<const M: usize>(u: Row<M>, g: Row<M>, tau: f64, d: f64) -> Row<M> {
    if d > 0.0 {
        u - (tau / d) * g
    } else if g.max() > g.min() {
        Row::one_hot(g.argmin())
    } else {
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Stencil;
    use crate::operator::mass::consistent_matrix;
    use crate::samples::{largest_curvature, random_problem, shape, zoo};
    use nalgebra::DMatrix;

    /// tau D^-1 K^T diag(lambda / eps_j) K, the curvature of the smoothed energy, has no eigenvalue above 1, so that
    /// tau <= 1 / L. It has the eigenvalue 1 if the bound is exact: in the local metric, on a chessboard of
    /// right-angled faces.
    #[test]
    fn tau_is_at_most_one_over_the_curvature() {
        let chessboard = ("chessboard", shape("grid:7x7"));
        for (name, mesh) in zoo().into_iter().chain([chessboard]) {
            let problem = random_problem::<3>(&mesh, 0.1 * mesh.area().sqrt(), 851);
            let k = &problem.k;
            let start = Vec::new();
            let setup =
                Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
            for mode in [SmoothingMode::Paper, SmoothingMode::Intrinsic] {
                let smoothing = Smoothing::default_for(k, mode);
                // The second derivative of lambda sqrt(x^2 + eps^2) at zero.
                let w = |j: usize| match mode {
                    SmoothingMode::Paper => 2.0 * problem.lambda / smoothing.epsilon.sqrt(),
                    SmoothingMode::Intrinsic => {
                        problem.lambda / (mesh.face_area(j) * smoothing.epsilon.sqrt())
                    }
                };
                for metric in [
                    MetricName::Barycentric,
                    MetricName::Voronoi,
                    MetricName::Unit,
                    MetricName::Local,
                ] {
                    let (Metric::Diagonal(d), tau) = Metric::new(metric, &setup, smoothing) else {
                        panic!("not diagonal");
                    };
                    let largest = largest_curvature(k, w, |v| d[v] / tau);
                    assert!(largest <= 1.0 + 1e-10, "{name}, {mode:?}: {largest}");
                    let exact = name == "chessboard" && matches!(metric, MetricName::Local);
                    assert!(!exact || largest >= 1.0 - 1e-10, "{mode:?}: {largest}");
                }
                let (_, tau) = Metric::new(MetricName::Consistent, &setup, smoothing);
                let largest = largest_in_full_metric(&mesh, k, w);
                assert!(tau * largest <= 1.0 + 1e-9, "{name}, {mode:?}: {}", tau * largest);
            }
        }
    }

    /// The largest eigenvalue of M^-1 K^T diag(w) K, M the consistent mass matrix.
    fn largest_in_full_metric(
        mesh: &crate::mesh::Mesh,
        k: &Stencil,
        w: impl Fn(usize) -> f64,
    ) -> f64 {
        let n = k.vertices();
        let (mut mass, mut normal) = (DMatrix::<f64>::zeros(n, n), DMatrix::<f64>::zeros(n, n));
        for (&value, (a, b)) in consistent_matrix(mesh).iter() {
            mass[(a, b)] = value;
        }
        for j in 0..k.faces() {
            let face = k.face(j);
            for (&a, [ax, ay]) in face.corners.iter().zip(face.columns) {
                for (&b, [bx, by]) in face.corners.iter().zip(face.columns) {
                    normal[(a, b)] += w(j) * (ax * bx + ay * by);
                }
            }
        }
        for v in 0..n {
            if mass[(v, v)] == 0.0 {
                mass[(v, v)] = 1.0;
            }
        }
        let root = mass.cholesky().unwrap().l();
        let half = root.solve_lower_triangular(&normal).unwrap();
        let both = root.solve_lower_triangular(&half.transpose()).unwrap();
        (0.5 * (&both + both.transpose())).symmetric_eigenvalues().max()
    }
}
