//! One convex problem from mesh and costs to certified labels.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Duration;

use ndarray::{Array1, Array2};
use serde::Serialize;

use crate::coarse::{self, Pair, Record};
use crate::costs;
use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::mesh::order::Order;
use crate::mesh::{Mesh, Weld};
use crate::operator::{Mass, Operator, Quadrature, Stencil};
use crate::problem::{NEVER, Problem, label_gap, relative_gap, rounded};
use crate::regions::{self, with_regions};
use crate::remarks::{empty_regions, named};
use crate::run::{Run, Sample, Status, Stop};
use crate::solver::{self, Options, Setup};
use crate::start::Start;
use crate::sweep;
use crate::unreached::unreached;

/// What is asked of a solver, apart from the problem itself.
#[derive(Clone, Debug)]
pub struct Request {
    /// Weight of the total variation, in units of cost times length.
    pub lambda: f64,
    pub mass: Mass,
    /// One of the names in [`solver::DESCRIPTIONS`].
    pub solver: String,
    pub options: Options,
    pub stop: Stop,
    /// Start from the solution on a coarser mesh, that one from a coarser one still; see `coarse.rs`.
    pub coarse_to_fine: bool,
    /// Keep the dual field of the best bound, [`Solution::q`].
    pub keep_dual: bool,
}

impl Request {
    /// Refuses what no solver could work with.
    pub fn check(&self) -> Result<()> {
        check_lambda(self.lambda)?;
        self.options.check(solver::describe(&self.solver)?)
    }
}

pub(crate) fn check_lambda(lambda: f64) -> Result<()> {
    if lambda >= 0.0 && lambda.is_finite() {
        Ok(())
    } else {
        Err(Error::unsuitable(format!("lambda = {lambda:?}: must be a finite number from 0")))
    }
}

pub(crate) fn check_finite(what: &str, array: &Array2<f64>) -> Result<()> {
    if let Some(numbers) = array.as_slice()
        && sweep::all(
            numbers.len(),
            #[inline(always)]
            |i| numbers[i].is_finite(),
        )
    {
        return Ok(());
    }
    match array.indexed_iter().find(|(_, x)| !x.is_finite()) {
        None => Ok(()),
        Some(((k, p), x)) => Err(Error::unsuitable(format!(
            "the {what} have {x} in row {k}, column {p}; every entry must be a finite number"
        ))),
    }
}

/// Refuses an array whose rows are not the vertices of the mesh.
pub(crate) fn check_rows(what: &str, rows: usize, mesh: &Mesh) -> Result<()> {
    let vertices = mesh.vertices.len();
    if rows == vertices {
        Ok(())
    } else {
        Err(Error::unsuitable(format!(
            "the {what} have {rows} rows, the mesh has {vertices} vertices; one row per vertex is needed"
        )))
    }
}

/// Called after every step, with a sample where one was taken; may break the run off.
pub type Observer<'a> = &'a mut dyn FnMut(Option<&Sample>) -> ControlFlow<()>;

/// The numbers of a result, as `summary.json` has them.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub solver: String,
    pub solver_options: BTreeMap<String, String>,
    pub status: Status,
    pub status_sentence: &'static str,
    pub iterations: u64,
    /// Time spent in the solver's steps, and in all that `coarse_to_fine` counts.
    pub seconds: f64,
    /// E of `u`.
    pub energy: f64,
    /// D: no U has less energy than this.
    pub dual_bound: f64,
    /// B = sum_k min_p f_kp, from which all relative gaps are measured; see `problem.rs`.
    pub baseline: f64,
    /// E - D.
    pub gap: f64,
    /// (E - D) / (E - B).
    pub relative_gap: f64,
    /// R, the energy of the one-hot rows of `labels`.
    pub rounded_energy: f64,
    /// (R - D) / (D - B): the labels are at most this share above any labeling, measured from B as well. Infinite
    /// (null in JSON) where D = B, which bounds no such share.
    pub rounded_relative_gap: f64,
    pub vertices: usize,
    pub faces: usize,
    pub regions: usize,
    /// Those that no vertex has.
    pub empty_regions: Vec<usize>,
    pub lambda: f64,
    pub mass: &'static str,
    /// Of the mesh that the energy is measured on.
    pub area: f64,
    /// The levels below the finest, whose solution started it.
    pub coarse_to_fine: Option<Record>,
    pub warnings: Vec<String>,
}

