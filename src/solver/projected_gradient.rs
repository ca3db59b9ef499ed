//! Projected gradient on the smoothed energy, the paper's method, equations (8) to (10):
//!
//! ```text
//! U^{t+1} = Proj_simplex( U^t - tau D^-1 (f + K^T q^t) ),   q^t_j = lambda (K U^t)_j / sqrt(|(K U^t)_j|^2 + eps_j^2)
//! ```
//!
//! A. Delaunoy, K. Fundana, E. Prados, A. Heyden, *Convex multi-region segmentation on manifolds*,
//! ICCV 2009. Converges for tau < 2 / L if D is diagonal.
//!
//! **The consistent mass matrix misses the minimizer.** With D = M, as printed in equation (10), the pointwise
//! projection onto the simplex is not the projection in the metric of M, and for every tau the iteration settles at a
//! point that is not the minimizer. This choice is kept to reproduce the paper's experiment; its certified gap does not
//! close.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::metric::{Metric, MetricName, descend, settings, smoothing};
use super::{Adjustable, Built, Description, Iterate, OneByOne, Setting, Setup, Step};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::problem::{FORBIDDEN_COST, Problem, Smoothing, SmoothingMode};
use crate::prox::project_simplex;
use crate::sweep::sweep;

pub(super) const DESCRIPTION: Description = Description {
    name: "projected-gradient",
    summary: "the paper's method: gradient steps on the smoothed energy, projected onto the simplex",
    reference: "Delaunoy, Fundana, Prados, Heyden, ICCV 2009, equations (8)-(10)",
    steps: "tau = 1/L, L a closed-form bound of the gradient's Lipschitz constant (convergent below 2/L)",
};

/// The settings of projected gradient: `mass-metric`, `epsilon`, `epsilon-mode`, `tau`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// D.
    pub mass_metric: MassMetric,
    /// eps of the smoothing, above 0; none for the default of the mesh.
    pub epsilon: Option<f64>,
    /// The formula of eps_j.
    pub epsilon_mode: SmoothingMode,
    /// The step length, above 0; none for 1/L.
    pub tau: Option<f64>,
}

/// D in equation (10).
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum MassMetric {
    /// The barycentric areas of the vertices.
    Barycentric,
    /// The mixed Voronoi areas of the vertices.
    Voronoi,
    /// The identity.
    None,
    /// The consistent mass matrix, which does not reach the minimizer, see above.
    Consistent,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            mass_metric: MassMetric::Barycentric,
            epsilon: None,
            epsilon_mode: SmoothingMode::Intrinsic,
            tau: None,
        }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        let metric = Setting::choice(
            "mass-metric",
            &mut self.mass_metric,
            "D in equation (10); `consistent` does NOT reach the minimizer (the pointwise projection is wrong in its \
             metric) and is kept to reproduce the paper's experiment",
        );
        let [epsilon, mode] = settings(&mut self.epsilon, &mut self.epsilon_mode);
        let tau =
            Setting::optional("tau", &mut self.tau, f64::MIN_POSITIVE.., "1/L", "step length");
        vec![metric, epsilon, mode, tau]
    }
}

pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    settings: &Settings,
    setup: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    Ok(Box::new(OneByOne::new(ProjectedGradient::new(settings, setup)?)))
}

struct ProjectedGradient<const M: usize> {
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    /// M^-1 (f + K^T q), used with the full mass matrix only.
    gradient: Vec<Row<M>>,
    metric: Metric,
    smoothing: Smoothing,
    tau: f64,
}

impl<const M: usize> ProjectedGradient<M> {
    fn new<K: Operator>(settings: &Settings, setup: Setup<'_, K, M>) -> Result<Self> {
        let Settings { mass_metric, epsilon, epsilon_mode, tau } = *settings;
        let k = &setup.problem.k;
        let smoothing = smoothing(epsilon, epsilon_mode, k)?;
        let name = match mass_metric {
            MassMetric::Barycentric => MetricName::Barycentric,
            MassMetric::Voronoi => MetricName::Voronoi,
            MassMetric::None => MetricName::Unit,
            MassMetric::Consistent => MetricName::Consistent,
        };
        let (metric, bounded) = Metric::new(name, &setup, smoothing);
        let tau = tau.unwrap_or(bounded);
        let gradient = match metric {
            Metric::Diagonal(_) => Vec::new(),
            Metric::Full(_) => vec![Row::ZERO; k.vertices()],
        };
        Ok(ProjectedGradient {
            q: vec![Tangent::ZERO; k.faces()],
            u: setup.start,
            gradient,
            metric,
            smoothing,
            tau,
        })
    }
}

/// g with the given value at forbidden labels.
#[inline(always)]
fn replace_forbidden<const M: usize>(g: Row<M>, f: Row<M>, value: f64) -> Row<M> {
    Row::from_fn(|p| if f.0[p] == FORBIDDEN_COST { value } else { g.0[p] })
}

impl<K: Operator, const M: usize> Step<K, M> for ProjectedGradient<M> {
    fn step(&mut self, problem: &Problem<K, M>) {
        let Problem { k, f, .. } = problem;
        let Self { u, q, gradient, metric, smoothing, tau } = self;
        let (kt, tau) = (k.adjoint(), *tau);
        // q_j = lambda (K U)_j / sqrt(|(K U)_j|^2 + eps_j^2),   so that dE_eps/dU = f + K^T q        (9)
        problem.smoothed_dual(u, *smoothing, q);
        match metric {
            // U <- Proj_simplex( U - tau D^-1 (f + K^T q) )                                     (8), (10)
            Metric::Diagonal(d) => sweep(
                (&mut u[..], &f[..], &d[..]),
                #[inline(always)]
                |v, (u, &f, &d)| {
                    *u = project_simplex(descend(*u, f + kt.at(q, v), tau, d));
                },
            ),
            Metric::Full(mass) => {
                // M^-1 has entries of both signs: FORBIDDEN_COST at one vertex would make labels cheap or expensive at others.
                sweep(
                    (&mut gradient[..], &f[..]),
                    #[inline(always)]
                    |v, (g, &f)| {
                        *g = replace_forbidden(f + kt.at(q, v), f, 0.0);
                    },
                );
                mass.solve(gradient);
                sweep(
                    (&mut u[..], &gradient[..], &f[..]),
                    #[inline(always)]
                    |_, (u, &g, &f)| {
                        *u = project_simplex(*u - tau * replace_forbidden(g, f, FORBIDDEN_COST));
                    },
                );
            }
        }
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn smoothing(&self) -> Option<Smoothing> {
        Some(self.smoothing)
    }
}
