//! Coarse to fine: the same model on coarser and coarser meshes, whose solutions start each other.
//!
//! Costs go down and U and q go up as `transfer.rs` says. K, the gradient, is that of each mesh; lambda is the same. Only
//! the finest solve certifies.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::coarsen::Coarsening;
use crate::operator::Stencil;
use crate::problem::{Problem, relative_gap};
use crate::request::{Observer, Request};
use crate::run::{Run, Status, Stop};
use crate::solver::{Iterate, Method, Setup};
use crate::start::{allowed, cheapest};
use crate::sweep::{self, sweep};
use crate::transfer::{prolong, prolong_dual, restrict};

/// Meshes of so few vertices are not coarsened: solving them costs next to nothing.
const COARSEST: usize = 1000;

/// A level that keeps a larger share of the vertices than this does not pay.
const LARGEST_SHARE: f64 = 0.7;

/// Coarse meshes, the finest of them first, each a coarsening of the one before.
pub struct Hierarchy<'a> {
    finest: &'a Mesh,
    pub levels: Vec<Coarsening>,
}

/// Where the finest solve starts, and what that took.
pub struct Beginning<const M: usize> {
    /// Nothing, if there is no hierarchy or a coarse solve diverges.
    pub pair: Option<Pair<M>>,
    pub record: Record,
}

/// What `summary.json` says of the coarse levels.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Wall time of all that happens before the finest solve: meshes, problems, steps and samples.
    #[serde(rename = "seconds", serialize_with = "as_seconds", deserialize_with = "from_seconds")]
    pub spent: Duration,
    /// The coarsest first, in the order of the work.
    pub levels: Vec<LevelRecord>,
}

fn as_seconds<S: serde::Serializer>(
    spent: &Duration,
    to: S,
) -> std::result::Result<S::Ok, S::Error> {
    to.serialize_f64(spent.as_secs_f64())
}

