//! The area of the surface: d A / d x_a = n x (opposite edge) / 2 on every face, with the unit normal n.

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::mesh::geometry::opposite_edges;

/// Adds kappa times the gradient of the area.
pub fn add_gradient(mesh: &Mesh, kappa: f64, gradient: &mut [Vector3<f64>]) {
    for (j, corners) in mesh.faces.iter().enumerate() {
        let Some(n) = mesh.area_vector(j).try_normalize(0.0) else { continue };
        for (&k, edge) in corners.iter().zip(opposite_edges(mesh, j)) {
            gradient[k as usize] += 0.5 * kappa * n.cross(&edge);
        }
    }
}
