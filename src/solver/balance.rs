//! The weight omega between primal and dual steps: its initial value, and its balancing by the lengths of the moves.
//!
//! omega is balanced at the first feasible pairs after 100, 300, 700, ... steps. If some |q_j| has reached lambda, the
//! primal and dual moves since the last time should have the same length, in the norms that the steps define,
//! |u - u'|_D = |q - q'|_{1/Sigma}, as in D. Applegate et al., *Practical large-scale linear programming using
//! primal-dual hybrid gradient*, NeurIPS 2021, section 3.3. If none has, the total variation does not limit q, the
//! problem is bilinear like a linear program, and omega falls to a fraction of the spread of the costs. Finitely many
//! changes do not affect convergence.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::{Iterate, Setting};
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::relaxation::{DualSet, with_set};
use crate::sweep::{copy, sum};

/// The number of steps before omega is balanced for the first time.
const FIRST_WINDOW: u64 = 100;

/// The largest number of times that omega is balanced. Windows double in length, so no run gets this far.
const MAX_CHANGES: u32 = 20;

/// The largest factor by which omega changes at a time, because a nearly vanishing move is no measure.
const MAX_OMEGA_FACTOR: f64 = 8.0;

/// The smallest omega while no |q_j| has reached lambda, in units of [`costs_scale`]. Measured on 10,000 faces, from
/// stretched to needles.
const MIN_OMEGA: f64 = 0.003;

/// The smallest [`dual_scale`], in units of the costs. With lambda = 0 any finite steps will do.
const MIN_DUAL_SCALE: f64 = 1e-100;

/// Costs at a vertex are clipped at this multiple of lambda mean sum_j |K_jv|, see [`costs_scale`].
const MAX_COST: f64 = 2.0;

/// |q_j| counts as having reached lambda from this fraction of it on, even in single precision.
const AT_LAMBDA: f64 = 1.0 - 1e-6;

/// Whether omega follows the moves.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Balancing {
    /// omega is balanced after 100, 300, 700, ... steps, see above.
    Adaptive,
    /// omega stays where it starts.
    Fixed,
}

impl Balancing {
    pub(super) fn setting(&mut self) -> Setting<'_> {
        Setting::choice(
            "balance",
            self,
            "whether omega follows the lengths of the primal and dual moves or stays fixed",
        )
    }
}

/// The setting `rho` of relaxed methods.
pub(super) fn relaxation(rho: &mut f64) -> Setting<'_> {
    Setting::number("rho", rho, f64::MIN_POSITIVE..2.0, "relaxation, above 0 and below 2")
}

/// The setting from which omega starts.
pub(super) const STEP_RATIO: &str = "step-ratio";

pub(super) const STEP_RATIO_HELP: &str =
    "initial omega, in units of the expected size of q (lambda, or less if the costs need less)";

pub(super) struct Balance<const M: usize> {
    /// u and q when omega was last balanced; no q stands for zero.
    u: Vec<Row<M>>,
    q: Option<Vec<Tangent<M>>>,
    steps: u64,
    window: u64,
    changes: u32,
}

impl<const M: usize> Balance<M> {
    /// None if omega stays fixed.
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

    /// Starts over from this pair.
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

    /// Counts steps that were made.
    pub(super) fn count(&mut self, steps: u64) {
        self.steps += steps;
    }

    /// Whether omega should be balanced at the next feasible pair.
    pub(super) fn is_due(&self) -> bool {
        self.steps >= self.window && self.changes < MAX_CHANGES
    }

    /// The next omega, given a feasible pair that was reached by steps tau and sigma: the geometric mean of omega and
    /// the one that would have given both moves the same length; or omega / 4 while no |q_j| has reached lambda. None
    /// if omega should not change.
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
        let reaching = with_set!(problem.relaxation, set => {
            let at_lambda = |j: usize| set.gauge(now.q[j]) >= AT_LAMBDA * problem.lambda;
            sum(now.q.len(), |j| f64::from(at_lambda(j)))
        });
        if reaching > 0.0 {
            let factor = (dual / primal).powf(0.25);
            factor
                .is_normal()
                .then(|| omega * factor.clamp(1.0 / MAX_OMEGA_FACTOR, MAX_OMEGA_FACTOR))
        } else {
            let smallest = MIN_OMEGA * costs_scale(problem);
            (omega > smallest).then(|| f64::max(0.25 * omega, smallest))
        }
    }
}

