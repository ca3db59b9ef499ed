//! FISTA on the smoothed energy, with adaptive restart and optional continuation in eps:
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

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::metric::{Metric, MetricName, descend, settings, smoothing};
use super::{Adjustable, Built, Description, Iterate, OneByOne, Setting, Setup, Step};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::problem::{Problem, Smoothing, SmoothingMode};
use crate::prox::project_simplex;
use crate::sweep::{sum, sweep};

pub(super) const DESCRIPTION: Description = Description {
    name: "fista",
    summary: "accelerated projected gradient on the smoothed energy, restarted adaptively",
    reference: "Beck, Teboulle 2009; restart: O'Donoghue, Candès 2015; continuation: Tran-Dinh 2017",
    steps: "tau = 1/L in a diagonal metric D, L a closed-form bound",
};

/// The settings of FISTA: `mass-metric`, `epsilon`, `epsilon-mode`, `restart`, `continuation`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// D.
    pub mass_metric: MassMetric,
    /// eps of the smoothing, above 0; none for the default of the mesh.
    pub epsilon: Option<f64>,
    /// The formula of eps_j.
    pub epsilon_mode: SmoothingMode,
    /// When momentum is dropped.
    pub restart: Restart,
    /// sqrt(eps) starts at this multiple of its final value, 1 or more, and falls like 1/n. 1, the default, keeps eps
    /// fixed.
    pub continuation: f64,
}

/// The metric D.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum MassMetric {
    /// A bound of the curvature, vertex by vertex.
    Local,
    /// The barycentric areas of the vertices.
    Barycentric,
    /// The mixed Voronoi areas of the vertices.
    Voronoi,
    /// The identity.
    None,
}

/// When momentum is dropped.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Restart {
    /// When it leads uphill.
    Adaptive,
    /// Momentum is kept: FISTA without restart.
    Never,
    /// At every step, which makes it projected gradient.
    Always,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            mass_metric: MassMetric::Local,
            epsilon: None,
            epsilon_mode: SmoothingMode::Intrinsic,
            restart: Restart::Adaptive,
            continuation: 1.0,
        }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        let metric = Setting::choice(
            "mass-metric",
            &mut self.mass_metric,
            "D: a bound of the curvature vertex by vertex, barycentric areas, Voronoi areas, or the identity",
        );
        let [epsilon, mode] = settings(&mut self.epsilon, &mut self.epsilon_mode);
        let restart = Setting::choice(
            "restart",
            &mut self.restart,
            "when momentum is dropped; `always` gives projected gradient",
        );
        let continuation = Setting::number(
            "continuation",
            &mut self.continuation,
            1.0..,
            "sqrt(eps) starts at this multiple of its final value and falls like 1/n; 1 keeps eps fixed",
        );
        vec![metric, epsilon, mode, restart, continuation]
    }
}

pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    settings: &Settings,
    setup: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    Ok(Box::new(OneByOne::new(Fista::new(settings, setup)?)))
}

struct Fista<const M: usize> {
    u: Vec<Row<M>>,
    /// U^{n+1} while U^n is still needed.
    next: Vec<Row<M>>,
    y: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    d: Vec<f64>,
    tau: f64,
    /// The final smoothing.
    smoothing: Smoothing,
    restart: Restart,
    continuation: f64,
    t: f64,
    iteration: u64,
}

impl<const M: usize> Fista<M> {
    fn new<K: Operator>(settings: &Settings, setup: Setup<'_, K, M>) -> Result<Self> {
        let Settings { mass_metric, epsilon, epsilon_mode, restart, continuation } = *settings;
        let k = &setup.problem.k;
        let smoothing = smoothing(epsilon, epsilon_mode, k)?;
        let name = match mass_metric {
            MassMetric::Local => MetricName::Local,
            MassMetric::Barycentric => MetricName::Barycentric,
            MassMetric::Voronoi => MetricName::Voronoi,
            MassMetric::None => MetricName::Unit,
        };
        let (metric, tau) = Metric::new(name, &setup, smoothing);
        let Metric::Diagonal(d) = metric else {
            unreachable!("all metrics offered above are diagonal")
        };
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

    /// The factor by which sqrt(eps), and with it 1 / L, is enlarged at this iteration.
    fn enlargement(&self) -> f64 {
        f64::max(1.0, self.continuation / (self.iteration + 1) as f64)
    }

    fn current_smoothing(&self) -> Smoothing {
        let epsilon = self.smoothing.epsilon * self.enlargement().powi(2);
        Smoothing { epsilon, ..self.smoothing }
    }
}

impl<K: Operator, const M: usize> Step<K, M> for Fista<M> {
    fn step(&mut self, problem: &Problem<K, M>) {
        let Problem { k, f, .. } = problem;
        let kt = k.adjoint();
        let smoothing = self.current_smoothing();
        let tau = self.tau * self.enlargement();
        let Self { u, next, y, q, d, t, .. } = self;
        // q_j = lambda (K Y)_j / sqrt(|(K Y)_j|^2 + eps_j^2)
        problem.smoothed_dual(y, smoothing, q);
        // U^{n+1} = Proj_simplex( Y - tau D^-1 (f + K^T q) )
        sweep(
            (&mut next[..], &y[..], &f[..], &d[..]),
            #[inline(always)]
            |v, (next, &y, &f, &d)| {
                *next = project_simplex(descend(y, f + kt.at(q, v), tau, d));
            },
        );
        let uphill = || {
            let slope = sum(
                u.len(),
                #[inline(always)]
                |v| d[v] * (y[v] - next[v]).dot(next[v] - u[v]),
            );
            slope > 0.0
        };
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
