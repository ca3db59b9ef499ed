//! The energies and the certificate of a given U, whatever computed it.

use std::borrow::Cow;

use ndarray::{Array2, Axis};
use serde::Serialize;

use crate::certificate;
use crate::costs;
use crate::domain::Domain;
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::mesh::order::Order;
use crate::names::Named;
use crate::operator::{Mass, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem, Smoothing, label_gap, relative_gap, rounded};
use crate::regions::{self, with_regions};
use crate::relaxation::Relaxation;
use crate::run::Certificate;
use crate::solve::{Observer, check_range, dual_of, integrate, model_mesh};
use crate::start::Start;
use crate::units::Unit;

/// Entries that are farther outside the simplex are not rounding errors.
const LARGEST_ROUNDING: f64 = 1e-9;

/// The scores of U on one problem, as `meshseg evaluate` prints them.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// V.
    pub vertices: usize,
    /// F, faces without area included.
    pub faces: usize,
    /// m.
    pub regions: usize,
    /// Weight of the total variation, in units of cost times length.
    pub lambda: f64,
    /// The relaxation: `frobenius`, `separate`, `envelope` or `metric`.
    pub relaxation: &'static str,
    /// The quadrature of the data term: `barycentric`, `voronoi` or `consistent`.
    pub mass: &'static str,
    /// Sum of A_j over the faces with an area, in squared units of the mesh.
    pub area: f64,
    /// E(U) = data_term + lambda * total_variation.
    pub energy: f64,
    /// sum_k <u_k, f_k>.
    pub data_term: f64,
    /// sum_j |(K U)_j|, in the norm of the relaxation, in units of length.
    pub total_variation: f64,
    /// E_eps(U), if an eps was given.
    pub smoothed_energy: Option<f64>,
    /// D: no labels have a smaller energy.
    pub dual_bound: f64,
    /// The origin of the bound.
    pub certificate: Certificate,
    /// B, see `problem.rs`: relative gaps are measured from here.
    pub baseline: f64,
    /// E - D; `None` if U is infeasible, since its energy is then no upper bound.
    pub gap: Option<f64>,
    /// (E - D) / (E - B).
    pub relative_gap: Option<f64>,
    /// R, the energy of the one-hot rows of argmax_p u_kp.
    pub rounded_energy: f64,
    /// (R - D) / (D - B), see [`crate::solve::Summary`].
    pub rounded_relative_gap: f64,
    /// eps of E_eps, if it was given.
    pub epsilon: Option<f64>,
    /// The mode of that smoothing: `paper` or `intrinsic`.
    pub epsilon_mode: Option<&'static str>,
    /// Whether every row of U is in the simplex to 1e-9; if not, there is no gap.
    pub feasible: bool,
    /// max_k |sum_p u_kp - 1|.
    pub largest_row_sum_error: f64,
    /// min_kp u_kp, below 0 where U leaves the simplex.
    pub smallest_entry: f64,
    /// Warnings for the user, a sentence each: unknown vertices, forbidden labels, faces left out.
    pub warnings: Vec<String>,
}

/// The request, in addition to mesh, costs and U.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Weight of the total variation, in units of cost times length; not negative.
    pub lambda: f64,
    /// The relaxation.
    pub relaxation: Relaxation,
    /// The quadrature of the data term.
    pub mass: Mass,
    /// The smoothing of E_eps, if that is wanted.
    pub smoothing: Option<Smoothing>,
    /// A dual field that bounds the energies, 2F x m like [`crate::solve::Solution::q`]. Without one, `dual_steps`
    /// steps of the default solver compute one.
    pub q: Option<&'a Array2<f64>>,
    /// Steps of the default solver from U to a dual field; ignored if `q` is given. The default of the program is
    /// [`certificate::DUAL_STEPS`].
    pub dual_steps: u64,
}

