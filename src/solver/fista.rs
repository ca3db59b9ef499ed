//! FISTA on the smoothed energy, with adaptive restart and, on request, continuation in eps:
//!
//! ```text
//! U^{n+1} = Proj_simplex( Y^n - tau D^-1 (f + K^T q^n) ),   q^n_j = lambda (K Y^n)_j / sqrt(|(K Y^n)_j|^2 + eps_j^2)
//! Y^{n+1} = U^{n+1} + (t_n - 1) / t_{n+1} (U^{n+1} - U^n),  t_{n+1} = (1 + sqrt(1 + 4 t_n^2)) / 2
//! ```
//!
//! A. Beck, M. Teboulle, *A fast iterative shrinkage-thresholding algorithm for linear inverse problems*,
//! SIAM J. Imaging Sciences 2(1), 2009. Restart t = 1 when <D (Y^n - U^{n+1}), U^{n+1} - U^n> > 0:
//! B. O'Donoghue, E. Candès, *Adaptive restart for accelerated gradient schemes*, Found. Comput. Math. 15,
//! 2015. Continuation: sqrt(eps) starts larger and falls like 1/n, as in Q. Tran-Dinh, *Adaptive smoothing
//! algorithms for nonsmooth composite convex minimization*, Comput. Optim. Appl. 66, 2017.

use super::metric::{EPSILON, EPSILON_MODE, Metric, MetricName, descend, smoothing};
use super::{Description, Iterate, OptionDescription, Setup, Step};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::problem::{Problem, Smoothing};
use crate::prox::project_simplex;
use crate::sweep::{sum, sweep};

pub const DESCRIPTION: Description = Description {
    name: "fista",
    summary: "accelerated projected gradient on the smoothed energy, restarted adaptively",
    reference: "Beck, Teboulle 2009; restart: O'Donoghue, Candès 2015; continuation: Tran-Dinh 2017",
    steps: "tau = 1/L in a diagonal metric D, L a closed-form bound",
    options: &[
        OptionDescription {
            key: "mass-metric",
            values: "local|barycentric|voronoi|none",
            default: "local",
            help: "D: the lumped masses, the identity, or the bound of the curvature vertex by vertex",
        },
        EPSILON,
        EPSILON_MODE,
        OptionDescription {
            key: "restart",
            values: "adaptive|never|always",
            default: "adaptive",
            help: "when momentum is dropped; `always` is projected gradient",
        },
        OptionDescription {
            key: "continuation",
            values: "NUMBER",
            default: "1",
            help: "start with this times sqrt(eps) and divide by the iteration; 1 keeps eps fixed",
        },
    ],
};

#[derive(Clone, Copy)]
enum Restart {
    Adaptive,
    Never,
    Always,
}

pub struct Fista<const M: usize> {
    u: Vec<Row<M>>,
    /// U^{n+1} while U^n is still needed.
    next: Vec<Row<M>>,
    y: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    d: Vec<f64>,
    tau: f64,
    /// The smoothing that is aimed at.
    smoothing: Smoothing,
    restart: Restart,
    continuation: f64,
    t: f64,
    iteration: u64,
}

impl<const M: usize> Fista<M> {
    pub fn new<K: Operator>(setup: Setup<'_, K, M>) -> Result<Self> {
        let k = &setup.problem.k;
        let smoothing = smoothing(setup.options, k)?;
        let name = setup.options.choice(
            "mass-metric",
            &[
                ("local", MetricName::Local),
                ("barycentric", MetricName::Barycentric),
                ("voronoi", MetricName::Voronoi),
                ("none", MetricName::Unit),
            ],
        )?;
        let (metric, tau) = Metric::new(name, &setup, smoothing);
        let Metric::Diagonal(d) = metric else {
            unreachable!("all metrics offered above are diagonal")
        };
        let restart = setup.options.choice(
            "restart",
            &[
                ("adaptive", Restart::Adaptive),
                ("never", Restart::Never),
                ("always", Restart::Always),
            ],
        )?;
        let continuation = setup.options.number("continuation", 1.0..)?.unwrap_or(1.0);
        Ok(Fista {
            q: vec![Tangent::ZERO; k.faces()],
            next: setup.start.clone(),
            y: setup.start.clone(),
            u: setup.start,
            d,
            tau,
            smoothing,
            restart,
            continuation,
            t: 1.0,
            iteration: 0,
        })
    }

    /// What sqrt(eps), and with it 1 / L, is multiplied by at this iteration.
    fn enlargement(&self) -> f64 {
        f64::max(1.0, self.continuation / (self.iteration + 1) as f64)
    }

    fn current_smoothing(&self) -> Smoothing {
        let epsilon = self.smoothing.epsilon * self.enlargement().powi(2);
        Smoothing { epsilon, ..self.smoothing }
    }
}

impl<K: Operator, const M: usize> Step<K, M> for Fista<M> {
    fn step(&mut self, Problem { k, f, lambda, .. }: &Problem<K, M>) {
        let kt = k.adjoint();
        let smoothing = self.current_smoothing();
        let tau = self.tau * self.enlargement();
        let Self { u, next, y, q, d, t, .. } = self;
        // q_j = lambda (K Y)_j / sqrt(|(K Y)_j|^2 + eps_j^2)
        sweep(
            &mut q[..],
            #[inline(always)]
            |j, q| *q = smoothing.dual(k.at(y, j), k.area(j), *lambda),
        );
        // U^{n+1} = Proj_simplex( Y - tau D^-1 (f + K^T q) )
        sweep(
            (&mut next[..], &y[..], &f[..], &d[..]),
            #[inline(always)]
            |v, (next, &y, &f, &d)| {
                *next = project_simplex(descend(y, f + kt.at(q, v), tau, d));
            },
        );
        let uphill = || sum(u.len(), |v| d[v] * (y[v] - next[v]).dot(next[v] - u[v])) > 0.0;
        let drop_momentum = match self.restart {
            Restart::Adaptive => uphill(),
            Restart::Never => false,
            Restart::Always => true,
        };
        let t_next = if drop_momentum { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * *t * *t).sqrt()) };
        let momentum = if drop_momentum { 0.0 } else { (*t - 1.0) / t_next };
        // Y^{n+1} = U^{n+1} + (t_n - 1) / t_{n+1} (U^{n+1} - U^n)
        sweep(
            (&mut y[..], &next[..], &u[..]),
            #[inline(always)]
            |_, (y, &next, &u)| *y = next + momentum * (next - u),
        );
        std::mem::swap(u, next);
        *t = t_next;
        self.iteration += 1;
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn restart(&mut self, _problem: &Problem<K, M>) {
        self.t = 1.0;
        self.y.copy_from_slice(&self.u);
    }

    fn smoothing(&self) -> Option<Smoothing> {
        Some(self.current_smoothing())
    }
}
