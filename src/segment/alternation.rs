//! The alternation on one mesh: r steps of U for given parameters, then the parameters for the U found.
//!
//! ```text
//! U  <- r steps towards the least sum_k <u_k, f_k(mu)> + lambda TV(U)
//! mu <- the least sum_k <u_k, f_k(mu)>
//! ```
//!
//! Delaunoy et al., ICCV 2009, section 3.2; they take r = 10.

use std::time::{Duration, Instant};

use super::unions::{Unions, united, without};
use crate::coarse::Pair;
use crate::data::{DataModel, Initial, Scale};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Stencil;
use crate::problem::{FORBIDDEN, Problem};
use crate::run::{Run, Status, Stop};
use crate::solve::{Observer, Request, check_range};
use crate::solver::{Iterate, Setup, Solver};
use crate::start::cheapest;
use crate::sweep::collect;

/// Re-estimations at the most; after them the parameters count as settled.
pub const MOST_ESTIMATES: usize = 200;

/// Parameters have settled when no one changes by more than this share of the scale of changes.
pub const SETTLED: f64 = 1e-4;

/// What is asked besides the [`Request`] to the solver.
#[derive(Clone, Debug)]
pub struct Alternation {
    /// m.
    pub regions: usize,
    pub initial: Initial,
    /// For [`Pcg64`].
    pub seed: u64,
    /// r, the steps of U between re-estimations.
    pub every: u64,
}

/// The energy on one mesh, as one of U and mu: the mesh itself, or a coarser one with the model restricted to it.
pub struct Level<'a, D, const M: usize> {
    pub mesh: &'a Mesh,
    pub model: &'a D,
    /// s -> M s, with the mass matrix M.
    pub integrate: &'a dyn Fn(&[Row<M>]) -> Vec<Row<M>>,
    pub scale: Scale,
    pub alternation: &'a Alternation,
    /// Its `stop` is that of the whole, not of one level.
    pub request: &'a Request,
    /// Whether regions with the same parameters become one: not on a coarse mesh, since a finer one may part them.
    pub unite: bool,
}

/// What the alternation ends with.
pub struct Found<P, const M: usize> {
    pub problem: Problem<Stencil, M>,
    pub solver: Box<dyn Solver<Stencil, M>>,
    pub run: Run<M>,
    pub status: Status,
    pub mu: Vec<P>,
    pub estimates: usize,
    pub settled: bool,
    /// Which regions have not become one with another.
    pub open: Vec<bool>,
}

impl<D: DataModel, const M: usize> Level<'_, D, M> {
    /// f for given parameters, of which regions that are not open take nothing.
    pub fn costs(&self, mu: &[D::Parameters], open: &[bool]) -> Vec<Row<M>> {
        let f = (self.integrate)(&self.model.costs(mu));
        let open: [bool; M] = std::array::from_fn(|p| p < open.len() && open[p]);
        let row = |f: &Row<M>| Row::from_fn(|p| if open[p] { f.0[p] } else { FORBIDDEN });
        collect(f.len(), |v| row(&f[v]))
    }

    pub fn problem(&self, mu: &[D::Parameters]) -> Result<Problem<Stencil, M>> {
        let f = self.costs(mu, &vec![true; mu.len()]);
        let problem = Problem::new(Stencil::new(self.mesh), f, self.request.lambda);
        check_range(&problem)?;
        Ok(problem)
    }

    /// Re-estimates until the parameters settle, then solves for the last ones. Starts at `mu`, for which the problem
    /// is, and at U and q, if they are known; `spent` has gone by before.
    pub fn alternate(
        &self,
        mut problem: Problem<Stencil, M>,
        mut mu: Vec<D::Parameters>,
        pair: Option<Pair<M>>,
        spent: Duration,
        stop: &Stop,
        observe: Observer<'_>,
    ) -> Result<Found<D::Parameters, M>> {
        let Level { mesh, alternation, request, .. } = *self;
        let (start, dual_start) = match pair {
            Some(Pair { u, q }) => (u, Some(q)),
            None => (cheapest(&problem.f), None),
        };
        let mut run = Run::new(&start);
        run.charge(spent);
        if request.keep_dual {
            run.keep_dual();
        }
        let setup = Setup { mesh, problem: &problem, start, dual_start };
        let mut solver = request.method.build(setup)?;

        let begin = Instant::now();
        // What is left of the iterations and of the time.
        let rest = |used: u64| Stop {
            iterations: stop.iterations.map(|n| n.saturating_sub(used)),
            ..stop.after(begin.elapsed())
        };
        let mut estimates = 0;
        let mut settled = false;
        let mut unions = Unions::new(alternation.regions, self.scale.distance);
        let status = loop {
            let stop = rest(run.iterations());
            if settled || stop.iterations.is_some_and(|left| left <= alternation.every) {
                break run.advance(&mut *solver, &problem, &stop, observe);
            }
            let few =
                Stop { iterations: Some(alternation.every), time: stop.time, ..Stop::default() };
            match run.advance(&mut *solver, &problem, &few, observe) {
                Status::IterationLimit => {}
                end => break end,
            }
            let weights = (self.integrate)(solver.labels());
            let change = self.model.fit(&weights, &mut mu)?;
            estimates += 1;
            settled = change <= SETTLED * self.scale.change || estimates == MOST_ESTIMATES;
            let distance = |a: usize, b: usize| D::distance(&mu[a], &mu[b]);
            let pairs = match self.unite {
                true => unions.unite(distance, &weights, settled),
                false => Vec::new(),
            };
            problem.set_costs(self.costs(&mu, &unions.open));
            if pairs.is_empty() {
                solver.restart(&problem);
            } else {
                settled = estimates == MOST_ESTIMATES;
                let Iterate { u, q } = solver.iterate();
                let start = u.iter().map(|&u| pairs.iter().fold(u, |u, &pair| united(u, pair)));
                let closed =
                    |row: &Row<M>| pairs.iter().fold(*row, |row, pair| without(row, pair[1]));
                let dual_start = q.iter().map(|q| Tangent([closed(&q.0[0]), closed(&q.0[1])]));
                let setup = Setup {
                    mesh,
                    problem: &problem,
                    start: start.collect(),
                    dual_start: Some(dual_start.collect()),
                };
                solver = request.method.build(setup)?;
            }
            run.forget();
        };
        Ok(Found { problem, solver, run, status, mu, estimates, settled, open: unions.open })
    }
}
