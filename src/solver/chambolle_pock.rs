//! Over-relaxed Chambolle-Pock with local steps, the default:
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )        u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K (2x - u) )  q <- q + rho (y - q)
//! ```
//!
//! A. Chambolle, T. Pock, *A first-order primal-dual algorithm for convex problems with applications to
//! imaging*, J. Math. Imaging Vis. 40, 2011; relaxation: L. Condat, *A primal-dual splitting method for
//! convex optimization*, J. Optim. Theory Appl. 158, 2013. Steps, each with || Sigma^1/2 K T^1/2 || <= 1:
//!
//! - local: sigma_j = omega / sqrt(l_j), 1 / tau_k = sum_{j at k} sigma_j b_j |K_jk|^2, face by face
//!   (`operator/bounds.rs`);
//! - diagonal: the row and column sums of T. Pock, A. Chambolle, *Diagonal preconditioning for first order
//!   primal-dual algorithms in convex optimization*, ICCV 2011, alpha = 1;
//! - plain: sigma = omega / ||K||, tau = 1 / (omega ||K||), with the closed-form bound of ||K||.
//!
//! The weight omega between the steps starts at 1.5 lambda, or less if the costs need less. At landing steps
//! some 100, 300, 700, ... after the start it is looked at again. Where some |q_j| has reached lambda, primal and
//! dual moves since the last time should have the same length, |u - u'|_{1/tau} = |q - q'|_{1/sigma}, as in
//! D. Applegate et al., *Practical large-scale linear programming using primal-dual hybrid gradient*, NeurIPS
//! 2021, section 3.3. Where none has, the total variation does not limit q, the problem is bilinear like a
//! linear program, and a small omega is 10 to 50 times faster. Finitely many changes harm no convergence.
//!
//! Relaxed iterates are infeasible and poor; a landing step has rho = 1, after which u = x and q = y.

use super::{Description, Iterate, OptionDescription, Setup, Solver};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::operator::bounds::diagonal_above;
use crate::problem::Problem;
use crate::prox::{project_ball, project_simplex};
use crate::sweep::{collect, sum, sweep};

pub const DESCRIPTION: Description = Description {
    name: "chambolle-pock",
    summary: "over-relaxed primal-dual method with steps fitted face by face; exact energy, no smoothing",
    reference: "Chambolle, Pock 2011; relaxation: Condat 2013; diagonal steps: Pock, Chambolle 2011",
    steps: "closed form, no power iteration; balanced by the primal and dual moves after 100, 300, 700, ... steps",
    options: &[
        OptionDescription {
            key: "steps",
            values: "local|diagonal|plain",
            default: "local",
            help: "face by face; row and column sums of |K|; one number from ||K||",
        },
        OptionDescription {
            key: "rho",
            values: "NUMBER",
            default: "1.9",
            help: "relaxation, above 0 and below 2",
        },
        OptionDescription {
            key: "step-ratio",
            values: "NUMBER",
            default: "1.5",
            help: "omega to begin with, in units of lambda (or of what the costs need, if that is less)",
        },
        OptionDescription {
            key: "balance",
            values: "adaptive|fixed",
            default: "adaptive",
            help: "whether omega follows the lengths of the primal and dual moves, or stays",
        },
    ],
};

#[derive(Clone, Copy)]
enum Steps {
    Local,
    Diagonal,
    Plain,
}

pub struct ChambollePock<const M: usize> {
    u: Vec<Row<M>>,
    /// 2x - u.
    u_bar: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    sigma: Vec<f64>,
    tau: Vec<f64>,
    omega: f64,
    step_ratio: f64,
    balance: Option<Balance<M>>,
    rho: f64,
}

/// Where u and q were when omega was last set.
struct Balance<const M: usize> {
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

impl<const M: usize> ChambollePock<M> {
    pub fn new<K: Operator>(setup: Setup<'_, K, M>) -> Result<Self> {
        let Setup { problem, options, start, dual_start, .. } = setup;
        let steps = options.choice(
            "steps",
            &[("local", Steps::Local), ("diagonal", Steps::Diagonal), ("plain", Steps::Plain)],
        )?;
        let rho = options.number("rho", f64::MIN_POSITIVE..2.0)?.unwrap_or(1.9);
        let step_ratio = options.number("step-ratio", f64::MIN_POSITIVE..)?.unwrap_or(1.5);
        let omega = step_ratio * dual_scale(problem);
        let (sigma, tau) = step_lengths(&problem.k, steps, omega);
        let q = dual_start.unwrap_or_else(|| vec![Tangent::ZERO; problem.k.faces()]);
        let balance =
            options.choice("balance", &[("adaptive", true), ("fixed", false)])?.then(|| Balance {
                u: start.clone(),
                q: q.clone(),
                steps: 0,
                window: FIRST_WINDOW,
                changes: 0,
            });
        Ok(ChambollePock {
            u_bar: start.clone(),
            u: start,
            q,
            balance,
            sigma,
            tau,
            omega,
            step_ratio,
            rho,
        })
    }

    fn set_omega(&mut self, omega: f64) {
        let factor = omega / self.omega;
        self.sigma.iter_mut().for_each(|sigma| *sigma *= factor);
        self.tau.iter_mut().for_each(|tau| *tau /= factor);
        self.omega = omega;
    }

