//! Preconditioned Douglas-Rachford splitting, with implicit steps at nearly the cost of explicit ones:
//!
//! ```text
//! u <- u + M^-1 ( D u_bar - K^T q_bar - T u )      T = D + K^T Sigma K,  M >= T
//! y  = q_bar + Sigma K u
//! x  = Proj_simplex( 2u - u_bar - tau f )          u_bar <- u_bar + rho (x - u)        tau = D^-1
//! z  = Proj_{|.|<=lambda}( 2y - q_bar )            q_bar <- q_bar + rho (z - y)
//! ```
//!
//! K. Bredies, H. Sun, *Preconditioned Douglas-Rachford splitting methods for convex-concave saddle-point
//! problems*, SIAM J. Numer. Anal. 53, 2015. With an exact solve, M = T, (u, y) is the resolvent of (K^T q, -K u) at
//! (u_bar, q_bar). M is one symmetric Gauss-Seidel sweep (`operator/gauss_seidel.rs`) or, for comparison, T itself by
//! Cholesky. The feasible pair is (x, z); at the fixed point x = u and z = y.
//!
//! The method converges for every M >= T and rho in (0, 2): with tildes for differences from a saddle point,
//! monotonicity gives for each step
//!
//! ```text
//! |u_bar~|_D^2 + |q_bar~|_{1/Sigma}^2 + rho |u~|_{M-T}^2   decreases by at least
//! rho (2 - rho) ( |x - u|_D^2 + |z - y|_{1/Sigma}^2 ) + rho |u - u_before|_{M-T}^2.
//! ```
//!
//! The weight of the third term is rho; therefore rho stays the same at the last step before a sample.
//!
//! Instead of q_bar the solver stores q = q_bar + Sigma K u. Then D u_bar - K^T q_bar - T u = D (u_bar - u) - K^T q,
//! and T need not be applied; after u has moved by delta, y = q + Sigma K delta.
//!
//! Steps: s_j = reach / sqrt(l_j), d_k = sum_{j at k} b_j |K_jk|^2 / (sqrt(l_j) reach), D = omega d and Sigma =
//! omega s, face by face (`operator/bounds.rs`). With reach = 1 they are the local steps of an explicit method,
//! |K^T Sigma K| <= |D|; implicit ones may reach further, until M is too far from T. The weight omega starts at
//! 0.75 lambda, or less if the costs need less, and is balanced (`balance.rs`). T is proportional to omega, so that M
//! is computed only once.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::balance::{self, Balance, Balancing, dual_scale};
use super::{Adjustable, Built, Description, Iterate, OneByOne, Setting, Setup, Step};
use crate::field::{Row, Tangent};
use crate::operator::bounds::{diagonal_above, of_faces, row_bound};
use crate::operator::{Adjoint, Cholesky, GaussSeidel, Operator, normal_matrix};
use crate::problem::Problem;
use crate::prox::project_simplex;
use crate::relaxation::{DualSet, with_set};
use crate::sweep::sweep;

pub(super) const DESCRIPTION: Description = Description {
    name: "douglas-rachford",
    summary: "implicit primal-dual method, preconditioned by a Gauss-Seidel sweep; exact energy, no smoothing",
    reference: "Bredies, Sun 2015",
    steps: "closed form, no power iteration; balanced by the primal and dual moves after 100, 300, 700, ... steps",
};

/// The settings of preconditioned Douglas-Rachford: `inner`, `rho`, `reach`, `step-ratio`, `balance`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How the implicit step is solved.
    pub inner: InnerSolve,
    /// Relaxation, above 0 and below 2.
    pub rho: f64,
    /// Step length, in units of that of an explicit method; none for 3, or 6 with a factorization.
    pub reach: Option<f64>,
    /// Initial omega, in units of the expected size of q (lambda, or less if the costs need less).
    pub step_ratio: f64,
    /// Whether omega is balanced.
    pub balance: Balancing,
}

/// How systems with D + K^T Sigma K are solved.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum InnerSolve {
    /// By one symmetric over-relaxed sweep.
    GaussSeidel,
    /// By a factorization.
    Cholesky,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            inner: InnerSolve::GaussSeidel,
            rho: 1.8,
            reach: None,
            step_ratio: 0.75,
            balance: Balancing::Adaptive,
        }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        vec![
            Setting::choice(
                "inner",
                &mut self.inner,
                "how systems with D + K^T Sigma K are solved: one symmetric over-relaxed sweep, or a factorization",
            ),
            balance::relaxation(&mut self.rho),
            Setting::optional(
                "reach",
                &mut self.reach,
                f64::MIN_POSITIVE..,
                "3; 6 with cholesky",
                "step length, in units of that of an explicit method",
            ),
            Setting::number(
                balance::STEP_RATIO,
                &mut self.step_ratio,
                f64::MIN_POSITIVE..,
                balance::STEP_RATIO_HELP,
            ),
            self.balance.setting(),
        ]
    }
}

pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    settings: &Settings,
    setup: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    Ok(Box::new(OneByOne::new(DouglasRachford::new(settings, setup))))
}

/// A solver for M / omega.
enum Inner {
    GaussSeidel(GaussSeidel),
    Cholesky(Cholesky),
}

impl Inner {
    /// x = omega M^-1 r, as read by [`at`](Self::at).
    #[inline(always)]
    fn solve<const M: usize>(&self, x: &mut [Row<M>], r: impl Fn(usize) -> Row<M> + Sync) {
        match self {
            Inner::GaussSeidel(sweeps) => sweeps.solve(x, r),
            Inner::Cholesky(factor) => {
                sweep(
                    &mut x[..],
                    #[inline(always)]
                    |v, x| *x = r(v),
                );
                factor.solve(x);
            }
        }
    }

    /// Row v of a solution.
    #[inline(always)]
    fn at<const M: usize>(&self, x: &[Row<M>], v: usize) -> Row<M> {
        match self {
            Inner::GaussSeidel(sweeps) => sweeps.at(x, v),
            Inner::Cholesky(_) => x[v],
        }
    }
}

struct DouglasRachford<const M: usize> {
    u: Vec<Row<M>>,
    u_bar: Vec<Row<M>>,
    /// q_bar + Sigma K u.
    q: Vec<Tangent<M>>,
    /// The last change of u.
    delta: Vec<Row<M>>,
    /// The same in the order of the inner solver.
    solution: Vec<Row<M>>,
    /// The feasible pair of the last step that was followed by a sample.
    x: Vec<Row<M>>,
    z: Vec<Tangent<M>>,
    /// Whether that was the most recent step.
    is_feasible: bool,
    d: Vec<f64>,
    s: Vec<f64>,
    inner: Inner,
    omega: f64,
    step_ratio: f64,
    balance: Option<Balance<M>>,
    rho: f64,
}

impl<const M: usize> DouglasRachford<M> {
    fn new<K: Operator>(settings: &Settings, setup: Setup<'_, K, M>) -> Self {
        let Settings { inner, rho, reach, step_ratio, balance } = *settings;
        let Setup { problem, start: u, dual_start, .. } = setup;
        let k = &problem.k;
        let exact = inner == InnerSolve::Cholesky;
        let (d, s) = step_lengths(k, reach.unwrap_or(if exact { 6.0 } else { 3.0 }));
        let t = normal_matrix(k, &d, &s);
        let inner = if exact {
            Inner::Cholesky(Cholesky::new(&t).expect("D makes T positive definite"))
        } else {
            Inner::GaussSeidel(GaussSeidel::new(&t))
        };
        let omega = step_ratio * dual_scale(problem);
        let balance = Balance::new(balance, &u, dual_start.as_ref());
        let q = dual_start.unwrap_or_else(|| vec![Tangent::ZERO; k.faces()]);
        // With D (u_bar - u) = K^T q, a saddle point (u, q) is a fixed point.
        let kt = k.adjoint();
        let u_bar = (u.iter().zip(&d).enumerate())
            .map(|(v, (&u, d))| u + 1.0 / (omega * d) * kt.at(&q, v))
            .collect();
        DouglasRachford {
            balance,
            x: u.clone(),
            z: q.clone(),
            is_feasible: true,
            delta: vec![Row::ZERO; u.len()],
            solution: vec![Row::ZERO; u.len()],
            u,
            u_bar,
            q,
            d,
            s,
            inner,
            omega,
            step_ratio,
            rho,
        }
    }

    /// Changes D and Sigma, and keeps D (u_bar - u) and q_bar + Sigma K u.
    fn set_omega(&mut self, omega: f64) {
        let factor = self.omega / omega;
        sweep(
            (&mut self.u_bar[..], &self.u[..]),
            #[inline(always)]
            |_, (u_bar, &u)| *u_bar = u + factor * (*u_bar - u),
        );
        self.omega = omega;
    }

