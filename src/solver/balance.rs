//! The weight omega between primal and dual steps: where it starts, and how it follows the moves.
//!
//! At landing steps some 100, 300, 700, ... after the start omega is looked at again. Where some |q_j| has
//! reached lambda, primal and dual moves since the last time should have the same length, in the norms that
//! the steps define, |u - u'|_D = |q - q'|_{1/Sigma}, as in D. Applegate et al., *Practical large-scale linear
//! programming using primal-dual hybrid gradient*, NeurIPS 2021, section 3.3. Where none has, the total
//! variation does not limit q, the problem is bilinear like a linear program, and omega falls to a fraction of
//! the spread of the costs. Finitely many changes harm no convergence.

use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::Problem;
use crate::sweep::sum;

/// Where u and q were when omega was last looked at.
pub(super) struct Balance<const M: usize> {
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    steps: u64,
    window: u64,
    changes: u32,
}

/// Steps until omega is looked at for the first time.
const FIRST_WINDOW: u64 = 100;

/// With so many windows, each twice as long as the last, no run sees the end of them.
const MOST_CHANGES: u32 = 20;

/// A primal or dual move of nearly nothing is no measure.
const LARGEST_CHANGE: f64 = 8.0;

/// A small omega, in units of [`costs_scale`].
const LEAST_OMEGA: f64 = 0.003;

impl<const M: usize> Balance<M> {
    pub(super) fn new(u: &[Row<M>], q: &[Tangent<M>]) -> Self {
        Balance { u: u.to_vec(), q: q.to_vec(), steps: 0, window: FIRST_WINDOW, changes: 0 }
    }

    /// The costs jumped: the windows begin again.
    pub(super) fn restart(&mut self, u: &[Row<M>], q: &[Tangent<M>]) {
        self.u.copy_from_slice(u);
        self.q.copy_from_slice(q);
        (self.steps, self.window, self.changes) = (0, FIRST_WINDOW, 0);
    }

    pub(super) fn count_step(&mut self) {
        self.steps += 1;
    }

    /// The omega to go on with, for feasible u and q of steps D = omega d and Sigma = omega s: the geometric
    /// mean with the one that would have given both moves the same length; or omega / 4 while no q_j has
    /// reached lambda.
    pub(super) fn next<K: Operator>(
        &mut self,
        problem: &Problem<K, M>,
        (u, q): (&[Row<M>], &[Tangent<M>]),
        (d, s): (&[f64], &[f64]),
        omega: f64,
    ) -> f64 {
        if self.steps < self.window || self.changes == MOST_CHANGES {
            return omega;
        }
        let primal = omega * sum(u.len(), |v| (u[v] - self.u[v]).norm_squared() * d[v]);
        let dual = sum(q.len(), |j| (q[j] - self.q[j]).norm_squared() / s[j]) / omega;
        self.u.copy_from_slice(u);
        self.q.copy_from_slice(q);
        (self.steps, self.window, self.changes) = (0, 2 * self.window, self.changes + 1);
        let at_lambda = |j: usize| q[j].norm() >= (1.0 - 1e-9) * problem.lambda;
        if sum(q.len(), |j| f64::from(at_lambda(j))) > 0.0 {
            let factor = (dual / primal).powf(0.25);
            if factor.is_normal() {
                return omega * factor.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE);
            }
            return omega;
        }
        let least = LEAST_OMEGA * costs_scale(problem);
        if omega > least { f64::max(0.25 * omega, least) } else { omega }
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
