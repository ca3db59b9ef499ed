//! The weight omega between primal and dual steps: where it starts, and how it follows the moves.
//!
//! At landing steps some 100, 300, 700, ... after the start omega is looked at again. Where some |q_j| has
//! reached lambda, primal and dual moves since the last time should have the same length, in the norms that
//! the steps define, |u - u'|_D = |q - q'|_{1/Sigma}, as in D. Applegate et al., *Practical large-scale linear
//! programming using primal-dual hybrid gradient*, NeurIPS 2021, section 3.3. Where none has, the total
//! variation does not limit q, the problem is bilinear like a linear program, and omega falls to a fraction of
//! the spread of the costs. Finitely many changes harm no convergence.

use super::{Iterate, Options};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::Problem;
use crate::sweep::{copy, sum};

/// Steps until omega is looked at for the first time.
const FIRST_WINDOW: u64 = 100;

/// With so many windows, each twice as long as the last, no run sees the end of them.
const MOST_CHANGES: u32 = 20;

/// A primal or dual move of nearly nothing is no measure.
const LARGEST_CHANGE: f64 = 8.0;

/// A small omega, in units of [`costs_scale`]. Measured on 10,000 faces, from stretched to needles.
const LEAST_OMEGA: f64 = 0.003;

/// From this share of lambda on |q_j| has reached it, in single precision too.
const AT_LAMBDA: f64 = 1.0 - 1e-6;

pub(super) struct Balance<const M: usize> {
    /// Where u and q were when omega was last looked at; no q stands for zero.
    u: Vec<Row<M>>,
    q: Option<Vec<Tangent<M>>>,
    steps: u64,
    window: u64,
    changes: u32,
}

impl<const M: usize> Balance<M> {
    /// None if the user wants omega to stay.
    pub(super) fn new(
        options: &Options,
        u: &[Row<M>],
        q: Option<&Vec<Tangent<M>>>,
    ) -> Result<Option<Self>> {
        let adaptive = options.choice("balance", &[("adaptive", true), ("fixed", false)])?;
        Ok(adaptive.then(|| Balance {
            u: copy(u),
            q: q.cloned(),
            steps: 0,
            window: FIRST_WINDOW,
            changes: 0,
        }))
    }

    /// Begins again from here.
    pub(super) fn restart(&mut self, iterate: Iterate<'_, M>) {
        self.keep(iterate);
        (self.steps, self.window, self.changes) = (0, FIRST_WINDOW, 0);
    }

    fn keep(&mut self, iterate: Iterate<'_, M>) {
        self.u.copy_from_slice(iterate.u);
        match &mut self.q {
            Some(q) => q.copy_from_slice(iterate.q),
            q => *q = Some(iterate.q.to_vec()),
        }
    }

    /// To be called after every step; says whether omega is due, if the step has landed.
    pub(super) fn due(&mut self, land: bool) -> bool {
        self.steps += 1;
        land && self.steps >= self.window && self.changes < MOST_CHANGES
    }

    /// The omega to go on with, for a pair that has landed by steps tau and sigma: the geometric mean with the
    /// one that would have given both moves the same length; or omega / 4 while no q_j has reached lambda.
    /// None if omega should stay.
    pub(super) fn omega<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        now: Iterate<'_, M>,
        inverse_tau: impl Fn(usize) -> f64 + Sync,
        inverse_sigma: impl Fn(usize) -> f64 + Sync,
        omega: f64,
    ) -> Option<f64> {
        let moved = |v: usize| (now.u[v] - self.u[v]).norm_squared();
        let primal = sum(now.u.len(), |v| moved(v) * inverse_tau(v));
        let before = |j: usize| self.q.as_ref().map_or(Tangent::ZERO, |q| q[j]);
        let moved = |j: usize| (now.q[j] - before(j)).norm_squared();
        let dual = sum(now.q.len(), |j| moved(j) * inverse_sigma(j));
        self.keep(now);
        (self.steps, self.window, self.changes) = (0, 2 * self.window, self.changes + 1);
        let at_lambda = |j: usize| now.q[j].norm() >= AT_LAMBDA * problem.lambda;
        if sum(now.q.len(), |j| f64::from(at_lambda(j))) > 0.0 {
            let factor = (dual / primal).powf(0.25);
            factor.is_normal().then(|| omega * factor.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE))
        } else {
            let least = LEAST_OMEGA * costs_scale(problem);
            (omega > least).then(|| f64::max(0.25 * omega, least))
        }
    }
}

/// How large q becomes, to begin with: lambda, where the total variation is what limits it. A lambda so large
/// that the optimum is constant is limited by the costs that q has to balance, K^T q = -(f - mean f). Where
/// lambda is next to nothing so is the scale, and with tau ~ 1 / scale every vertex decides at once.
pub(super) fn dual_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    let balance = 0.02 * costs_scale(problem);
    let scale = if problem.lambda < balance { problem.lambda.max(1e-9 * balance) } else { balance };
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

/// The spread of the costs over the square root of the area, in the units of q.
fn costs_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    problem.spread() / sum(problem.k.faces(), |j| problem.k.area(j)).sqrt()
}
