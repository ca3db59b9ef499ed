//! What coincident vertices do to a mesh that is taken as it is, and at which tolerance a weld would mend it.

use super::equal::firsts;
use super::near::near;
use super::{Weld, moved};
use crate::mesh::Mesh;
use crate::mesh::extent::{bounding_box, components};

/// Vertices nearer than this share of the bounding box's diagonal are probably meant to be one.
const NEARLY_COINCIDENT: f64 = 1e-6;

/// How many vertices of faces lie at the position of an earlier one: what [`Weld::exact`] merges.
pub fn coincident(mesh: &Mesh) -> usize {
    firsts(mesh).map_or(0, |first| moved(&first))
}

/// What that number of coincident vertices means, in words.
pub fn free_cuts(coincident: usize) -> String {
    format!(
        "{coincident} vertices lie at the positions of others, and cuts along such seams are free"
    )
}

/// How many vertices lie near an earlier one, but not at its position; and how near that is, a length: 1e-6 of the
/// diagonal of the bounding box.
pub fn nearly_coincident(mesh: &Mesh) -> (usize, f64) {
    let Some(corners) = bounding_box(mesh) else { return (0, 0.0) };
    let tolerance = NEARLY_COINCIDENT * corners.diagonal();
    let within = moved(&near(mesh, firsts(mesh), tolerance));
    (within - coincident(mesh), tolerance)
}

/// Whether a mesh falls apart into about as many components as it has faces, as a soup of triangles does.
pub fn is_shattered(mesh: &Mesh) -> bool {
    let faces = mesh.faces.len();
    // Each component has three vertices of its own, which nearly all meshes have not enough of.
    faces > 2 && mesh.vertices.len() >= 3 * (faces / 2) && 2 * components(mesh) > faces
}

/// Of 0, 1e-6, 1e-5 and 1e-4 times the diagonal of the bounding box the first tolerance, a length, at which a weld
/// makes a shattered mesh whole without collapsing a face; none if there is none.
pub fn mending_tolerance(mesh: &Mesh) -> Option<f64> {
    let diagonal = bounding_box(mesh).map_or(0.0, |corners| corners.diagonal());
    [0.0, 1e-6, 1e-5, 1e-4].map(|share| share * diagonal).into_iter().find(|&tolerance| {
        Weld::within(mesh, tolerance).is_some_and(|weld| {
            let collapsed = |j: &usize| weld.mesh.is_degenerate(*j) && !mesh.is_degenerate(*j);
            !is_shattered(&weld.mesh) && !(0..mesh.faces.len()).any(|j| collapsed(&j))
        })
    })
}
