//! The light on a surface that moves, and the gradient of the energy by way of it.
//!
//! ```text
//! s_a = alpha + max(0, N_a.L),   N_a = B_a / |B_a|,   B_a the sum of (x2 - x1) x (x3 - x1) of the faces at a
//! h_a = dE/ds_a [N_a.L > 0] (L - (N_a.L) N_a) / |B_a|
//! v = h_1 + h_2 + h_3 on every face:   dE/dx1 += (x2 - x3) x v and cyclic
//! ```

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::mesh::geometry::opposite_edges;

/// A distant light and ambient light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// L, towards the light, of length 1; 0 for ambient light alone.
    pub direction: Vector3<f64>,
    /// alpha.
    pub ambient: f64,
}

impl Light {
    /// s at all vertices of a mesh.
    pub fn shading(&self, mesh: &Mesh) -> Vec<f64> {
        let lit = |b: Vector3<f64>| {
            let n = b.try_normalize(0.0).unwrap_or_default();
            self.ambient + n.dot(&self.direction).max(0.0)
        };
        sums(mesh).into_iter().map(lit).collect()
    }

    /// Adds the gradient for dE/ds at all vertices.
    pub fn add_gradient(&self, mesh: &Mesh, by_shading: &[f64], gradient: &mut [Vector3<f64>]) {
        let h = |(b, by_s): (Vector3<f64>, &f64)| {
            let length = b.norm();
            if length == 0.0 {
                return Vector3::zeros();
            }
            let n = b / length;
            let cosine = n.dot(&self.direction);
            if cosine > 0.0 {
                (by_s / length) * (self.direction - cosine * n)
            } else {
                Vector3::zeros()
            }
        };
        let h: Vec<Vector3<f64>> = sums(mesh).into_iter().zip(by_shading).map(h).collect();
        for (j, corners) in mesh.faces.iter().enumerate() {
            let corners = corners.map(|k| k as usize);
            let v = h[corners[0]] + h[corners[1]] + h[corners[2]];
            for (k, edge) in corners.into_iter().zip(opposite_edges(mesh, j)) {
                gradient[k] -= edge.cross(&v);
            }
        }
    }
}

/// B_a.
fn sums(mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); mesh.vertices.len()];
    for (j, corners) in mesh.faces.iter().enumerate() {
        let twice = 2.0 * mesh.area_vector(j);
        corners.iter().for_each(|&k| sums[k as usize] += twice);
    }
    sums
}