    /// One iteration, which stores (x, z) if `store`.
    fn iterate_and_store<K: Operator>(&mut self, store: bool, problem: &Problem<K, M>) {
        let Problem { k, f, lambda, relaxation, .. } = problem;
        let kt = k.adjoint();
        let Self { u, u_bar, q, delta, solution, x, z, d, s, inner, omega, rho, .. } = self;
        let (omega, inverse_omega, rho) = (*omega, 1.0 / *omega, *rho);
        // delta = M^-1 ( D (u_bar - u) - K^T (q_bar + Sigma K u) )
        inner.solve(
            solution,
            #[inline(always)]
            |v| d[v] * (u_bar[v] - u[v]) - inverse_omega * kt.at(q, v),
        );
        // u <- u + delta,   x = Proj_simplex( 2u - u_bar - tau f ),   u_bar <- u_bar + rho (x - u)
        sweep(
            (&mut u[..], &mut u_bar[..], &mut delta[..], &mut x[..], &d[..], &f[..]),
            #[inline(always)]
            |v, (u, u_bar, delta, stored, &d, &f)| {
                *delta = inner.at(solution, v);
                *u += *delta;
                let x = project_simplex(2.0 * *u - *u_bar - inverse_omega / d * f);
                *u_bar += rho * (x - *u);
                if store {
                    *stored = x;
                }
            },
        );
        // y = q + Sigma K delta,   z = Proj_{|.|<=lambda}( y + Sigma K u ),   q <- y + rho (z - y)
        with_set!(*relaxation, set => sweep(
            (&mut q[..], &mut z[..], &s[..]),
            #[inline(always)]
            |j, (q, stored, &s)| {
                let sigma = omega * s;
                let y = *q + sigma * k.at(delta, j);
                let z = set.project(y + sigma * k.at(u, j), *lambda);
                *q = y + rho * (z - y);
                if store {
                    *stored = z;
                }
            },
        ));
        self.is_feasible = store;
        self.balance.iter_mut().for_each(|balance| balance.count(1));
    }
}

/// d and s. A vertex without faces gets the smallest d of the others.
fn step_lengths(k: &impl Operator, reach: f64) -> (Vec<f64>, Vec<f64>) {
    let local = of_faces(
        k,
        #[inline(always)]
        |columns| 1.0 / row_bound(columns).sqrt(),
    );
    let above = diagonal_above(k, |j| local[j]);
    let smallest = above.iter().copied().filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
    let d = above.into_iter().map(|x| if x > 0.0 { x } else { smallest } / reach).collect();
    (d, local.into_iter().map(|x| x * reach).collect())
}

impl<K: Operator, const M: usize> Step<K, M> for DouglasRachford<M> {
    fn step(&mut self, problem: &Problem<K, M>) {
        self.iterate_and_store(false, problem);
    }

    fn last_step(&mut self, problem: &Problem<K, M>) {
        self.iterate_and_store(true, problem);
        let Self { x, z, d, s, omega, balance, .. } = self;
        if let Some(balance) = balance.as_mut().filter(|balance| balance.is_due()) {
            let (omega, inverse_omega) = (*omega, 1.0 / *omega);
            let now = Iterate { u: x, q: z };
            let (inverse_tau, inverse_sigma) =
                (|v: usize| omega * d[v], |j: usize| inverse_omega / s[j]);
            if let Some(next) = balance.omega(problem, now, inverse_tau, inverse_sigma, omega) {
                self.set_omega(next);
            }
        }
    }

