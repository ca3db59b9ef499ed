//! Seams of coincident vertices that cut an unwelded mesh, and the tolerance at which a weld would mend it.

use super::equal::firsts;
use super::near::near;
use super::{Weld, moved};
use crate::counted::counted;
use crate::mesh::Mesh;
use crate::mesh::extent::{bounding_box, components};

/// Vertices closer than this fraction of the bounding box's diagonal are probably meant to be one.
const NEARLY_COINCIDENT: f64 = 1e-6;

/// The number of referenced vertices at the position of an earlier one, which [`Weld::exact`] merges.
pub fn coincident(mesh: &Mesh) -> usize {
    firsts(mesh).map_or(0, |first| moved(&first))
}

/// A clause of a warning about that many coincident vertices.
pub fn free_cuts(coincident: usize) -> String {
    format!(
        "{} of others, and cuts along such seams are free",
        counted(coincident, "vertex lies at the position", "vertices lie at the positions")
    )
}

/// The number of vertices near an earlier one, but not at its position, and the tolerance, a length: 1e-6 of the
/// diagonal of the bounding box.
pub fn nearly_coincident(mesh: &Mesh) -> (usize, f64) {
    let Some(corners) = bounding_box(mesh) else { return (0, 0.0) };
    let tolerance = NEARLY_COINCIDENT * corners.diagonal();
    let within = moved(&near(mesh, firsts(mesh), tolerance));
    (within - coincident(mesh), tolerance)
}

/// Whether a mesh is close to a triangle soup: it has more than half as many components as faces.
pub fn is_shattered(mesh: &Mesh) -> bool {
    let faces = mesh.faces.len();
    // Each component needs three vertices of its own; nearly all meshes have too few.
    faces > 2 && mesh.vertices.len() >= 3 * (faces / 2) && 2 * components(mesh) > faces
}

/// The first tolerance, a length, of 0, 1e-6, 1e-5 and 1e-4 times the diagonal of the bounding box at which a weld
/// mends a shattered mesh without collapsing a face; `None` if there is none.
pub fn mending_tolerance(mesh: &Mesh) -> Option<f64> {
    let diagonal = bounding_box(mesh).map_or(0.0, |corners| corners.diagonal());
    [0.0, 1e-6, 1e-5, 1e-4].map(|share| share * diagonal).into_iter().find(|&tolerance| {
        Weld::within(mesh, tolerance).is_some_and(|weld| {
            let collapsed = |j: &usize| weld.mesh.is_degenerate(*j) && !mesh.is_degenerate(*j);
            !is_shattered(&weld.mesh) && !(0..mesh.faces.len()).any(|j| collapsed(&j))
        })
    })
}
