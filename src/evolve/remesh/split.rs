//! Splits of long edges.

use super::lengths::{length, median_edge_length};
use super::remeshed::Remeshed;
use crate::mesh::Mesh;

/// Splits every edge that is longer than `factor` times the median at its midpoint. Faces with one, two or three such
/// edges become two, three or four, so that no vertex lies inside an edge, and the surface stays the same set of points.
/// Old vertices keep their indices. A factor of 0 divides every face into four.
pub fn split_long(mesh: &Mesh, factor: f64) -> Remeshed {
    let limit = median_edge_length(mesh).map_or(f64::INFINITY, |median| factor * median);
    let plain = Mesh::new(mesh.vertices.clone(), mesh.faces.clone());
    let lengths = |j: usize| {
        let [a, b, c] = mesh.faces[j];
        [[a, b], [b, c], [c, a]].map(|edge| length(mesh, edge))
    };
    // In one order of the ends, so that the faces of an edge agree.
    let divided = plain.divided(|a, b| length(mesh, [a.min(b), a.max(b)]) > limit, lengths);
    let kept = (0..mesh.vertices.len() as u32).map(|k| (k, k, 0.0));
    let parents = kept.chain(divided.ends.iter().map(|&[a, b]| (a, b, 0.5))).collect();
    Remeshed { mesh: divided.mesh, parents }
}
