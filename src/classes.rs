//! Labels from class probabilities, as a network, votes of views or a person give them: one row per vertex or face.
//!
//! ```text
//! s_kp = -log p_kp        the costs of class p at k, `classes/costs.rs`
//! ```
//!
//! The classes are the regions, and their costs are fixed, so that there is one convex problem and nothing to estimate.
//! Labels are those of vertices or of faces (`domain.rs`), wherever the probabilities are: `classes/carry.rs` carries
//! costs from one to the other exactly, and labels back. `classes/lambda.rs` chooses lambda if none is given, and
//! `classes/islands.rs` removes small parts.

pub mod carry;
pub mod costs;
pub mod islands;
pub mod lambda;
pub mod noisy;
mod patches;

use ndarray::{Array1, Array2, ArrayView1};

use crate::costs::unknown_rows;
use crate::counted::counted;
use crate::domain::{Domain, Element};
use crate::empty_regions;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::mesh::dual::Dual;
use crate::operator::Mass;
use crate::problem::label_gap;
use crate::request::{Observer, Request};
use crate::rounding::cut_energy;
use crate::seeds::Seeds;
use crate::solve::{Solution, model_mesh, solve_on_faces, solve_weighted};
use crate::start::Start;
use crate::sweep::sum;
pub use islands::{Cleaned, Cleaning};

/// Pointwise costs of classes, and where they are known.
pub struct ClassCosts {
    /// s: one row per vertex or face; a row of NaN is unknown.
    pub s: Array2<f64>,
    /// What the rows are those of.
    pub of: Element,
}

/// The class of least cost in a row, the first of equal ones.
pub fn most_probable(s: ArrayView1<'_, f64>) -> usize {
    (1..s.len()).fold(0, |best, p| if s[p] < s[best] { p } else { best })
}

/// How classes become labels.
pub struct Labeling<'a> {
    /// Where the labels are.
    pub on: Element,
    /// How much cuts cost where, if not everywhere the same.
    pub contrast: Option<&'a Contrast>,
    /// Vertices, or faces, whose labels are given.
    pub seeds: &'a Seeds,
    /// What is done to the labels in the end.
    pub cleaning: Cleaning,
}

/// Labels of a mesh, on its vertices and on its faces.
pub struct ClassLabels {
    /// The solution, on the element that was asked for.
    pub solution: Solution,
    /// V labels.
    pub vertices: Array1<i32>,
    /// F labels.
    pub faces: Array1<i32>,
    /// What was done to the labels in the end.
    pub cleaned: Option<Cleaned>,
}

impl ClassCosts {
    /// The costs on the vertices or faces of the mesh, with the same integral against every U there.
    pub fn on(&self, element: Element, mesh: &Mesh) -> Array2<f64> {
        match (self.of, element) {
            (Element::Faces, Element::Vertices) => carry::to_vertices(mesh, &self.s),
            (Element::Vertices, Element::Faces) => carry::to_faces(mesh, &self.s),
            _ => self.s.clone(),
        }
    }
}

/// Solves for labels of the vertices or the faces of a mesh as it is, without scaling. `s` are pointwise costs on
/// these.
///
/// # Errors
/// Those of [`solve_weighted`] and [`solve_on_faces`].
pub fn label(
    mesh: &Mesh,
    s: &Array2<f64>,
    labeling: &Labeling<'_>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<ClassLabels> {
    let Labeling { on, contrast, seeds, cleaning } = labeling;
    let mut solution = match on {
        Element::Vertices => {
            let factors = contrast.map(|contrast| contrast.of_faces(mesh));
            let factors = factors.as_deref();
            solve_weighted(mesh, factors, s, seeds, &Start::Argmin, request, observe)?
        }
        Element::Faces => {
            solve_on_faces(mesh, *contrast, s, seeds, &Start::Argmin, request, observe)?
        }
    };
    // Unknown rows are told of where they were given, which may be on another element.
    let unknown = s.outer_iter().filter(|row| row[0].is_nan()).count();
    let of_costs = unknown_rows(unknown);
    solution.summary.warnings.retain(|warning| *warning != of_costs);
    let cleaned = match cleaning.is_none() {
        true => None,
        false => Some(clean(mesh, s, labeling, request, &mut solution)?),
    };
    let labels = solution.labels.clone();
    let (vertices, faces) = match on {
        Element::Vertices => {
            let faces = carry::labels_of_faces(mesh, &solution.u, &labels);
            (labels, faces)
        }
        Element::Faces => (carry::labels_of_vertices(mesh, &labels, s.ncols()), labels),
    };
    Ok(ClassLabels { solution, vertices, faces, cleaned })
}