/// Scores U (V x m) for labels of vertices and pointwise costs s (V x m, see [`costs`]). U need not be feasible, see
/// [`Evaluation::feasible`].
/// `observe` is called during the steps that compute a bound, without samples.
///
/// Fails if the shapes of the costs, U, q and the mesh do not fit each other, the number of regions is not from 2 to
/// 64, an entry of U or q is not finite, the costs are refused by [`costs::checked`], lambda is negative or not finite,
/// no face has an area, U gives more than 1e-9 to a forbidden label, or the integrated costs leave the range of double
/// precision.
pub fn evaluate(
    mesh: &Mesh,
    s: &Array2<f64>,
    u: &Array2<f64>,
    question: Question<'_>,
    observe: Observer<'_>,
) -> Result<Evaluation> {
    check(s, u, "V x m", &question)?;
    crate::solve::check_rows("costs", s.nrows(), mesh)?;
    let (s, mut warnings) = costs::checked(s, question.mass)?;
    let (model, left_out) = model_mesh(mesh)?;
    warnings.extend(left_out);
    let q = question.q.map(|q| of_model(mesh, &model, q, s.ncols())).transpose()?;
    let question = Question { q: q.as_deref(), ..question };
    let mut evaluation = evaluate_given(mesh, (&*model).into(), &s, u, question, observe)?;
    evaluation.warnings = warnings;
    Ok(evaluation)
}

/// The same for labels of faces, with costs and U of F x m; `contrast` is that of [`crate::solve::solve_on_faces`].
///
/// Fails as [`evaluate`] does, if a weight of the contrast is not positive and finite, and if a q is given.
pub fn evaluate_on_faces(
    mesh: &Mesh,
    contrast: Option<&Contrast>,
    s: &Array2<f64>,
    u: &Array2<f64>,
    question: Question<'_>,
    observe: Observer<'_>,
) -> Result<Evaluation> {
    check(s, u, "F x m", &question)?;
    if question.q.is_some() {
        return Err(Error::unsuitable(
            "a dual field bounds energies of labels of vertices only: leave q out, then steps find a bound",
        ));
    }
    if question.mass != Mass::Barycentric {
        return Err(Error::unsuitable("faces count with their areas: leave mass out"));
    }
    crate::solve::check_rows_of_faces("costs", s.nrows(), mesh)?;
    let (s, warnings) = costs::checked(s, question.mass)?;
    let dual = dual_of(mesh, contrast)?;
    let mut evaluation = evaluate_given(mesh, (&dual).into(), &s, u, question, observe)?;
    evaluation.warnings = warnings;
    Ok(evaluation)
}

/// What is wrong on any element.
fn check(s: &Array2<f64>, u: &Array2<f64>, shape: &str, question: &Question<'_>) -> Result<()> {
    regions::check(s.ncols())?;
    question.relaxation.check(s.ncols())?;
    if u.dim() != s.dim() {
        return Err(Error::unsuitable(format!(
            "U has {} x {} entries, but the costs have {} x {}; both must be {shape}",
            u.nrows(),
            u.ncols(),
            s.nrows(),
            s.ncols()
        )));
    }
    crate::request::check_lambda(question.lambda)?;
    crate::solve::check_finite("entries of U", u)
}

/// The rows of q on the faces that have an area.
fn of_model<'a>(
    mesh: &Mesh,
    model: &Mesh,
    q: &'a Array2<f64>,
    m: usize,
) -> Result<Cow<'a, Array2<f64>>> {
    if q.dim() != (2 * mesh.faces.len(), m) {
        return Err(Error::unsuitable(format!(
            "q has {} x {} entries, but needs two rows for each of the {} faces and {m} columns",
            q.nrows(),
            q.ncols(),
            mesh.faces.len()
        )));
    }
    crate::solve::check_finite("entries of q", q)?;
    if model.faces.len() == mesh.faces.len() {
        return Ok(Cow::Borrowed(q));
    }
    let rows: Vec<usize> = (0..mesh.faces.len())
        .filter(|&j| !mesh.is_degenerate(j))
        .flat_map(|j| [2 * j, 2 * j + 1])
        .collect();
    Ok(Cow::Owned(q.select(Axis(0), &rows)))
}