fn from_seconds<'a, D: serde::Deserializer<'a>>(
    from: D,
) -> std::result::Result<Duration, D::Error> {
    Duration::try_from_secs_f64(f64::deserialize(from)?).map_err(serde::de::Error::custom)
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LevelRecord {
    pub vertices: usize,
    pub faces: usize,
    pub iterations: u64,
}

impl LevelRecord {
    pub fn of(mesh: &Mesh, iterations: u64) -> Self {
        LevelRecord { vertices: mesh.vertices.len(), faces: mesh.faces.len(), iterations }
    }
}

/// U and the dual field that belongs to it.
pub struct Pair<const M: usize> {
    pub u: Vec<Row<M>>,
    pub q: Vec<Tangent<M>>,
}

impl<'a> Hierarchy<'a> {
    /// Without levels where the mesh is small, or where nothing can be made coarser.
    pub fn new(finest: &'a Mesh) -> Self {
        Hierarchy::down_to(finest, COARSEST)
    }

    /// The same, ending with the first level of at most so many vertices.
    pub fn down_to(finest: &'a Mesh, vertices: usize) -> Self {
        let mut levels: Vec<Coarsening> = Vec::new();
        loop {
            let fine = levels.last().map_or(finest, |level| &level.mesh);
            let most = (LARGEST_SHARE * fine.vertices.len() as f64) as usize;
            if fine.vertices.len() <= vertices {
                break;
            }
            let coarsening = fine.coarsened();
            if coarsening.mesh.vertices.len() > most || coarsening.mesh.faces.is_empty() {
                break;
            }
            levels.push(coarsening);
        }
        Hierarchy { finest, levels }
    }

    /// Calls `solve` with the number of each level, the coarsest first, and what the one before it led to;
    /// returns what the last leads to on the finest mesh. Nothing, if there are no levels or `solve` gives up.
    pub fn climb<const M: usize>(
        &self,
        lambda: f64,
        mut solve: impl FnMut(usize, Option<Pair<M>>) -> Result<Option<Pair<M>>>,
    ) -> Result<Option<Pair<M>>> {
        let mut pair = None;
        for (l, level) in self.levels.iter().enumerate().rev() {
            let Some(Pair { u, q }) = solve(l, pair)? else { return Ok(None) };
            let fine = if l == 0 { self.finest } else { &self.levels[l - 1].mesh };
            pair = Some(Pair {
                u: prolong(&level.parents, &u),
                q: prolong_dual(level, fine, &q, lambda),
            });
        }
        Ok(pair)
    }
}

/// A level is not solved beyond what its own coarseness is worth, nor the last digit that is asked for:
/// 10 times the gap, but between these.
const GAPS: [f64; 2] = [2.5e-4, 5e-3];

/// Steps on a level at the most; on a quarter of the vertices they cost a quarter.
const MOST_STEPS: u64 = 500;

/// When a coarse level is done, which begins after all that took `spent`.
pub fn stop(request: &Request, spent: Duration) -> Stop {
    let gap = 10.0 * request.stop.relative_gap.unwrap_or(0.0);
    Stop {
        relative_gap: Some(gap.clamp(GAPS[0], GAPS[1])),
        iterations: Some(MOST_STEPS),
        time: request.stop.after(spent).time,
        ..Stop::default()
    }
}

/// Whether the cheapest region everywhere, with q = 0, is already as good as what is asked for. What comes up
/// from coarse levels could then only be worse: where all costs are zero, by rounding.
pub fn is_certified<const M: usize>(problem: &Problem<Stencil, M>, request: &Request) -> bool {
    let energy = problem.energy(&cheapest(&problem.f));
    let gap = relative_gap(energy, 0.0);
    request.stop.relative_gap.is_some_and(|tolerance| gap <= tolerance)
}

/// Solves each level, with the solver that is asked for.
pub fn start<const M: usize>(
    finest: &Mesh,
    problem: &Problem<Stencil, M>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Beginning<M>> {
    let begin = Instant::now();
    let hierarchy = Hierarchy::new(finest);
    let mut costs: Vec<Vec<Row<M>>> = Vec::new();
    for level in &hierarchy.levels {
        costs.push(restrict(level, costs.last().unwrap_or(&problem.f)));
    }
    let mut levels = Vec::new();
    let pair = hierarchy.climb(request.lambda, |l, pair| {
        let mesh = &hierarchy.levels[l].mesh;
        let f = std::mem::take(&mut costs[l]);
        let problem = Problem::new(Stencil::new(mesh), f, request.lambda);
        let (start, dual_start) = match pair {
            Some(Pair { mut u, q }) => {
                without_forbidden(&mut u, &problem.f);
                (u, Some(q))
            }
            None => (cheapest(&problem.f), None),
        };
        let mut run = Run::new(&start);
        let setup = Setup { mesh, problem: &problem, start, dual_start };
        let mut solver = request.method.build(setup)?;
        let stop = stop(request, begin.elapsed());
        let status = run.advance(&mut *solver, &problem, &stop, &mut |_| observe(None));
        levels.push(LevelRecord::of(mesh, run.iterations()));
        Ok(reached(solver.iterate(), status))
    })?;
    let pair = pair.map(|Pair { mut u, q }| {
        without_forbidden(&mut u, &problem.f);
        Pair { u, q }
    });
    let record = Record { spent: begin.elapsed(), levels };
    Ok(Beginning { pair, record })
}

/// P u may give to labels that a finer vertex forbids.
fn without_forbidden<const M: usize>(u: &mut [Row<M>], f: &[Row<M>]) {
    sweep((u, f), |_, (u, f)| *u = allowed(*u, f));
}

/// Of the mesh on which [`separating`] looks.
const MOST_VERTICES: usize = 4000;

/// Lambdas that are tried at the most.
const TRIED: i32 = 14;

/// The first of lambda / 2, lambda / 4, ... for which regions that should be used are, on a coarse mesh; none if all of
/// them fail.
pub fn separating<const M: usize>(
    finest: &Mesh,
    problem: &Problem<Stencil, M>,
    wanted: &[usize],
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<f64>> {
    let hierarchy = Hierarchy::down_to(finest, MOST_VERTICES);
    let mut f = sweep::copy(&problem.f);
    for level in &hierarchy.levels {
        f = restrict(level, &f);
    }
    let mesh = hierarchy.levels.last().map_or(finest, |level| &level.mesh);
    let mut coarse = Problem::new(Stencil::new(mesh), f, problem.lambda);
    for i in 1..=TRIED {
        coarse.lambda = problem.lambda * 0.5_f64.powi(i);
        let start = cheapest(&coarse.f);
        let mut run = Run::new(&start);
        let setup = Setup { mesh, problem: &coarse, start, dual_start: None };
        let mut solver = Method::default().build(setup)?;
        // As exact as was asked: where cuts are dear, a small gap leaves room for regions that go in the end.
        let gap = request.stop.relative_gap.unwrap_or(0.0).clamp(GAPS[0], GAPS[1]);
        let stop =
            Stop { relative_gap: Some(gap), iterations: Some(MOST_STEPS), ..request.stop.clone() };
        let status = run.advance(&mut *solver, &coarse, &stop, &mut |_| observe(None));
        if status == Status::Interrupted {
            return Ok(None);
        }
        // On the way a region may still have what it loses in the end.
        let u = run.best_u();
        if status == Status::Converged && wanted.iter().all(|&p| u.iter().any(|u| u.argmax() == p))
        {
            return Ok(Some(coarse.lambda));
        }
    }
    Ok(None)
}

/// What a level ends with, if that is made of numbers.
pub fn reached<const M: usize>(iterate: Iterate<'_, M>, status: Status) -> Option<Pair<M>> {
    (status != Status::Diverged).then(|| Pair { u: iterate.u.to_vec(), q: iterate.q.to_vec() })
}

#[cfg(test)]
mod tests;