/// Warnings about labels of faces: of faces without area, which come from their neighbors, and of vertices without
/// faces, which come from nowhere.
pub fn without_evidence(mesh: &Mesh) -> Vec<String> {
    let degenerate = (0..mesh.faces.len()).filter(|&j| mesh.is_degenerate(j)).count();
    let mut has_faces = vec![false; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|&v| has_faces[v as usize] = true);
    let alone = has_faces.iter().filter(|has_faces| !**has_faces).count();
    let mut warnings = Vec::new();
    if degenerate > 0 {
        warnings.push(counted(
            degenerate,
            "face has no area, so its costs do not count: it takes the label of its neighbors",
            "faces have no area, so their costs do not count: they take the labels of their neighbors",
        ));
    }
    if alone > 0 {
        warnings.push(counted(
            alone,
            "vertex has no face: its label, 0, means nothing",
            "vertices have no face: their label, 0, means nothing",
        ));
    }
    warnings
}

/// Cleans the labels of a solution, and corrects what its summary says of them.
fn clean(
    mesh: &Mesh,
    s: &Array2<f64>,
    labeling: &Labeling<'_>,
    request: &Request,
    solution: &mut Solution,
) -> Result<Cleaned> {
    let Labeling { on, contrast, seeds, cleaning } = labeling;
    let (model, _) = model_mesh(mesh)?;
    let dual = match on {
        Element::Vertices => None,
        Element::Faces => {
            Some(contrast.map_or_else(|| Dual::new(mesh), |contrast| contrast.dual(mesh)))
        }
    };
    let factors = contrast.map(|contrast| {
        let factors = contrast.of_faces(mesh);
        let kept = (0..factors.len()).filter(|&j| !mesh.is_degenerate(j));
        kept.map(|j| factors[j]).collect::<Vec<f64>>()
    });
    let domain = match (&dual, &factors) {
        (Some(dual), _) => Domain::Faces(dual),
        (None, Some(factors)) => Domain::Weighted(&model, factors),
        (None, None) => Domain::Vertices(&model),
    };
    let (weights, m) = (domain.weights(Mass::Barycentric), s.ncols());
    let integrated = |(s, w): (ArrayView1<'_, f64>, f64)| -> Vec<f64> {
        s.iter().map(|s| if s.is_nan() { 0.0 } else { w * s }).collect()
    };
    let f: Vec<f64> = s.outer_iter().zip(weights).flat_map(integrated).collect();
    let summary = &mut solution.summary;
    let energy = |labels: &[u8]| {
        let data = sum(labels.len(), |v| f[v * m + usize::from(labels[v])]);
        data + cut_energy(domain, request.relaxation, request.lambda, labels)
    };
    let mut labels: Vec<u8> = solution.labels.iter().map(|&p| p as u8).collect();
    let before = energy(&labels);
    let fixed = |v: usize| seeds.region(v);
    let (parts, area) = cleaning.apply(domain, (&f, m), request.lambda, &fixed, &mut labels);
    let change = if parts == 0 { 0.0 } else { energy(&labels) - before };
    let cleaned = Cleaned {
        parts,
        area,
        energy_before: summary.rounded_energy,
        energy_after: summary.rounded_energy + change,
    };
    summary.rounded_energy += change;
    let bound = summary.rounding.as_ref().map_or(summary.dual_bound, |found| found.label_bound);
    let above = |energy: f64| energy - summary.baseline;
    summary.rounded_relative_gap = label_gap(above(summary.rounded_energy), above(bound));
    solution.labels = labels.into_iter().map(i32::from).collect();
    summary.empty_regions = empty_regions::of_labels(&solution.labels, m);
    Ok(cleaned)
}

#[cfg(test)]
mod tests;
