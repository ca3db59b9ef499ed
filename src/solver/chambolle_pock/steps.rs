//! Step lengths with || Sigma^1/2 K T^1/2 || <= 1, and the weight omega between primal and dual steps.
//!
//! - local: sigma_j = omega / sqrt(l_j), 1 / tau_k = sum_{j at k} sigma_j b_j |K_jk|^2, face by face
//!   (`operator/bounds.rs`);
//! - diagonal: the row and column sums of T. Pock, A. Chambolle, *Diagonal preconditioning for first order
//!   primal-dual algorithms in convex optimization*, ICCV 2011, alpha = 1;
//! - plain: sigma = omega / ||K||, tau = 1 / (omega ||K||), with the closed-form bound of ||K||.
//!
//! omega starts at 1.5 lambda, or less if the costs need less.

use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::operator::Operator;
use crate::operator::bounds::{diagonal_above, of_faces, row_bound};
use crate::problem::Problem;
use crate::solver::balance::dual_scale;
use crate::sweep::collect;

/// The rule for the step lengths.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Rule {
    /// From the largest eigenvalues face by face.
    Local,
    /// From the row and column sums of |K|.
    Diagonal,
    /// One length for all faces and one for all vertices, from a bound of ||K||.
    Plain,
}

pub struct Steps {
    /// One per face.
    pub sigma: Vec<f64>,
    /// One per vertex; a vertex without faces has the largest of the others.
    pub tau: Vec<f64>,
    omega: f64,
    ratio: f64,
    /// The expected size of q for the costs that omega was last fitted to.
    dual_scale: f64,
}

impl Steps {
    pub fn new<K: Operator, const M: usize>(
        problem: &Problem<K, M>,
        rule: Rule,
        ratio: f64,
    ) -> Self {
        let dual_scale = dual_scale(problem);
        let omega = ratio * dual_scale;
        let (sigma, tau) = step_lengths(&problem.k, rule, omega);
        Steps { sigma, tau, omega, ratio, dual_scale }
    }

    /// The expected size of q.
    pub fn dual_scale(&self) -> f64 {
        self.dual_scale
    }

    pub fn omega(&self) -> f64 {
        self.omega
    }

    pub fn set_omega(&mut self, omega: f64) {
        let factor = omega / self.omega;
        self.sigma.iter_mut().for_each(|sigma| *sigma *= factor);
        self.tau.iter_mut().for_each(|tau| *tau /= factor);
        self.omega = omega;
    }

    /// Resets omega to its initial value, for costs that changed.
    pub fn restart<K: Operator, const M: usize>(&mut self, problem: &Problem<K, M>) {
        self.dual_scale = dual_scale(problem);
        self.set_omega(self.ratio * self.dual_scale);
    }

    /// Changes omega as much as the expected size of q changes, for costs that changed; returns whether it does.
    pub fn follow<K: Operator, const M: usize>(&mut self, problem: &Problem<K, M>) -> bool {
        let before = std::mem::replace(&mut self.dual_scale, dual_scale(problem));
        let changes = self.dual_scale != before;
        if changes {
            self.set_omega(self.omega * (self.dual_scale / before));
        }
        changes
    }
}