/// What a run ends with.
pub struct Solution {
    pub summary: Summary,
    pub trace: Vec<Sample>,
    /// V x m, rows in the simplex.
    pub u: Array2<f64>,
    /// argmax over the regions, V numbers.
    pub labels: Array1<i32>,
    /// The field that certifies `dual_bound`, if it was asked for: 2F x m, rows 2j and 2j + 1 those of face j, in the
    /// frame of the rows of K; zero in faces without area.
    pub q: Option<Array2<f64>>,
}

impl Solution {
    /// The same for the mesh as the caller knows it.
    pub(crate) fn of(mut self, mesh: &Mesh, order: &Order) -> Self {
        self.summary.faces = mesh.faces.len();
        self.q = self.q.map(|q| {
            // Which face of the mesh is the next of the model.
            let kept: Vec<usize> =
                (0..mesh.faces.len()).filter(|&j| !mesh.is_degenerate(j)).collect();
            let mut all = Array2::zeros((2 * mesh.faces.len(), q.ncols()));
            for (i, j) in order.faces(kept.len()).into_iter().enumerate() {
                for axis in 0..2 {
                    all.row_mut(2 * kept[j] + axis).assign(&q.row(2 * i + axis));
                }
            }
            all
        });
        match order.places() {
            Some(places) => self.gathered(&places),
            None => self,
        }
    }

    /// The same for a mesh whose coincident vertices were merged: each takes what it was merged onto has.
    pub fn spread(mut self, mesh: &Mesh, weld: &Weld) -> Self {
        self.summary.vertices = mesh.vertices.len();
        self.summary.faces = mesh.faces.len();
        self.gathered(&weld.of)
    }

    /// Rows from these places.
    fn gathered(mut self, places: &[u32]) -> Self {
        let rows = self.u.as_slice().expect("rows are contiguous");
        let m = self.u.ncols();
        let mut moved = Vec::with_capacity(places.len() * m);
        for &v in places {
            moved.extend_from_slice(&rows[v as usize * m..][..m]);
        }
        self.u = Array2::from_shape_vec((places.len(), m), moved).expect("rows of m numbers");
        self.labels = places.iter().map(|&v| self.labels[v as usize]).collect();
        self
    }
}

/// Minimizes E for pointwise costs s (V x m, see [`costs`]) on a mesh as it is: no scaling.
pub fn solve(
    mesh: &Mesh,
    s: &Array2<f64>,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    request.check()?;
    regions::check(s.ncols())?;
    check_rows("costs", s.nrows(), mesh)?;
    start.check(s.dim())?;
    let (known, mut warnings) = costs::checked(s, request.mass)?;
    let (model, left_out) = model_mesh(mesh)?;
    warnings.extend(left_out);
    warnings.extend(unreached(&model, |k| !s[[k, 0]].is_nan()));
    let order = Order::of(&model);
    let model = order.mesh(model);
    let solved = with_regions!(
        s.ncols(),
        solve_compiled(&model, &order, warnings, &known, start, request, observe)
    );
    solved.map(|solution| solution.of(mesh, &order))
}

