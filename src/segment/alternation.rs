//! The alternation on one mesh: r steps of U for given parameters, then the parameters for the U found.
//!
//! ```text
//! U  <- r steps of a solver for   min_U   sum_k <u_k, f_k(mu)> + lambda TV(U)
//! mu <- argmin_mu sum_k <u_k, f_k(mu)>
//! ```
//!
//! Delaunoy et al., ICCV 2009, section 3.2, with r = 10.

use std::time::{Duration, Instant};

use super::estimate::Estimate;
use super::merging::{Merger, merged, zeroed};
use crate::coarse::Pair;
use crate::data::{Initial, Scale, Weights, cost_row};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::{Quadrature, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::run::{Run, Status, Stop};
use crate::seeds::Seeds;
use crate::solve::{Observer, Request, check_range};
use crate::solver::{Iterate, Setup, Solver};
use crate::start::{cheapest_labels, remove_forbidden};
use crate::sweep::collect;

/// Maximum number of re-estimations; after them the parameters count as settled.
pub const MAX_ESTIMATES: usize = 200;

/// Parameters have settled when none changes by more than this fraction of the scale of changes.
pub const SETTLED_CHANGE: f64 = 1e-4;

/// Settled parameters are re-estimated further if those of the solved labels differ by more than this fraction of the scale:
/// in a few steps U may hardly change although it is far from the solution.
pub const UNSETTLED_CHANGE: f64 = 1e-3;

/// The settings of the alternation, in addition to the [`Request`] to the solver.
#[derive(Clone, Debug)]
pub struct Alternation {
    /// m, from 2 to 64.
    pub regions: usize,
    /// How the region parameters are initialized.
    pub initial: Initial,
    /// The seed of `Pcg64`, which draws random initial parameters.
    pub seed: u64,
    /// r, the steps of U between re-estimations; at least 1.
    pub every: u64,
    /// Initial labels of the V vertices instead, each below m: U starts there, and the parameters are fitted to them.
    pub labels: Option<Vec<usize>>,
    /// The vertices of the V whose labels are given.
    pub seeds: Seeds,
}

/// The joint problem in U and mu on one mesh: the given one or a coarser one.
pub struct JointProblem<'a> {
    pub mesh: &'a Mesh,
    /// The mass matrix of f = M s.
    pub mass: &'a Quadrature<'a>,
    pub scale: Scale,
    /// Those on this mesh.
    pub seeds: &'a Seeds,
    pub alternation: &'a Alternation,
    /// Its `stop` is that of the whole segmentation, not of one mesh.
    pub request: &'a Request,
    /// Whether this is the given mesh. On a coarse one, regions with the same parameters are not merged, since a finer mesh may
    /// separate them, and settled parameters are not verified.
    pub is_finest: bool,
}

/// The final state of the alternation.
pub struct AlternationOutcome<const M: usize> {
    pub problem: Problem<Stencil, M>,
    pub solver: Box<dyn Solver<Stencil, M>>,
    pub run: Run<M>,
    pub status: Status,
    pub estimates: usize,
    pub settled: bool,
    /// Which regions have not been merged into another.
    pub active: Vec<bool>,
}