/// The scores on a domain, computed in a unit of cost that suits it; q is that of the domain.
fn evaluate_given(
    mesh: &Mesh,
    domain: Domain<'_>,
    s: &Array2<f64>,
    u: &Array2<f64>,
    question: Question<'_>,
    observe: Observer<'_>,
) -> Result<Evaluation> {
    let m = s.ncols();
    let Some(unit) = Unit::of(s, question.lambda, domain.area().sqrt()) else {
        return with_regions!(m, evaluate_compiled(mesh, domain, s, u, question, observe));
    };
    let q = question.q.map(|q| unit.of_array(q));
    let lambda = unit.of_number(question.lambda);
    let question = Question { lambda, q: q.as_ref(), ..question };
    let s = &unit.of_array(s);
    let mut evaluation =
        with_regions!(m, evaluate_compiled(mesh, domain, s, u, question, observe))?;
    let optional = [&mut evaluation.smoothed_energy, &mut evaluation.gap].into_iter().flatten();
    for number in [
        &mut evaluation.lambda,
        &mut evaluation.energy,
        &mut evaluation.data_term,
        &mut evaluation.dual_bound,
        &mut evaluation.baseline,
        &mut evaluation.rounded_energy,
    ]
    .into_iter()
    .chain(optional)
    {
        *number = unit.given(*number);
    }
    unit.check(&[evaluation.energy, evaluation.dual_bound, evaluation.rounded_energy])?;
    Ok(evaluation)
}

fn evaluate_compiled<const M: usize>(
    mesh: &Mesh,
    domain: Domain<'_>,
    s: &Array2<f64>,
    u: &Array2<f64>,
    question: Question<'_>,
    observe: Observer<'_>,
) -> Result<Evaluation> {
    let Question { lambda, relaxation, mass, smoothing, q, dual_steps } = question;
    let m = s.ncols();
    let f = integrate(&domain.quadrature(mass), m, &regions::rows::<M>(s.view()));
    let minima: Vec<f64> = f.iter().map(|f| f.min()).collect();
    let problem = Problem::new(domain.stencil(), f, lambda).in_relaxation(relaxation);
    check_range(&problem)?;
    let given: Vec<Row<M>> = regions::rows(u.view());
    let u = without_forbidden(&problem, m, &given)?;

    let first = match q {
        Some(q) => {
            (certificate::offered(&problem, regions::tangents(q.view())), Certificate::Offered)
        }
        None => {
            let start = Start::Given(regions::array(&u, m));
            let on_simplex = start.rows::<M>(m, &problem.f, &Order::as_it_is());
            let bound = certificate::steps(domain, &problem, &on_simplex, dual_steps, observe)?;
            (bound, Certificate::Steps)
        }
    };
    let smoothed = smoothing
        .map(|smoothing| (certificate::smoothed(&problem, &u, smoothing), Certificate::Smoothed));
    let bounds = [first].into_iter().chain(smoothed);
    let (bound, certificate) = bounds.max_by(|a, b| a.0.total_cmp(&b.0)).expect("at least one");
    // q = 0 gives B.
    let bound = bound.max(0.0);
    let feasibility = Feasibility::of(&given, m);
    // <u_k, f_k> = <u_k, f_k - min f_k> + min f_k sum_p u_kp: the minima sum up to B only if the rows of U sum to 1.
    let offset = match feasibility.is_feasible() {
        true => problem.baseline,
        false => u.iter().zip(&minima).map(|(u, minimum)| minimum * u.0.iter().sum::<f64>()).sum(),
    };
    let scored = Scored { problem: &problem, u: &u, offset, bound, certificate };
    Ok(scored.evaluation(mesh, domain, m, question, feasibility))
}

/// How far the given U is outside the simplex.
struct Feasibility {
    largest_row_sum_error: f64,
    smallest_entry: f64,
}

impl Feasibility {
    fn of<const M: usize>(given: &[Row<M>], m: usize) -> Self {
        let row_sum_errors = given.iter().map(|row| (row.0.iter().sum::<f64>() - 1.0).abs());
        let entries = given.iter().flat_map(|row| &row.0[..m]).copied();
        Feasibility {
            largest_row_sum_error: row_sum_errors.fold(0.0, f64::max),
            smallest_entry: entries.fold(f64::INFINITY, f64::min),
        }
    }