fn solve_compiled<const M: usize>(
    model: &Mesh,
    order: &Order,
    warnings: Vec<String>,
    s: &Array2<f64>,
    start: &Start,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Solution> {
    let m = s.ncols();
    let s = order.applied(regions::rows(s.view()));
    let problem = problem_of::<M>(model, m, s, request)?;
    let beginning = match request.coarse_to_fine && !coarse::is_certified(&problem, request) {
        true => Some(coarse::start(model, &problem, m, request, observe)?),
        false => None,
    };
    let (pair, record) = beginning.map(|begin| (begin.pair, begin.record)).unzip();
    let (start, dual_start) = match pair.flatten() {
        Some(Pair { u, q }) => (u, Some(q)),
        None => (start.rows(m, &problem.f, order), None),
    };
    let mut run = Run::new(&start);
    if request.keep_dual {
        run.keep_dual();
    }
    let setup =
        Setup { mesh: model, problem: &problem, start, dual_start, options: &request.options };
    let mut solver = solver::build(&request.solver, setup)?;
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    run.charge(spent);
    let stop = request.stop.after(spent);
    let status = run.advance(&mut *solver, &problem, &stop, observe);
    let mut solution = conclude(model, &problem, m, request, run, status, warnings);
    solution.summary.coarse_to_fine = record;
    // Who breaks off does not want to wait for advice.
    if status != Status::Interrupted {
        let done = !matches!(status, Status::IterationLimit | Status::TimeLimit);
        let remark =
            remark(model, &problem, m, &solution.summary.empty_regions, done, request, observe)?;
        solution.summary.warnings.extend(remark);
    }
    Ok(solution)
}

/// What must be said where some regions are empty. A lambda that saves those that are somewhere the cheapest is looked
/// for on a coarse mesh.
fn remark<const M: usize>(
    mesh: &Mesh,
    problem: &Problem<Stencil, M>,
    m: usize,
    empty: &[usize],
    done: bool,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<String>> {
    if empty.is_empty() {
        return Ok(None);
    }
    let cheapest: Array1<i32> = problem.f.iter().map(|f| f.argmin() as i32).collect();
    let hopeless = empty_regions(&cheapest, m);
    let (hopeless, lost): (Vec<usize>, Vec<usize>) =
        empty.iter().partition(|p| hopeless.contains(p));
    let mut sentences = Vec::new();
    if !hopeless.is_empty() {
        sentences.push(format!("{}: nowhere do they cost the least", named(&hopeless)));
    }
    if !lost.is_empty() && !done {
        sentences
            .push(format!("{} so far: the run ended before its gap was reached", named(&lost)));
    } else if !lost.is_empty() {
        let advice = match coarse::separating(mesh, problem, m, &lost, request, observe)? {
            // The coarse mesh may keep a region a little longer than the fine one.
            Some(lambda) => format!("try --lambda {:.1e}", 0.5 * lambda),
            None => "try a much smaller --lambda".into(),
        };
        let few = "lambda is too large for these costs";
        sentences.push(format!("{}: {few}; {advice}", named(&lost)));
    }
    Ok(Some(sentences.join("; ")))
}

/// The faces with an area, and what was left out. What is left out couples its corners no more.
pub fn model_mesh(mesh: &Mesh) -> Result<(Cow<'_, Mesh>, Vec<String>)> {
    // One look at every face, as long as all are fine.
    let mut area = sweep::sum(
        mesh.faces.len(),
        #[inline(always)]
        |j| if mesh.is_degenerate(j) { f64::NAN } else { mesh.face_area(j) },
    );
    let (mut model, mut dropped) = (Cow::Borrowed(mesh), 0);
    if area.is_nan() {
        (model, dropped) = mesh.without_degenerate_faces();
        area = model.area();
    }
    let mut warnings = Vec::new();
    if dropped > 0 {
        warnings.push(format!("{dropped} faces without area were left out"));
    }
    if model.faces.is_empty() {
        return Err(Error::unsuitable("the mesh has no face with an area"));
    }
    if !(area.is_normal() && area.sqrt().is_normal()) {
        return Err(Error::unsuitable(format!(
            "the area of the mesh is {area:e}: scale its coordinates to ordinary numbers"
        )));
    }
    Ok((model, warnings))
}

/// Refuses what [`model_mesh`] refuses, and looks no further than to the first face with an area. No sum overflows:
/// a face has an area only if the square of it is a number.
pub fn check_mesh(mesh: &Mesh) -> Result<()> {
    if (0..mesh.faces.len()).any(|j| !mesh.is_degenerate(j)) {
        return Ok(());
    }
    model_mesh(mesh).map(drop)
}

/// The problem with costs integrated and unused regions closed.
pub(crate) fn problem_of<const M: usize>(
    model: &Mesh,
    m: usize,
    s: Vec<Row<M>>,
    request: &Request,
) -> Result<Problem<Stencil, M>> {
    let (f, k) = sweep::join(|| integrate(&request.mass.on(model), m, &s), || Stencil::new(model));
    let problem = Problem::new(k, f, request.lambda);
    check_range(&problem)?;
    Ok(problem)
}

/// Refuses numbers so large that sums of them overflow or that closed regions would look cheap, and so small that they
/// have lost their digits.
pub(crate) fn check_range<const M: usize>(problem: &Problem<Stencil, M>) -> Result<()> {
    let in_range = |x: f64| x.abs() < 1e-10 * NEVER;
    let costs = sweep::all(
        problem.f.len(),
        #[inline(always)]
        |v| problem.f[v].0.iter().all(|&f| f == NEVER || in_range(f)),
    );
    let length = sweep::sum(
        problem.k.faces(),
        #[inline(always)]
        |j| problem.k.weights()[j].iter().map(|c| c.abs()).sum(),
    );
    let spread = problem.spread();
    if spread > 0.0 && spread < SMALLEST {
        return Err(Error::unsuitable(format!(
            "the costs times the areas differ by {spread:e} in all, too little for double precision: scale them up"
        )));
    }
    if costs && in_range(problem.lambda * length) {
        Ok(())
    } else {
        Err(Error::unsuitable(
            "the costs times the areas, or lambda times the lengths, leave the range of double precision: \
             scale them down",
        ))
    }
}

/// Costs that differ by less are next to the least normal number.
const SMALLEST: f64 = 1e-290;

/// f = M s; what s forbids, f forbids, also where a vertex has no area.
pub(crate) fn integrate<const M: usize>(
    mass: &Quadrature<'_>,
    m: usize,
    s: &[Row<M>],
) -> Vec<Row<M>> {
    let mut f = mass.integrate(s);
    sweep::sweep(
        (&mut f[..], s),
        #[inline(always)]
        |_, (f, s)| {
            *f = Row::from_fn(|p| if p < m && s.0[p] < f64::INFINITY { f.0[p] } else { NEVER });
        },
    );
    f
}

/// Rounds the best U and states what is certain about it.
pub(crate) fn conclude<const M: usize>(
    model: &Mesh,
    problem: &Problem<Stencil, M>,
    m: usize,
    request: &Request,
    run: Run<M>,
    status: Status,
    warnings: Vec<String>,
) -> Solution {
    let u = run.best_u();
    let baseline = problem.baseline;
    let (energy, bound) = (run.energy(), run.bound());
    let rounded_energy = problem.energy(&rounded(u));
    let labels = sweep::collect(u.len(), |v| u[v].argmax() as i32).into();
    // Labels are a U as well.
    let below = problem.settled(rounded_energy, bound) > rounded_energy;
    let status = if below { Status::Contradicted } else { status };
    let summary = Summary {
        solver: request.solver.clone(),
        solver_options: request.options.pairs().clone(),
        status,
        status_sentence: status.sentence(),
        iterations: run.iterations(),
        seconds: run.seconds(),
        energy: baseline + energy,
        dual_bound: baseline + bound,
        baseline,
        gap: energy - bound,
        relative_gap: relative_gap(energy, bound),
        rounded_energy: baseline + rounded_energy,
        rounded_relative_gap: label_gap(rounded_energy, problem.settled(rounded_energy, bound)),
        vertices: problem.k.vertices(),
        faces: problem.k.faces(),
        regions: m,
        empty_regions: empty_regions(&labels, m),
        lambda: problem.lambda,
        mass: request.mass.name(),
        area: model.area(),
        coarse_to_fine: None,
        warnings,
    };
    Solution {
        summary,
        u: regions::array(u, m),
        labels,
        q: run.best_q().map(|q| dual_array(q, problem.k.faces(), m)),
        trace: run.trace,
    }
}

/// 2F x m; no q at all is zero.
fn dual_array<const M: usize>(q: &[Tangent<M>], faces: usize, m: usize) -> Array2<f64> {
    if q.is_empty() {
        return Array2::zeros((2 * faces, m));
    }
    Array2::from_shape_fn((2 * faces, m), |(row, p)| q[row / 2].0[row % 2].0[p])
}

#[cfg(test)]
mod tests;