    fn iterate(&self) -> Iterate<'_, M> {
        if self.is_feasible {
            Iterate { u: &self.x, q: &self.z }
        } else {
            Iterate { u: &self.u, q: &self.q }
        }
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.set_omega(self.step_ratio * dual_scale(problem));
        if let Some(balance) = &mut self.balance {
            balance.restart(Iterate { u: &self.u, q: &self.q });
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::operator::Stencil;
    use crate::samples::{bumpy, known_optimum, random_labels, rng};

    /// A saddle point remains a fixed point when D and Sigma change.
    #[test]
    fn a_saddle_point_remains_fixed_when_omega_changes() {
        let mesh = bumpy(7);
        let known = known_optimum::<3>(&mesh, 3, 0.1, 1.0, 79);
        let setup = Setup {
            domain: (&mesh).into(),
            problem: &known.problem,
            start: known.u.clone(),
            dual_start: Some(known.q.clone()),
        };
        let mut solver = DouglasRachford::new(&Settings::default(), setup);
        for factor in [5.0, 0.01, 1.0] {
            solver.set_omega(factor * 0.1);
            (0..5).for_each(|_| Step::<Stencil, 3>::last_step(&mut solver, &known.problem));
            assert!(solver.x.iter().zip(&known.u).all(|(&x, &u)| (x - u).max_abs() <= 1e-9));
            assert!(solver.z.iter().zip(&known.q).all(|(&z, &q)| (z - q).norm() <= 1e-9));
        }
    }

    /// The inequality at the top of this file holds for each step, before a sample or not.
    #[test]
    fn the_distance_to_a_saddle_point_decreases() {
        let mesh = bumpy(6);
        let n = mesh.vertices.len();
        let known = known_optimum::<2>(&mesh, 2, 0.1, 1.0, 77);
        let k = &known.problem.k;
        for rho in [0.7, 1.8, 1.95] {
            let settings = Settings { rho, balance: Balancing::Fixed, ..Settings::default() };
            let start = random_labels(n, 2, &mut rng(78));
            let setup =
                Setup { domain: (&mesh).into(), problem: &known.problem, start, dual_start: None };
            let mut solver = DouglasRachford::new(&settings, setup);
            let (rho, omega) = (solver.rho, solver.omega);

            // M - T, column by column.
            let mut inverse = DMatrix::<f64>::zeros(n, n);
            for v in 0..n {
                let mut column = vec![Row::<2>::ZERO; n];
                let unit = |w: usize| if v == w { Row([1.0, 0.0]) } else { Row::ZERO };
                solver.inner.solve(&mut column, unit);
                let column = (0..n).map(|w| solver.inner.at(&column, w).0[0]);
                inverse.set_column(v, &DVector::from_iterator(n, column));
            }
            let t = normal_matrix(k, &solver.d, &solver.s);
            let mut excess = inverse.try_inverse().unwrap();
            t.iter().for_each(|(&value, at)| excess[at] -= value);
            excess *= omega;

            let primal = |a: &[Row<2>], b: &[Row<2>], d: &[f64]| -> f64 {
                (0..n).map(|v| omega * d[v] * (a[v] - b[v]).norm_squared()).sum()
            };
            let dual = |a: &[Tangent<2>], b: &[Tangent<2>], s: &[f64]| -> f64 {
                let term = |j: usize| (a[j] - b[j]).norm_squared() / (omega * s[j]);
                (0..a.len()).map(term).sum()
            };
            let inner = |a: &[Row<2>], b: &[Row<2>]| -> f64 {
                let difference = DMatrix::from_fn(n, 2, |v, p| a[v].0[p] - b[v].0[p]);
                (&excess * &difference).dot(&difference)
            };
            let q_bar = |q: &[Tangent<2>], u: &[Row<2>], s: &[f64]| -> Vec<Tangent<2>> {
                (0..q.len()).map(|j| q[j] - k.at(u, j) * (omega * s[j])).collect()
            };
            let saddle_u_bar: Vec<Row<2>> = (0..n)
                .map(|v| known.u[v] + 1.0 / (omega * solver.d[v]) * k.adjoint().at(&known.q, v))
                .collect();
            let saddle_q_bar = q_bar(&known.q, &known.u, &solver.s);

            let mut first = None;
            for step in 0..200 {
                let u = solver.u.clone();
                let u_bar = solver.u_bar.clone();
                let r = q_bar(&solver.q, &u, &solver.s);
                let distance = primal(&u_bar, &saddle_u_bar, &solver.d)
                    + dual(&r, &saddle_q_bar, &solver.s)
                    + rho * inner(&u, &known.u);
                let first = *first.get_or_insert(distance);
                match step % 5 == 0 {
                    true => Step::<Stencil, 2>::last_step(&mut solver, &known.problem),
                    false => Step::<Stencil, 2>::step(&mut solver, &known.problem),
                }
                let next = q_bar(&solver.q, &solver.u, &solver.s);
                let after = primal(&solver.u_bar, &saddle_u_bar, &solver.d)
                    + dual(&next, &saddle_q_bar, &solver.s)
                    + rho * inner(&solver.u, &known.u);
                let moves = primal(&solver.u_bar, &u_bar, &solver.d) + dual(&next, &r, &solver.s);
                let decrease = (2.0 - rho) / rho * moves + rho * inner(&solver.u, &u);
                assert!(
                    decrease >= 0.0 && after <= distance - decrease + 1e-12 * first,
                    "step {step}"
                );
            }
        }
    }
}
