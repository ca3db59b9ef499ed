//! A coarse copy of a mesh, good enough to choose a view by: vertices that share a cell of a grid become one.
//!
//! J. Rossignac, P. Borrel, *Multi-resolution 3D approximations for rendering complex scenes*, 1993. The image of a
//! surface without holes has none.

use super::labels::LabelField;
use crate::mesh::Mesh;

/// Meshes of no more faces are taken as they are.
const FEW: usize = 6_000;
/// Cells along each axis of the cube [-1, 1]^3.
const CELLS: usize = 32;

pub(super) struct Simplified {
    pub mesh: Mesh,
    /// Of the first vertex in each cell.
    pub u: Vec<f64>,
    /// The area around each vertex, of the mesh itself.
    pub areas: Vec<f64>,
}

/// `mesh` lies in the unit ball.
pub(super) fn simplified(mesh: &Mesh, field: &LabelField) -> Simplified {
    let few = mesh.faces.len() <= FEW;
    let mut cells = vec![u32::MAX; if few { 0 } else { CELLS * CELLS * CELLS }];
    let mut vertices = Vec::new();
    let mut u = Vec::new();
    let mut index = Vec::with_capacity(mesh.vertices.len());
    for (v, x) in mesh.vertices.iter().enumerate() {
        let mut own = u32::MAX;
        let at = |c: f64| (((c + 1.0) / 2.0 * CELLS as f64) as usize).min(CELLS - 1);
        let cell =
            if few { &mut own } else { &mut cells[(at(x.x) * CELLS + at(x.y)) * CELLS + at(x.z)] };
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
