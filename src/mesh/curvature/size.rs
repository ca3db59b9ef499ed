//! Meshes scaled to an ordinary size, so that powers of lengths do not overflow.

use crate::mesh::Mesh;

/// The vertices and faces with the largest coordinate about 1, and the factor: a power of two, which causes no rounding.
pub fn of_ordinary_size(mesh: &Mesh) -> (Mesh, f64) {
    let largest = mesh.vertices.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
    let unit = if largest > 0.0 { 2.0_f64.powi(-(largest.log2() as i32)) } else { 1.0 };
    (Mesh::new(mesh.vertices.iter().map(|x| x * unit).collect(), mesh.faces.clone()), unit)
}
