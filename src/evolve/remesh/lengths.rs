//! The lengths of edges.

use crate::mesh::Mesh;
use crate::mesh::sides::{edges, sides};

/// The median of the lengths of the edges, each counted once; `None` without edges.
pub fn median_edge_length(mesh: &Mesh) -> Option<f64> {
    let sides = sides(&mesh.faces);
    let mut lengths: Vec<f64> = edges(&sides).map(|edge| length(mesh, edge[0].edge)).collect();
    if lengths.is_empty() {
        return None;
    }
    let half = lengths.len() / 2;
    Some(*lengths.select_nth_unstable_by(half, f64::total_cmp).1)
}

/// The distance between two vertices.
pub fn length(mesh: &Mesh, [a, b]: [u32; 2]) -> f64 {
    (mesh.vertices[a as usize] - mesh.vertices[b as usize]).norm()
}
