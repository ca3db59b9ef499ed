//! Coarse to fine: the same model on a hierarchy of coarser meshes. The solution on each level initializes the next
//! finer one.
//!
//! `transfer.rs` restricts the costs and prolongs U and q. Each mesh has its own gradient K; lambda is the same on all
//! of them. Only the solve on the finest mesh certifies. Nested iteration: W. L. Briggs, V. E. Henson, S. F. McCormick,
//! *A Multigrid Tutorial*, 2000, chapter 3.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::coarsen::Coarsening;
use crate::operator::Stencil;
use crate::problem::{Problem, relative_gap};
use crate::relaxation::Relaxation;
use crate::request::{Observer, Request};
use crate::run::{Run, Status, Stop};
use crate::solver::{Iterate, Method, Setup};
use crate::start::{cheapest_labels, remove_forbidden};
use crate::sweep;
use crate::transfer::{prolong, prolong_dual, restrict};

/// Meshes of at most this many vertices are not coarsened: solving them costs next to nothing.
const COARSEST_VERTICES: usize = 1000;

/// A level that keeps a larger fraction of the vertices does not pay off.
const MAX_KEPT_SHARE: f64 = 0.7;

/// Coarse meshes from the finest to the coarsest, each a coarsening of the previous one.
pub(crate) struct Hierarchy<'a> {
    finest: &'a Mesh,
    pub(crate) levels: Vec<Coarsening>,
}

/// The initial pair of the finest solve, and the work it took.
pub(crate) struct CoarseStart<const M: usize> {
    /// `None` if there is no hierarchy or a coarse solve diverges.
    pub(crate) pair: Option<Pair<M>>,
    pub(crate) record: Record,
}

/// The coarse levels, as reported in `summary.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Wall time of everything before the finest solve: meshes, problems, steps and samples.
    #[serde(rename = "seconds", serialize_with = "as_seconds", deserialize_with = "from_seconds")]
    pub spent: Duration,
    /// From the coarsest to the finest, the order in which they are solved.
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

/// The size of one coarse mesh and the number of steps on it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct LevelRecord {
    /// V of the coarse mesh.
    pub vertices: usize,
    /// F of the coarse mesh.
    pub faces: usize,
    /// Steps of the solver on it.
    pub iterations: u64,
}

impl LevelRecord {
    pub(crate) fn of(mesh: &Mesh, iterations: u64) -> Self {
        LevelRecord { vertices: mesh.vertices.len(), faces: mesh.faces.len(), iterations }
    }
}

/// U and its dual field.
pub(crate) struct Pair<const M: usize> {
    pub(crate) u: Vec<Row<M>>,
    pub(crate) q: Vec<Tangent<M>>,
}

impl<'a> Hierarchy<'a> {
    /// Without levels if the mesh is small or cannot be coarsened.
    pub(crate) fn new(finest: &'a Mesh) -> Self {
        Hierarchy::down_to(finest, COARSEST_VERTICES)
    }

    /// The same, ending with the first level of at most `vertices` vertices.
    pub(crate) fn down_to(finest: &'a Mesh, vertices: usize) -> Self {
        let mut levels: Vec<Coarsening> = Vec::new();
        loop {
            let fine = levels.last().map_or(finest, |level| &level.mesh);
            let max_vertices = (MAX_KEPT_SHARE * fine.vertices.len() as f64) as usize;
            if fine.vertices.len() <= vertices {
                break;
            }
            let coarsening = fine.coarsened();
            if coarsening.mesh.vertices.len() > max_vertices || coarsening.mesh.faces.is_empty() {
                break;
            }
            levels.push(coarsening);
        }
        Hierarchy { finest, levels }
    }

    /// Calls `solve` with the index of each level, the coarsest first, and the prolonged result of the previous level.
    /// Returns the last result, prolonged to the finest mesh; `None` if there are no levels or `solve` returns `None`.
    pub(crate) fn climb<const M: usize>(
        &self,
        (lambda, relaxation): (f64, Relaxation),
        mut solve: impl FnMut(usize, Option<Pair<M>>) -> Result<Option<Pair<M>>>,
    ) -> Result<Option<Pair<M>>> {
        let mut pair = None;
        for (l, level) in self.levels.iter().enumerate().rev() {
            let Some(Pair { u, q }) = solve(l, pair)? else { return Ok(None) };
            let fine = if l == 0 { self.finest } else { &self.levels[l - 1].mesh };
            pair = Some(Pair {
                u: prolong(&level.parents, &u),
                q: prolong_dual(level, fine, &q, (lambda, relaxation)),
            });
        }
        Ok(pair)
    }
}

/// A level is solved to 10 times the requested gap, clamped to this interval: neither beyond its discretization error
/// nor to the last requested digit.
const LEVEL_GAPS: [f64; 2] = [2.5e-4, 5e-3];

/// Maximum number of steps on a level; with a quarter of the vertices, a step costs a quarter.
const MAX_LEVEL_STEPS: u64 = 500;

