//! The weight omega between primal and dual steps: where it starts, and how it follows the moves.
//!
//! At the first feasible pairs after 100, 300, 700, ... steps omega is balanced anew. Where some |q_j| has
//! reached lambda, primal and dual moves since the last time should have the same length, in the norms that
//! the steps define, |u - u'|_D = |q - q'|_{1/Sigma}, as in D. Applegate et al., *Practical large-scale linear
//! programming using primal-dual hybrid gradient*, NeurIPS 2021, section 3.3. Where none has, the total
//! variation does not limit q, the problem is bilinear like a linear program, and omega falls to a fraction of
//! the spread of the costs. Finitely many changes harm no convergence.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::{Iterate, Setting};
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{FORBIDDEN, Problem};
use crate::sweep::{copy, sum};

/// Steps until omega is looked at for the first time.
const FIRST_WINDOW: u64 = 100;

/// With so many windows, each twice as long as the last, no run sees the end of them.
const MOST_CHANGES: u32 = 20;

/// A primal or dual move of nearly nothing is no measure.
const LARGEST_CHANGE: f64 = 8.0;

/// A small omega, in units of [`costs_scale`]. Measured on 10,000 faces, from stretched to needles.
const LEAST_OMEGA: f64 = 0.003;

/// Next to nothing, in units of the costs: with lambda = 0 any steps will do that are no infinite ones.
const NOTHING: f64 = 1e-100;

/// Costs beyond so many times what the total variation asks of a vertex are not paid.
const UNPAID: f64 = 2.0;

/// From this share of lambda on |q_j| has reached it, in single precision too.
const AT_LAMBDA: f64 = 1.0 - 1e-6;

/// Whether omega follows the moves.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Balancing {
    Adaptive,
    Fixed,
}

impl Balancing {
    pub(super) fn setting(&mut self) -> Setting<'_> {
        Setting::choice(
            "balance",
            self,
            "whether omega follows the lengths of the primal and dual moves, or stays",
        )
    }
}

pub(super) struct Balance<const M: usize> {
    /// Where u and q were when omega was last looked at; no q stands for zero.
    u: Vec<Row<M>>,
    q: Option<Vec<Tangent<M>>>,
    steps: u64,
    window: u64,
    changes: u32,
}

impl<const M: usize> Balance<M> {
    /// None if omega is to stay.
    pub(super) fn new(
        balancing: Balancing,
        u: &[Row<M>],
        q: Option<&Vec<Tangent<M>>>,
    ) -> Option<Self> {
        (balancing == Balancing::Adaptive).then(|| Balance {
            u: copy(u),
            q: q.cloned(),
            steps: 0,
            window: FIRST_WINDOW,
            changes: 0,
        })
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

    /// So many steps were made.
    pub(super) fn count(&mut self, steps: u64) {
        self.steps += steps;
    }

    /// Whether the window is over.
    pub(super) fn is_due(&self) -> bool {
        self.steps >= self.window && self.changes < MOST_CHANGES
    }

    /// The omega to go on with, for a feasible pair, reached by steps tau and sigma: the geometric mean with the
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
    let least = NOTHING * problem.spread() / area(problem).sqrt();
    let scale = f64::min(problem.lambda, balance).max(least);
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

/// sum_v min( max_p f_vp - min_p f_vp, 2 lambda mean sum_j |K_jv| ) over the square root of the area: the spread of the
/// costs in the units of q. Another label at v changes the total variation by no more than sqrt(2) lambda sum_j |K_jv|:
/// costs above that are not paid, however large they are, forbidden labels among them.
fn costs_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    let most = UNPAID * problem.lambda * problem.mean_column();
    // Regions that do not exist are no choice.
    let exists: [bool; M] = std::array::from_fn(|p| problem.f.iter().any(|f| f.0[p] != FORBIDDEN));
    let spread = sum(
        problem.f.len(),
        #[inline(always)]
        |v| {
            let f = problem.f[v];
            let cost = |p: usize| if exists[p] { f.0[p] } else { 0.0 };
            let largest = Row::<M>::from_fn(cost).max();
            if largest > most { most } else { largest }
        },
    );
    spread / area(problem).sqrt()
}

fn area<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    sum(problem.k.faces(), |j| problem.k.area(j))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Stencil;
    use crate::samples::{bumpy, random_dual, random_labels, random_problem, rng};