    /// omega <- sqrt(omega omega'), with the omega' that would have given both moves the same length; or
    /// omega / 4 while no q_j has reached lambda.
    fn balance<K: Operator>(&mut self, problem: &Problem<K, M>) {
        let Some(Balance { u, q, steps, window, changes }) = &mut self.balance else { return };
        if steps < window || *changes == MOST_CHANGES {
            return;
        }
        let (sigma, tau) = (&self.sigma, &self.tau);
        let primal = sum(u.len(), |v| (self.u[v] - u[v]).norm_squared() / tau[v]);
        let dual = sum(q.len(), |j| (self.q[j] - q[j]).norm_squared() / sigma[j]);
        u.copy_from_slice(&self.u);
        q.copy_from_slice(&self.q);
        (*steps, *window, *changes) = (0, 2 * *window, *changes + 1);
        let at_lambda = |j: usize| self.q[j].norm() >= (1.0 - 1e-9) * problem.lambda;
        if sum(self.q.len(), |j| f64::from(at_lambda(j))) > 0.0 {
            let factor = (dual / primal).powf(0.25);
            if factor.is_normal() {
                self.set_omega(self.omega * factor.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE));
            }
        } else {
            let least = LEAST_OMEGA * costs_scale(problem);
            if self.omega > least {
                self.set_omega(f64::max(0.25 * self.omega, least));
            }
        }
    }
}

/// How large q becomes, to begin with: lambda, where the total variation is what limits it. A lambda so large
/// that the optimum is constant is limited by the costs that q has to balance, K^T q = -(f - mean f). Where
/// lambda is next to nothing so is the scale, and with tau ~ 1 / scale every vertex decides at once.
fn dual_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    let balance = 0.02 * costs_scale(problem);
    let scale = if problem.lambda < balance { problem.lambda.max(1e-9 * balance) } else { balance };
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

/// A small omega, in units of [`costs_scale`]. Measured on 10,000 faces, from stretched to needles.
const LEAST_OMEGA: f64 = 0.003;

/// The spread of the costs over the square root of the area, in the units of q.
fn costs_scale<K: Operator, const M: usize>(problem: &Problem<K, M>) -> f64 {
    problem.spread() / sum(problem.k.faces(), |j| problem.k.area(j)).sqrt()
}

/// sigma_j and tau_k. A vertex without faces gets the largest tau of the others.
fn step_lengths<K: Operator>(k: &K, steps: Steps, omega: f64) -> (Vec<f64>, Vec<f64>) {
    let (sigma, inverse_tau): (Vec<f64>, Vec<f64>) = match steps {
        Steps::Local => {
            let sigma = collect(
                k.faces(),
                #[inline(always)]
                |j| omega / k.face(j).row_bound().sqrt(),
            );
            let inverse_tau = diagonal_above(
                k,
                #[inline(always)]
                |j| sigma[j],
            );
            (sigma, inverse_tau)
        }
        Steps::Diagonal => {
            let mut column_sums = vec![0.0; k.vertices()];
            let sigma = (0..k.faces())
                .map(|j| {
                    let face = k.face(j);
                    for (&v, [a, b]) in face.corners.iter().zip(face.columns) {
                        column_sums[v] += a.abs() + b.abs();
                    }
                    let row_sum =
                        |i: usize| face.columns.iter().map(|c: &[f64; 2]| c[i].abs()).sum::<f64>();
                    omega / f64::max(row_sum(0), row_sum(1))
                })
                .collect();
            (sigma, column_sums.iter().map(|sum| omega * sum).collect())
        }
        Steps::Plain => {
            let norm = diagonal_above(k, |_| 1.0).into_iter().fold(0.0, f64::max).sqrt();
            (vec![omega / norm; k.faces()], vec![omega * norm; k.vertices()])
        }
    };
    let least = inverse_tau.iter().copied().filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
    let tau = collect(
        inverse_tau.len(),
        #[inline(always)]
        |v| 1.0 / if inverse_tau[v] > 0.0 { inverse_tau[v] } else { least },
    );
    (sigma, tau)
}

impl<K: Operator, const M: usize> Solver<K, M> for ChambollePock<M> {
    fn step(&mut self, problem: &Problem<K, M>, land: bool) {
        let Problem { k, f, lambda } = problem;
        let Self { u, u_bar, q, sigma, tau, rho, .. } = self;
        let rho = if land { 1.0 } else { *rho };
        // x = Proj_simplex( u - tau (f + K^T q) ),   u_bar = 2x - u,   u <- u + rho (x - u)
        sweep(
            (&mut *u, &mut *u_bar, &*tau, f),
            #[inline(always)]
            |v, (u, u_bar, &tau, &f)| {
                let x = project_simplex(*u + (f + k.adjoint_at(q, v)) * -tau);
                *u_bar = x * 2.0 + *u * -1.0;
                *u = if land { x } else { *u + (x - *u) * rho };
            },
        );
        // y = Proj_{|.|<=lambda}( q + sigma K u_bar ),   q <- q + rho (y - q)
        sweep(
            (&mut *q, &*sigma),
            #[inline(always)]
            |j, (q, &sigma)| {
                let y = project_ball(*q + k.at(u_bar, j) * sigma, *lambda);
                *q = if land { y } else { *q + (y - *q) * rho };
            },
        );
        if let Some(balance) = &mut self.balance {
            balance.steps += 1;
        }
        if land {
            self.balance(problem);
        }
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.set_omega(self.step_ratio * dual_scale(problem));
        if let Some(balance) = &mut self.balance {
            balance.u.copy_from_slice(&self.u);
            balance.q.copy_from_slice(&self.q);
            (balance.steps, balance.window, balance.changes) = (0, FIRST_WINDOW, 0);
        }
    }
}