/// sigma_j and tau_k. A vertex without faces gets the largest tau of the others.
fn step_lengths<K: Operator>(k: &K, rule: Rule, omega: f64) -> (Vec<f64>, Vec<f64>) {
    let (sigma, inverse_tau): (Vec<f64>, Vec<f64>) = match rule {
        Rule::Local => {
            let sigma = of_faces(
                k,
                #[inline(always)]
                |columns| omega / row_bound(columns).sqrt(),
            );
            let inverse_tau = diagonal_above(
                k,
                #[inline(always)]
                |j| sigma[j],
            );
            (sigma, inverse_tau)
        }
        Rule::Diagonal => {
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
        Rule::Plain => {
            let norm = diagonal_above(k, |_| 1.0).into_iter().fold(0.0, f64::max).sqrt();
            (vec![omega / norm; k.faces()], vec![omega * norm; k.vertices()])
        }
    };
    let smallest = inverse_tau.iter().copied().filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
    let tau = collect(
        inverse_tau.len(),
        #[inline(always)]
        |v| 1.0 / if inverse_tau[v] > 0.0 { inverse_tau[v] } else { smallest },
    );
    (sigma, tau)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Stencil;
    use crate::samples::{largest_curvature, random_problem, shape, zoo};

    const RULES: [Rule; 3] = [Rule::Local, Rule::Diagonal, Rule::Plain];

    fn steps(problem: &Problem<Stencil, 3>, rule: Rule) -> Steps {
        Steps::new(problem, rule, 1.5)
    }

    /// || Sigma^1/2 K T^1/2 || <= 1, without which the method need not converge, whatever omega becomes.
    #[test]
    fn preconditioned_norm_is_at_most_one() {
        for (name, mesh) in zoo() {
            let problem = random_problem::<3>(&mesh, 0.03 * mesh.area().sqrt(), 841);
            for rule in RULES {
                let mut steps = steps(&problem, rule);
                let omega = steps.omega();
                for factor in [1.0, 7.0, 0.2] {
                    steps.set_omega(factor * omega);
                    let Steps { sigma, tau, .. } = &steps;
                    let largest = largest_curvature(&problem.k, |j| sigma[j], |v| 1.0 / tau[v]);
                    assert!(largest <= 1.0 + 1e-10, "{name}, {rule:?}: {largest}");
                }
            }
        }
    }

    /// Costs that change leave omega the same multiple of the expected size of q, balanced or not.
    #[test]
    fn omega_follows_the_size_of_the_costs() {
        let mesh = shape("torus:12x8");
        let mut problem = random_problem::<3>(&mesh, 10.0, 843);
        let costs = problem.f.clone();
        let mut steps = steps(&problem, Rule::Local);
        let omega = steps.omega();
        steps.set_omega(3.0 * omega);
        assert!(!steps.follow(&problem) && steps.omega() == 3.0 * omega);
        problem.set_costs(costs.iter().map(|&f| f * 0.25).collect());
        assert!(steps.follow(&problem));
        assert!((steps.omega() / (0.75 * omega) - 1.0).abs() <= 1e-12);
    }

    /// The steps are also as long as their rules allow: the local ones attain the bound on a chessboard of right-angled
    /// faces; the others are given by row and column sums, and by one number.
    #[test]
    fn steps_follow_their_rules() {
        let mesh = shape("grid:7x7");
        let problem = random_problem::<3>(&mesh, 0.03, 842);
        let k = &problem.k;
        let faces = || (0..k.faces()).map(|j| (j, k.face(j)));
        let near = |x: f64| (x - 1.0).abs() <= 1e-12;

        let Steps { sigma, tau, .. } = &steps(&problem, RULES[0]);
        assert!(near(largest_curvature(k, |j| sigma[j], |v| 1.0 / tau[v])));

        let Steps { sigma, tau, omega, .. } = &steps(&problem, RULES[1]);
        let mut columns = vec![0.0; k.vertices()];
        for (j, face) in faces() {
            let row = |i: usize| face.columns.iter().map(|c| c[i].abs()).sum::<f64>();
            assert!(near(sigma[j] * f64::max(row(0), row(1)) / omega));
            let of_corner = face.corners.into_iter().zip(face.columns);
            of_corner.for_each(|(v, [x, y])| columns[v] += x.abs() + y.abs());
        }
        assert!(columns.iter().zip(tau).all(|(sum, tau)| near(sum * tau * omega)));

        let Steps { sigma, tau, omega, .. } = &steps(&problem, RULES[2]);
        let square = diagonal_above(k, |_| 1.0).into_iter().fold(0.0, f64::max);
        assert!(sigma.iter().all(|sigma| near(sigma / omega * square.sqrt())));
        assert!(tau.iter().all(|tau| near(tau * omega * square.sqrt())));
    }
}
