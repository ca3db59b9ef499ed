//! The reference implementation: one sweep over the vertices and one over the faces, for any operator.

use super::stepping::Stepping;
use super::steps::Steps;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::problem::Problem;
use crate::prox::project_simplex;
use crate::relaxation::{DualSet, with_set};
use crate::solver::{Iterate, Step};
use crate::sweep::sweep;

pub struct Rows<const M: usize> {
    pub u: Vec<Row<M>>,
    /// 2x - u.
    pub u_bar: Vec<Row<M>>,
    pub q: Vec<Tangent<M>>,
    pub stepping: Stepping<M>,
}

impl<const M: usize> Rows<M> {
    /// One iteration. Without `rho`, which means rho = 1, it ends with the feasible pair (x, y).
    fn iterate_with<K: Operator>(&mut self, rho: Option<f64>, problem: &Problem<K, M>) {
        let Problem { k, f, lambda, relaxation, .. } = problem;
        let kt = k.adjoint();
        let Self { u, u_bar, q, stepping: Stepping { steps: Steps { sigma, tau, .. }, .. } } = self;
        // x = Proj_simplex( u - tau (f + K^T q) ),   u_bar = 2x - u,   u <- u + rho (x - u)
        sweep(
            (&mut u[..], &mut u_bar[..], &tau[..], &f[..]),
            #[inline(always)]
            |v, (u, u_bar, &tau, &f)| {
                let x = project_simplex(*u - tau * (f + kt.at(q, v)));
                *u_bar = 2.0 * x - *u;
                // A closure given to `map_or` would not be inlined.
                *u = if let Some(rho) = rho { *u + rho * (x - *u) } else { x };
            },
        );
        // y = Proj_{|.|<=lambda}( q + sigma K u_bar ),   q <- q + rho (y - q)
        with_set!(*relaxation, set => sweep(
            (&mut q[..], &sigma[..]),
            #[inline(always)]
            |j, (q, &sigma)| {
                let y = set.project(*q + sigma * k.at(u_bar, j), *lambda);
                *q = if let Some(rho) = rho { *q + rho * (y - *q) } else { y };
            },
        ));
    }
}

impl<K: Operator, const M: usize> Step<K, M> for Rows<M> {
    fn step(&mut self, problem: &Problem<K, M>) {
        self.iterate_with(Some(self.stepping.rho), problem);
        self.stepping.count(1);
    }

    fn last_step(&mut self, problem: &Problem<K, M>) {
        self.iterate_with(None, problem);
        self.stepping.count(1);
        if self.stepping.is_due() {
            self.stepping.rebalance(problem, Iterate { u: &self.u, q: &self.q });
        }
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn follow(&mut self, problem: &Problem<K, M>) {
        self.stepping.follow(problem);
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.stepping.restart(problem, Iterate { u: &self.u, q: &self.q });
    }
}
