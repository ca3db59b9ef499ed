//! What is refused before anything is computed: meshes, sizes and numbers that no solver could work with.

use std::borrow::Cow;

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::operator::{Operator, Stencil};
use crate::problem::{FORBIDDEN, Problem};
use crate::sweep;

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

/// The faces with an area, and what was left out. What is left out couples its corners no more. The area of what is kept
/// is an ordinary number: that of a face is, or it counts as none, and so is the square of it, so that no sum overflows.
pub fn model_mesh(mesh: &Mesh) -> Result<(Cow<'_, Mesh>, Vec<String>)> {
    let fine = sweep::all(
        mesh.faces.len(),
        #[inline(always)]
        |j| !mesh.is_degenerate(j),
    );
    let (model, dropped) = match fine {
        true => (Cow::Borrowed(mesh), 0),
        false => mesh.without_degenerate_faces(),
    };
    let mut warnings = Vec::new();
    if dropped > 0 {
        warnings.push(format!("{dropped} faces without area were left out"));
    }
    if model.faces.is_empty() {
        return Err(Error::unsuitable("the mesh has no face with an area"));
    }
    Ok((model, warnings))
}

/// Refuses what [`model_mesh`] refuses, and looks no further than to the first face with an area.
pub fn check_mesh(mesh: &Mesh) -> Result<()> {
    if (0..mesh.faces.len()).any(|j| !mesh.is_degenerate(j)) {
        return Ok(());
    }
    model_mesh(mesh).map(drop)
}

/// Refuses numbers so large that sums of them overflow or that closed regions would look cheap, and so small that they
/// have lost their digits.
pub(crate) fn check_range<const M: usize>(problem: &Problem<Stencil, M>) -> Result<()> {
    let in_range = |x: f64| x.abs() < 1e-10 * FORBIDDEN;
    let costs = sweep::all(
        problem.f.len(),
        #[inline(always)]
        |v| problem.f[v].0.iter().all(|&f| f == FORBIDDEN || in_range(f)),
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
