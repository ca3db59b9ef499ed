//! Projected gradient on the smoothed energy, the method of the paper, equations (8) to (10):
//!
//! ```text
//! U^{t+1} = Proj_simplex( U^t - tau D^-1 (f + K^T q^t) ),   q^t_j = lambda (K U^t)_j / sqrt(|(K U^t)_j|^2 + eps_j^2)
//! ```
//!
//! A. Delaunoy, K. Fundana, E. Prados, A. Heyden, *Convex multi-region segmentation on manifolds*,
//! ICCV 2009. Converges for tau < 2 / L if D is diagonal.
//!
//! **The full mass matrix is a trap.** With D = M consistent, as equation (10) prints it, the pointwise
//! projection onto the simplex is not the projection in the metric of M, and the iteration settles at a
//! point that is not the minimizer, whatever tau. It is kept as the paper's experiment; its certified
//! gap does not close.

use super::metric::{EPSILON, EPSILON_MODE, Metric, MetricName, descend, smoothing};
use super::{Description, Iterate, OptionDescription, Setup, Step};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::problem::{NEVER, Problem, Smoothing};
use crate::prox::project_simplex;
use crate::sweep::sweep;

pub const DESCRIPTION: Description = Description {
    name: "projected-gradient",
    summary: "the paper's method: gradient steps on the smoothed energy, projected onto the simplex",
    reference: "Delaunoy, Fundana, Prados, Heyden, ICCV 2009, equations (8)-(10)",
    steps: "tau = 1/L, L a closed-form bound of the gradient's Lipschitz constant (convergent below 2/L)",
    options: &[
        OptionDescription {
            key: "mass-metric",
            values: "barycentric|voronoi|none|consistent",
            default: "barycentric",
            help: "D in equation (10); `consistent` does NOT reach the minimizer (the pointwise projection \
                   is wrong in its metric) and is kept as the paper's experiment",
        },
        EPSILON,
        EPSILON_MODE,
        OptionDescription { key: "tau", values: "NUMBER", default: "1/L", help: "step length" },
    ],
};

pub struct ProjectedGradient<const M: usize> {
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    /// M^-1 (f + K^T q), used with the full mass matrix only.
    gradient: Vec<Row<M>>,
    metric: Metric,
    smoothing: Smoothing,
    tau: f64,
}

impl<const M: usize> ProjectedGradient<M> {
    pub fn new<K: Operator>(setup: Setup<'_, K, M>) -> Result<Self> {
        let k = &setup.problem.k;
        let smoothing = smoothing(setup.options, k)?;
        let name = setup.options.choice(
            "mass-metric",
            &[
                ("barycentric", MetricName::Barycentric),
                ("voronoi", MetricName::Voronoi),
                ("none", MetricName::Unit),
                ("consistent", MetricName::Consistent),
            ],
        )?;
        let (metric, bounded) = Metric::new(name, &setup, smoothing);
        let tau = setup.options.number("tau", f64::MIN_POSITIVE..)?.unwrap_or(bounded);
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

/// g with another value in the regions that are closed.
#[inline(always)]
fn replace_closed<const M: usize>(g: Row<M>, f: Row<M>, value: f64) -> Row<M> {
    Row::from_fn(|p| if f.0[p] == NEVER { value } else { g.0[p] })
}

impl<K: Operator, const M: usize> Step<K, M> for ProjectedGradient<M> {
    fn step(&mut self, Problem { k, f, lambda, .. }: &Problem<K, M>) {
        let Self { u, q, gradient, metric, smoothing, tau } = self;
        let (kt, tau) = (k.adjoint(), *tau);
        // q_j = lambda (K U)_j / sqrt(|(K U)_j|^2 + eps_j^2),   so that dE_eps/dU = f + K^T q        (9)
        sweep(
            &mut q[..],
            #[inline(always)]
            |j, q| *q = smoothing.dual(k.at(u, j), k.area(j), *lambda),
        );
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
                // M^-1 has entries of both signs, which closed regions must not get to see.
                sweep(
                    (&mut gradient[..], &f[..]),
                    #[inline(always)]
                    |v, (g, &f)| {
                        *g = replace_closed(f + kt.at(q, v), f, 0.0);
                    },
                );
                mass.solve(gradient);
                sweep(
                    (&mut u[..], &gradient[..], &f[..]),
                    #[inline(always)]
                    |_, (u, &g, &f)| {
                        *u = project_simplex(*u - tau * replace_closed(g, f, NEVER));
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