/// When a coarse level ends that begins after `spent` time.
pub(crate) fn level_stop(request: &Request, spent: Duration) -> Stop {
    let gap = 10.0 * request.stop.relative_gap.unwrap_or(0.0);
    Stop {
        relative_gap: Some(gap.clamp(LEVEL_GAPS[0], LEVEL_GAPS[1])),
        iterations: Some(MAX_LEVEL_STEPS),
        time: request.stop.after(spent).time,
        ..Stop::default()
    }
}

/// Whether the cheapest region at every vertex, with q = 0, already reaches the requested gap. Prolonged labels could
/// then only be worse: by rounding, where all costs are zero.
pub(crate) fn is_certified<const M: usize>(
    problem: &Problem<Stencil, M>,
    request: &Request,
) -> bool {
    let energy = problem.energy(&cheapest_labels(&problem.f));
    let gap = relative_gap(energy, 0.0);
    request.stop.relative_gap.is_some_and(|tolerance| gap <= tolerance)
}

/// Solves each level with the requested solver.
pub(crate) fn start<const M: usize>(
    finest: &Mesh,
    problem: &Problem<Stencil, M>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<CoarseStart<M>> {
    let begin = Instant::now();
    let hierarchy = Hierarchy::new(finest);
    let mut costs: Vec<Vec<Row<M>>> = Vec::new();
    for level in &hierarchy.levels {
        costs.push(restrict(level, costs.last().unwrap_or(&problem.f)));
    }
    let mut levels = Vec::new();
    let weight = (request.lambda, request.relaxation);
    let pair = hierarchy.climb(weight, |l, pair| {
        let mesh = &hierarchy.levels[l].mesh;
        let f = std::mem::take(&mut costs[l]);
        let problem =
            Problem::new(Stencil::new(mesh), f, request.lambda).in_relaxation(request.relaxation);
        let (start, dual_start) = match pair {
            Some(Pair { mut u, q }) => {
                remove_forbidden(&mut u, &problem.f);
                (u, Some(q))
            }
            None => (cheapest_labels(&problem.f), None),
        };
        let mut run = Run::new(&start);
        let setup = Setup { domain: mesh.into(), problem: &problem, start, dual_start };
        let mut solver = request.method.build(setup)?;
        let stop = level_stop(request, begin.elapsed());
        let status = run.advance(&mut *solver, &problem, &stop, &mut |_| observe(None));
        levels.push(LevelRecord::of(mesh, run.iterations()));
        Ok(final_pair(solver.iterate(), status))
    })?;
    let pair = pair.map(|Pair { mut u, q }| {
        remove_forbidden(&mut u, &problem.f);
        Pair { u, q }
    });
    let record = Record { spent: begin.elapsed(), levels };
    Ok(CoarseStart { pair, record })
}

/// Maximum number of vertices of the mesh on which [`separating_lambda`] tries lambdas.
const MAX_TRIAL_VERTICES: usize = 4000;

/// Maximum number of lambdas that are tried.
const MAX_TRIALS: i32 = 14;

/// The first of lambda / 2, lambda / 4, ... for which all `wanted` regions are used on a coarse mesh; `None` if there
/// is none among those tried.
pub(crate) fn separating_lambda<const M: usize>(
    finest: &Mesh,
    problem: &Problem<Stencil, M>,
    wanted: &[usize],
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<f64>> {
    let hierarchy = Hierarchy::down_to(finest, MAX_TRIAL_VERTICES);
    let mut f = sweep::copy(&problem.f);
    for level in &hierarchy.levels {
        f = restrict(level, &f);
    }
    let mesh = hierarchy.levels.last().map_or(finest, |level| &level.mesh);
    let mut coarse =
        Problem::new(Stencil::new(mesh), f, problem.lambda).in_relaxation(problem.relaxation);
    for i in 1..=MAX_TRIALS {
        coarse.lambda = problem.lambda * 0.5_f64.powi(i);
        let start = cheapest_labels(&coarse.f);
        let mut run = Run::new(&start);
        let setup = Setup { domain: mesh.into(), problem: &coarse, start, dual_start: None };
        let mut solver = Method::default().build(setup)?;
        // To the requested gap: where cuts are expensive, even a small gap leaves room for regions that vanish in the
        // end.
        let gap = request.stop.relative_gap.unwrap_or(0.0).clamp(LEVEL_GAPS[0], LEVEL_GAPS[1]);
        let stop = Stop {
            relative_gap: Some(gap),
            iterations: Some(MAX_LEVEL_STEPS),
            ..request.stop.clone()
        };
        let status = run.advance(&mut *solver, &coarse, &stop, &mut |_| observe(None));
        if status == Status::Interrupted {
            return Ok(None);
        }
        // Before convergence a region may still own vertices that it loses in the end.
        let u = run.best_u();
        if status == Status::Converged && wanted.iter().all(|&p| u.iter().any(|u| u.argmax() == p))
        {
            return Ok(Some(coarse.lambda));
        }
    }
    Ok(None)
}

/// The final pair of a level, unless it diverged.
pub(crate) fn final_pair<const M: usize>(
    iterate: Iterate<'_, M>,
    status: Status,
) -> Option<Pair<M>> {
    (status != Status::Diverged).then(|| Pair { u: iterate.u.to_vec(), q: iterate.q.to_vec() })
}

#[cfg(test)]
mod tests;
