//! The readable text: one sweep over the vertices, one over the faces, on any operator.

use super::Method;
use super::steps::Steps;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::Problem;
use crate::prox::{project_ball, project_simplex};
use crate::solver::{Iterate, Solver};
use crate::sweep::sweep;

pub struct Rows<const M: usize> {
    pub u: Vec<Row<M>>,
    /// 2x - u.
    pub u_bar: Vec<Row<M>>,
    pub q: Vec<Tangent<M>>,
    pub method: Method<M>,
}

impl<K: Operator, const M: usize> Solver<K, M> for Rows<M> {
    fn step(&mut self, problem: &Problem<K, M>, land: bool) {
        let Problem { k, f, lambda, .. } = problem;
        let Self { u, u_bar, q, method: Method { steps: Steps { sigma, tau, .. }, rho, .. } } =
            self;
        let rho = if land { 1.0 } else { *rho };
        // x = Proj_simplex( u - tau (f + K^T q) ),   u_bar = 2x - u,   u <- u + rho (x - u)
        sweep(
            (&mut u[..], &mut u_bar[..], &tau[..], &f[..]),
            #[inline(always)]
            |v, (u, u_bar, &tau, &f)| {
                let x = project_simplex(*u + (f + k.adjoint_at(q, v)) * -tau);
                *u_bar = x * 2.0 + *u * -1.0;
                *u = if land { x } else { *u + (x - *u) * rho };
            },
        );
        // y = Proj_{|.|<=lambda}( q + sigma K u_bar ),   q <- q + rho (y - q)
        sweep(
            (&mut q[..], &sigma[..]),
            #[inline(always)]
            |j, (q, &sigma)| {
                let y = project_ball(*q + k.at(u_bar, j) * sigma, *lambda);
                *q = if land { y } else { *q + (y - *q) * rho };
            },
        );
        if self.method.due(land) {
            self.method.rebalance(problem, Iterate { u: &self.u, q: &self.q });
        }
    }

    fn iterate(&mut self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.method.restart(problem, Iterate { u: &self.u, q: &self.q });
    }
}