/// The expected size of q, from which omega starts: lambda, if the total variation limits q. If lambda is so large that
/// the optimum is constant, q is limited by the costs that it has to balance, K^T q = -(f - mean f). If lambda is
/// almost zero so is the scale, and with tau ~ 1 / scale every vertex decides in one step.
pub(super) fn dual_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    let balance = 0.02 * costs_scale(problem);
    let smallest = MIN_DUAL_SCALE * problem.spread() / area(problem).sqrt();
    let scale = f64::min(problem.lambda, balance).max(smallest);
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

/// sum_v min( max_p f_vp - min_p f_vp, 2 lambda mean sum_j |K_jv| ) over the square root of the area: the spread of the
/// costs in the units of q. Another label at v changes lambda TV by no more than sqrt(2) lambda sum_j |K_jv|: no vertex
/// takes a label that costs more, so it does not matter how large such costs are, or whether the label is forbidden.
fn costs_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    let max_cost = MAX_COST * problem.lambda * problem.mean_column();
    // Regions that are forbidden everywhere, such as padding regions, do not count.
    let exists: [bool; M] =
        std::array::from_fn(|p| problem.f.iter().any(|f| f.0[p] != FORBIDDEN_COST));
    let spread = sum(
        problem.f.len(),
        #[inline(always)]
        |v| {
            let f = problem.f[v];
            let cost = |p: usize| if exists[p] { f.0[p] } else { 0.0 };
            let largest = Row::<M>::from_fn(cost).max();
            if largest > max_cost { max_cost } else { largest }
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

    /// omega is multiplied by the fourth root of the quotient of the squared moves since the last time.
    #[test]
    fn omega_follows_the_moves_since_the_last_time() {
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
        // Without a move omega does not change.
        let (u, q) = &pairs[2];
        assert_eq!(omega(&mut balance, &problem, (u, q)), None);
    }

    /// Forbidden labels count like labels that are too expensive, padding regions do not count, and without other costs
    /// the scale is proportional to lambda.
    #[test]
    fn forbidden_labels_have_the_scale_of_lambda() {
        let mesh = bumpy(12);
        let problem = |lambda: f64, cost: f64| {
            let mut problem = random_problem::<3>(&mesh, lambda, 864);
            let seed = |v: usize, p: usize| {
                if v.is_multiple_of(7) && p != v % 2 { cost } else { 0.0 }
            };
            let f = (0..problem.f.len())
                .map(|v| Row::from_fn(|p| if p == 2 { FORBIDDEN_COST } else { seed(v, p) }))
                .collect();
            problem.set_costs(f);
            problem
        };
        let known = costs_scale(&problem(1.0, FORBIDDEN_COST));
        assert!(known > 1.0 && known < 100.0, "{known}");
        for lambda in [1e-6, 1e-2, 1e4] {
            let scale = costs_scale(&problem(lambda, FORBIDDEN_COST));
            assert!((scale / lambda - known).abs() <= 1e-12 * known, "{scale}");
            assert_eq!(scale, costs_scale(&problem(lambda, 1e6 * lambda)));
        }
    }

    /// A single huge cost adds the clipped cost of one vertex, however large it is.
    #[test]
    fn one_huge_cost_does_not_set_the_scale() {
        let mesh = bumpy(12);
        for lambda in [1e-3, 1e-2, 0.1, 10.0] {
            let mut problem = random_problem::<3>(&mesh, lambda, 863);
            let known = costs_scale(&problem);
            let f = problem.f.clone();
            let expensive = (f[5].argmin() + 1) % 3;
            for cost in [1e12, 1e20, 1e60, FORBIDDEN_COST] {
                let mut f = f.clone();
                f[5].0[expensive] = cost;
                problem.set_costs(f);
                let one = MAX_COST * lambda * problem.mean_column() / area(&problem).sqrt();
                let more = costs_scale(&problem) - known;
                assert!((0.0..=1.001 * one).contains(&more), "{cost:e}: {more} {one}");
                assert!(dual_scale(&problem) <= lambda);
            }
        }
    }
}