impl JointProblem<'_> {
    /// f for the current parameters; inactive regions are forbidden, and at seeds all others.
    pub fn costs<const M: usize>(
        &self,
        estimate: &dyn Estimate,
        active: &[bool],
    ) -> Result<Vec<Row<M>>> {
        let (is_known, cost) = (|k| estimate.is_known(k), estimate.cost());
        let active: [bool; M] = std::array::from_fn(|p| p < active.len() && active[p]);
        let row = |f: Row<M>| Row::from_fn(|p| if active[p] { f.0[p] } else { FORBIDDEN_COST });
        let m = estimate.regions();
        let mut f = match self.mass {
            Quadrature::Lumped(area) => {
                collect(area.len(), |k| row(cost_row(k, m, is_known, &*cost) * area[k]))
            }
            mass => {
                let f = mass.integrate(&estimate.costs());
                collect(f.len(), |k| row(f[k]))
            }
        };
        self.seeds.constrain(&mut f)?;
        Ok(f)
    }

    /// The convex problem in U for the current parameters.
    pub fn problem<const M: usize>(&self, estimate: &dyn Estimate) -> Result<Problem<Stencil, M>> {
        let f = self.costs(estimate, &vec![true; estimate.regions()])?;
        let problem = Problem::new(Stencil::new(self.mesh), f, self.request.lambda)
            .in_relaxation(self.request.relaxation);
        check_range(&problem)?;
        Ok(problem)
    }

    /// Re-estimates until the parameters settle, then solves for the last ones. Starts with the current parameters,
    /// whose costs `problem` has, and with U and q, if they are given; `spent` time has passed before.
    pub fn alternate<const M: usize>(
        &self,
        estimate: &mut dyn Estimate,
        mut problem: Problem<Stencil, M>,
        pair: Option<Pair<M>>,
        spent: Duration,
        stop: &Stop,
        observe: Observer<'_>,
    ) -> Result<AlternationOutcome<M>> {
        let JointProblem { mesh, alternation, request, .. } = *self;
        let (start, dual_start) = match pair {
            Some(Pair { mut u, q }) => {
                if !self.seeds.is_empty() {
                    remove_forbidden(&mut u, &problem.f);
                }
                (u, Some(q))
            }
            None => (cheapest_labels(&problem.f), None),
        };
        let mut run = Run::new(&start);
        run.charge(spent);
        if request.needs_dual() {
            run.keep_dual();
        }
        let setup = Setup { domain: mesh.into(), problem: &problem, start, dual_start };
        let method = request.method.for_estimates();
        let mut solver = method.build(setup)?;

        let begin = Instant::now();
        // The iterations and the time that are left.
        let remaining = |used: u64| Stop {
            iterations: stop.iterations.map(|n| n.saturating_sub(used)),
            ..stop.after(begin.elapsed())
        };
        // Whether they do not suffice for another estimate.
        let few = |left: &Stop| left.iterations.is_some_and(|left| left <= alternation.every);
        let mut estimates = 0;
        let mut settled = false;
        let seeded = self.seeds.seeded(alternation.regions);
        let mut merger = Merger::new(seeded, self.scale.distance);
        let status = loop {
            let stop = remaining(run.iterations());
            if settled || few(&stop) {
                let end = run.advance(&mut *solver, &problem, &stop, observe);
                let solved = matches!(end, Status::Converged | Status::Stalled | Status::Settled);
                let limited = matches!(end, Status::IterationLimit | Status::TimeLimit);
                if !(self.is_finest && (solved || limited)) {
                    break end;
                }
                let weights = self.mass.integrate(solver.labels());
                let change = estimate.change(Weights::of(&weights))?;
                settled &= change <= UNSETTLED_CHANGE * self.scale.change;
                let last = limited || few(&remaining(run.iterations()));
                if settled || last || estimates >= MAX_ESTIMATES {
                    break end;
                }
            } else {
                // The bound of a round is void after it: it is sampled once, for the trace.
                let one_round = Stop {
                    iterations: Some(alternation.every),
                    interval: Some(alternation.every),
                    time: stop.time,
                    ..Stop::default()
                };
                match run.advance(&mut *solver, &problem, &one_round, observe) {
                    Status::IterationLimit | Status::Settled => {}
                    end => break end,
                }
            }
            let weights = self.mass.integrate(solver.labels());
            let change = estimate.fit(Weights::of(&weights))?;
            estimates += 1;
            settled = change <= SETTLED_CHANGE * self.scale.change || estimates == MAX_ESTIMATES;
            let distance = |a: usize, b: usize| estimate.distance(a, b);
            let pairs = match self.is_finest {
                true => merger.merge(distance, &weights, settled),
                false => Vec::new(),
            };
            problem.set_costs(self.costs(estimate, &merger.active)?);
            if pairs.is_empty() {
                solver.follow(&problem);
            } else {
                settled = estimates == MAX_ESTIMATES;
                let Iterate { u, q } = solver.iterate();
                let start = u.iter().map(|&u| pairs.iter().fold(u, |u, &pair| merged(u, pair)));
                let emptied =
                    |row: &Row<M>| pairs.iter().fold(*row, |row, pair| zeroed(row, pair[1]));
                let dual_start = q.iter().map(|q| Tangent([emptied(&q.0[0]), emptied(&q.0[1])]));
                let setup = Setup {
                    domain: mesh.into(),
                    problem: &problem,
                    start: start.collect(),
                    dual_start: Some(dual_start.collect()),
                };
                solver = method.build(setup)?;
            }
            run.forget();
        };
        Ok(AlternationOutcome {
            problem,
            solver,
            run,
            status,
            estimates,
            settled,
            active: merger.active,
        })
    }
}