    fn omega(
        balance: &mut Balance<3>,
        problem: &Problem<Stencil, 3>,
        (u, q): (&[Row<3>], &[Tangent<3>]),
    ) -> Option<f64> {
        balance.omega(problem, Iterate { u, q }, |_| 4.0, |_| 9.0, 1.0)
    }

    /// omega becomes omega times the fourth root of the quotient of the squared moves, which count from the last time.
    #[test]
    fn moves_count_from_the_last_time() {
        let mesh = bumpy(6);
        let problem = random_problem::<3>(&mesh, 0.1, 861);
        let mut rng = rng(862);
        let mut pair = || {
            let u = random_labels::<3>(mesh.vertices.len(), 3, &mut rng);
            (u, random_dual::<3>(mesh.faces.len(), 0.1, &mut rng))
        };
        let pairs = [pair(), pair(), pair()];
        let (u, q) = &pairs[0];
        let mut balance = Balance::new(Balancing::Adaptive, u, Some(q)).unwrap();
        for pair in pairs.windows(2) {
            let [(v, r), (u, q)] = pair else { panic!("two") };
            let primal: f64 = u.iter().zip(v).map(|(&u, &v)| 4.0 * (u - v).norm_squared()).sum();
            let dual: f64 = q.iter().zip(r).map(|(&q, &r)| 9.0 * (q - r).norm_squared()).sum();
            let found = omega(&mut balance, &problem, (u, q)).unwrap();
            assert!((found - (dual / primal).sqrt().sqrt()).abs() <= 1e-12, "{found}");
        }
        // Who does not move has no length.
        let (u, q) = &pairs[2];
        assert_eq!(omega(&mut balance, &problem, (u, q)), None);
    }

    /// Labels that are forbidden count like labels that nobody takes, regions that do not exist do not, and the scale of a
    /// problem that has no other costs is that of lambda.
    #[test]
    fn forbidden_labels_have_the_scale_of_lambda() {
        let mesh = bumpy(12);
        let problem = |lambda: f64, cost: f64| {
            let mut problem = random_problem::<3>(&mesh, lambda, 864);
            let seed = |v: usize, p: usize| {
                if v.is_multiple_of(7) && p != v % 2 { cost } else { 0.0 }
            };
            let f = (0..problem.f.len())
                .map(|v| Row::from_fn(|p| if p == 2 { FORBIDDEN } else { seed(v, p) }))
                .collect();
            problem.set_costs(f);
            problem
        };
        let known = costs_scale(&problem(1.0, FORBIDDEN));
        assert!(known > 1.0 && known < 100.0, "{known}");
        for lambda in [1e-6, 1e-2, 1e4] {
            let scale = costs_scale(&problem(lambda, FORBIDDEN));
            assert!((scale / lambda - known).abs() <= 1e-12 * known, "{scale}");
            assert_eq!(scale, costs_scale(&problem(lambda, 1e6 * lambda)));
        }
    }

    /// A single cost that nobody pays adds what one vertex is asked for, however large it is.
    #[test]
    fn one_cost_far_above_all_others_has_no_scale_of_its_own() {
        let mesh = bumpy(12);
        for lambda in [1e-3, 1e-2, 0.1, 10.0] {
            let mut problem = random_problem::<3>(&mesh, lambda, 863);
            let known = costs_scale(&problem);
            let f = problem.f.clone();
            let dear = (f[5].argmin() + 1) % 3;
            for cost in [1e12, 1e20, 1e60, FORBIDDEN] {
                let mut f = f.clone();
                f[5].0[dear] = cost;
                problem.set_costs(f);
                let one = UNPAID * lambda * problem.mean_column() / area(&problem).sqrt();
                let more = costs_scale(&problem) - known;
                assert!((0.0..=1.001 * one).contains(&more), "{cost:e}: {more} {one}");
                assert!(dual_scale(&problem) <= lambda);
            }
        }
    }
}