    fn is_feasible(&self) -> bool {
        self.largest_row_sum_error <= LARGEST_ROUNDING && self.smallest_entry >= -LARGEST_ROUNDING
    }
}

/// U and the best bound.
struct Scored<'a, const M: usize> {
    problem: &'a Problem<Stencil, M>,
    u: &'a [Row<M>],
    /// E(U) minus the energy that the problem has for U.
    offset: f64,
    /// D - B.
    bound: f64,
    certificate: Certificate,
}

impl<const M: usize> Scored<'_, M> {
    fn evaluation(
        &self,
        mesh: &Mesh,
        domain: Domain<'_>,
        m: usize,
        question: Question<'_>,
        feasibility: Feasibility,
    ) -> Evaluation {
        let Scored { problem, u, offset, bound, certificate } = *self;
        let Question { lambda, mass, smoothing, .. } = question;
        let baseline = problem.baseline;
        let data_term = problem.data_term(u);
        let total_variation = problem.total_variation(u);
        let energy = data_term + lambda * total_variation;
        let rounded_energy = problem.energy(&rounded(&mask_forbidden(problem, u)));
        let bound = problem.clamped_bound(energy, bound);
        let feasible = feasibility.is_feasible();
        let Feasibility { largest_row_sum_error, smallest_entry } = feasibility;
        let smoothed_energy = |smoothing| offset + problem.smoothed_energy(u, smoothing);
        Evaluation {
            vertices: mesh.vertices.len(),
            faces: mesh.faces.len(),
            regions: m,
            lambda,
            relaxation: problem.relaxation.name(),
            mass: mass.name(),
            area: domain.area(),
            energy: offset + energy,
            data_term: offset + data_term,
            total_variation,
            smoothed_energy: smoothing.map(smoothed_energy),
            dual_bound: baseline + bound,
            certificate,
            baseline,
            gap: feasible.then_some(energy - bound),
            relative_gap: feasible.then(|| relative_gap(energy, bound)),
            rounded_energy: baseline + rounded_energy,
            rounded_relative_gap: label_gap(
                rounded_energy,
                problem.clamped_bound(rounded_energy, bound),
            ),
            epsilon: smoothing.map(|smoothing| smoothing.epsilon),
            epsilon_mode: smoothing.map(|smoothing| smoothing.mode.name()),
            feasible,
            largest_row_sum_error,
            smallest_entry,
            warnings: Vec::new(),
        }
    }
}

/// U with exact zeros at forbidden labels. Fails if U gives more than rounding to one.
fn without_forbidden<const M: usize>(
    problem: &Problem<Stencil, M>,
    m: usize,
    u: &[Row<M>],
) -> Result<Vec<Row<M>>> {
    let forbidden = |v: usize, p: usize| problem.f[v].0[p] == FORBIDDEN_COST;
    for (v, row) in u.iter().enumerate() {
        if let Some(p) = (0..m).find(|&p| forbidden(v, p) && row.0[p].abs() > LARGEST_ROUNDING) {
            return Err(Error::unsuitable(format!(
                "U has {} in row {v}, column {p}, but the costs forbid that label (+inf); it must be 0",
                row.0[p]
            )));
        }
    }
    let allowed = |v: usize| Row::from_fn(|p| if forbidden(v, p) { 0.0 } else { u[v].0[p] });
    Ok((0..u.len()).map(allowed).collect())
}

/// U with -inf at forbidden labels and padding regions, so that rounding picks none of them, even if all other entries
/// are negative.
fn mask_forbidden<const M: usize>(problem: &Problem<Stencil, M>, u: &[Row<M>]) -> Vec<Row<M>> {
    let f = &problem.f;
    let allowed = |v: usize, p: usize| f[v].0[p] != FORBIDDEN_COST;
    let row =
        |v: usize| Row::from_fn(|p| if allowed(v, p) { u[v].0[p] } else { f64::NEG_INFINITY });
    (0..u.len()).map(row).collect()
}

#[cfg(test)]
mod tests;
