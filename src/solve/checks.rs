//! Checks before anything is computed: meshes, sizes and numbers that no solver can work with are refused.

use std::borrow::Cow;

use ndarray::Array2;

use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::operator::{Operator, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::sweep;

/// Refuses an array with an entry that is NaN or infinite.
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

/// Refuses an array that does not have one row per vertex of the mesh.
pub(crate) fn check_rows(what: &str, rows: usize, mesh: &Mesh) -> Result<()> {
    let vertices = mesh.vertices.len();
    if rows == vertices {
        Ok(())
    } else {
        Err(Error::unsuitable(format!(
            "the {what} have {}, but the mesh has {}; supply one row per vertex",
            counted(rows, "row", "rows"),
            counted(vertices, "vertex", "vertices")
        )))
    }
}

/// The same with one row per face.
pub(crate) fn check_rows_of_faces(what: &str, rows: usize, mesh: &Mesh) -> Result<()> {
    let faces = mesh.faces.len();
    if rows == faces {
        return Ok(());
    }
    Err(Error::unsuitable(format!(
        "the {what} have {}, but the mesh has {}; supply one row per face",
        counted(rows, "row", "rows"),
        counted(faces, "face", "faces")
    )))
}

/// The mesh without the faces that have no area, and a warning if there are any. A face that is left out no longer
/// couples its corners. A face counts as having an area only if the area and its square are normal numbers, so that no
/// sum overflows.
///
/// Fails if no face has an area.
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
        warnings.push(counted(
            dropped,
            "face without area was left out",
            "faces without area were left out",
        ));
    }
    if model.faces.is_empty() {
        return Err(Error::unsuitable(
            "the mesh has no face with an area; check its coordinates and faces",
        ));
    }
    Ok((model, warnings))
}

/// Fails as [`model_mesh`] does, if no face has an area; stops at the first face that has one.
pub fn check_mesh(mesh: &Mesh) -> Result<()> {
    if (0..mesh.faces.len()).any(|j| !mesh.is_degenerate(j)) {
        return Ok(());
    }
    model_mesh(mesh).map(drop)
}

/// Refuses costs so large that sums overflow or forbidden labels look cheap, and costs so small that they lose digits.
pub(crate) fn check_range<const M: usize>(problem: &Problem<Stencil, M>) -> Result<()> {
    let in_range = |x: f64| x.abs() < 1e-10 * FORBIDDEN_COST;
    let costs = sweep::all(
        problem.f.len(),
        #[inline(always)]
        |v| problem.f[v].0.iter().all(|&f| f == FORBIDDEN_COST || in_range(f)),
    );
    let length = sweep::sum(
        problem.k.faces(),
        #[inline(always)]
        |j| problem.k.weights()[j].iter().map(|c| c.abs()).sum(),
    );
    let spread = problem.spread();
    if spread > 0.0 && spread < MIN_SPREAD {
        return Err(Error::unsuitable(format!(
            "the costs times the areas differ by only {spread:e} in total, too little for double precision; scale \
             the costs or the mesh up"
        )));
    }
    if costs && in_range(problem.lambda * problem.relaxation.label_metric().largest() * length) {
        Ok(())
    } else {
        Err(Error::unsuitable(
            "the costs times the areas, or lambda times the lengths, leave the range of double precision; scale \
             the costs, lambda or the mesh down",
        ))
    }
}

/// Costs that differ by less in total are close to the smallest normal number.
const MIN_SPREAD: f64 = 1e-290;
