//! Labels from class probabilities, as a network, votes of views or a person give them: one row per vertex or face.
//!
//! ```text
//! s_kp = -log p_kp        the costs of class p at k, `classes/costs.rs`
//! ```
//!
//! The classes are the regions, and their costs are fixed, so that there is one convex problem and nothing to estimate.
//! Labels are those of vertices or of faces (`domain.rs`), wherever the probabilities are: `classes/carry.rs` carries
//! costs from one to the other exactly, and labels back. `classes/lambda.rs` chooses lambda if none is given.

pub mod carry;
pub mod costs;
pub mod lambda;

use ndarray::{Array1, Array2};

use crate::domain::Element;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::request::{Observer, Request};
use crate::seeds::Seeds;
use crate::solve::{Solution, solve_on_faces, solve_seeded};
use crate::start::Start;

/// Pointwise costs of classes, and where they are known.
pub struct ClassCosts {
    /// s: one row per vertex or face; a row of NaN is unknown.
    pub s: Array2<f64>,
    /// What the rows are those of.
    pub of: Element,
}

/// Labels of a mesh, on its vertices and on its faces.
pub struct ClassLabels {
    /// The solution, on the element that was asked for.
    pub solution: Solution,
    /// V labels.
    pub vertices: Array1<i32>,
    /// F labels.
    pub faces: Array1<i32>,
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

/// Solves for labels of the vertices or the faces of a mesh as it is, without scaling. `s` are pointwise costs on these;
/// seeds are those of the same element.
///
/// # Errors
/// Those of [`solve_seeded`] and [`solve_on_faces`].
pub fn label(
    mesh: &Mesh,
    (s, on): (&Array2<f64>, Element),
    seeds: &Seeds,
    request: &Request,
    observe: Observer<'_>,
) -> Result<ClassLabels> {
    let solution = match on {
        Element::Vertices => solve_seeded(mesh, s, seeds, &Start::Argmin, request, observe)?,
        Element::Faces => solve_on_faces(mesh, s, seeds, &Start::Argmin, request, observe)?,
    };
    let labels = solution.labels.clone();
    let (vertices, faces) = match on {
        Element::Vertices => {
            let faces = carry::labels_of_faces(mesh, &solution.u, &labels);
            (labels, faces)
        }
        Element::Faces => (carry::labels_of_vertices(mesh, &labels, s.ncols()), labels),
    };
    Ok(ClassLabels { solution, vertices, faces })
}

#[cfg(test)]
mod tests;
