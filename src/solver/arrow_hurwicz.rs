//! The Arrow-Hurwicz method, an example of how to add a solver: this file and one line in `solver/mod.rs`.
//!
//! ```text
//! q <- Proj_{|.|<=lambda}( q + sigma K u )
//! u <- Proj_simplex( u - tau (f + K^T q) )
//! ```
//!
//! K. J. Arrow, L. Hurwicz, H. Uzawa, *Studies in linear and non-linear programming*, 1958. Without over-relaxation it
//! need not converge for steps with sigma tau ||K||^2 = 1; with sigma_n tau_n ||K||^2 far below 1 it approaches the
//! optimum: M. Zhu, T. Chan, *An efficient primal-dual hybrid gradient algorithm for total variation image
//! restoration*, UCLA CAM 08-34, 2008.

use super::balance::dual_scale;
use super::{Adjustable, Built, Description, Iterate, OneByOne, Setting, Setup, Step};
use crate::field::{Row, Tangent};
use crate::operator::bounds::diagonal_above;
use crate::operator::{Adjoint, Operator};
use crate::problem::Problem;
use crate::prox::project_simplex;
use crate::relaxation::{DualSet, with_set};
use crate::sweep::sweep;

pub(super) const DESCRIPTION: Description = Description {
    name: "arrow-hurwicz",
    summary: "ascend in q, descend in u, project both",
    reference: "Arrow, Hurwicz, Uzawa 1958; Zhu, Chan 2008",
    steps: "closed form: sigma = lambda / ||K||, or less if the costs need less, and sigma tau ||K||^2 = ratio",
};

/// The one setting, `ratio`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// sigma tau ||K||^2, above 0 and up to 1.
    pub ratio: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { ratio: 0.25 }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        vec![Setting::number(
            "ratio",
            &mut self.ratio,
            f64::MIN_POSITIVE..=1.0,
            "sigma tau ||K||^2",
        )]
    }
}

struct ArrowHurwicz<const M: usize> {
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    sigma: f64,
    tau: f64,
}

pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    settings: &Settings,
    Setup { problem, start, dual_start, .. }: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    let k = &problem.k;
    let norm = diagonal_above(k, |_| 1.0).into_iter().fold(0.0, f64::max).sqrt();
    let q = dual_start.unwrap_or_else(|| vec![Tangent::ZERO; k.faces()]);
    let scale = dual_scale(problem);
    let (sigma, tau) = (scale / norm, settings.ratio / (scale * norm));
    Ok(Box::new(OneByOne::new(ArrowHurwicz { u: start, q, sigma, tau })))
}

impl<K: Operator, const M: usize> Step<K, M> for ArrowHurwicz<M> {
    fn step(&mut self, Problem { k, f, lambda, relaxation, .. }: &Problem<K, M>) {
        let Self { u, q, sigma, tau } = self;
        let (kt, sigma, tau) = (k.adjoint(), *sigma, *tau);
        // q <- Proj_{|.|<=lambda}( q + sigma K u )
        with_set!(*relaxation, set => sweep(&mut q[..], |j, q| {
            *q = set.project(*q + sigma * k.at(u, j), *lambda);
        }));
        // u <- Proj_simplex( u - tau (f + K^T q) )
        sweep((&mut u[..], &f[..]), |v, (u, &f)| {
            *u = project_simplex(*u - tau * (f + kt.at(q, v)))
        });
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }
}
