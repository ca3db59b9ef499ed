//! A coarse copy of a mesh, good enough for choosing a view: the vertices in a cell of a grid become one.
//!
//! J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes*, 1993. The image of a
//! surface without holes has no holes.

use super::labels::LabelField;
use crate::mesh::Mesh;

/// Meshes with at most this many faces are kept as they are.
const MAX_KEPT_FACES: usize = 6_000;
/// Cells along each axis of the cube [-1, 1]^3.
const CELLS: usize = 32;

pub(super) struct Simplified {
    pub mesh: Mesh,
    /// The rows of the first vertex in each cell.
    pub u: Vec<f64>,
    /// The area of the original mesh around each vertex.
    pub areas: Vec<f64>,
}

/// Simplifies `mesh`, which lies in the unit ball.
pub(super) fn simplified(mesh: &Mesh, field: &LabelField) -> Simplified {
    let keep = mesh.faces.len() <= MAX_KEPT_FACES;
    let mut cells = vec![u32::MAX; if keep { 0 } else { CELLS * CELLS * CELLS }];
    let mut vertices = Vec::new();
    let mut u = Vec::new();
    let mut index = Vec::with_capacity(mesh.vertices.len());
    for (v, x) in mesh.vertices.iter().enumerate() {
        let mut own = u32::MAX;
        let slot = |c: f64| (((c + 1.0) / 2.0 * CELLS as f64) as usize).min(CELLS - 1);
        let cell = if keep {
            &mut own
        } else {
            &mut cells[(slot(x.x) * CELLS + slot(x.y)) * CELLS + slot(x.z)]
        };
        if *cell == u32::MAX {
            *cell = vertices.len() as u32;
            vertices.push(*x);
            u.extend_from_slice(field.row(v));
        }
        index.push(*cell);
    }
    let mut areas = vec![0.0; vertices.len()];
    let mut faces = Vec::new();
    for (j, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = face.map(|v| index[v as usize]);
        let third = mesh.face_area(j) / 3.0;
        for v in [a, b, c] {
            areas[v as usize] += third;
        }
        if a != b && b != c && c != a {
            faces.push([a, b, c]);
        }
    }
    Simplified { mesh: Mesh::new(vertices, faces), u, areas }
}
