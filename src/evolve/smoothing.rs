//! Vertices move within the surface towards the mean of their neighbors, so that faces stay well shaped while the
//! surface evolves.
//!
//! ```text
//! x_k + strength (I - N_k N_k^T) (mean of the neighbors - x_k)
//! ```
//!
//! The shape changes in second order only: a displacement within the tangent plane leaves a surface of curvature c by
//! about c / 2 times its square. Vertices at a border keep their places.
//!
//! Reference: M. Botsch, L. Kobbelt, *A remeshing approach to multiresolution modeling*, SGP 2004.

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::mesh::geometry::vertex_normals;
use crate::mesh::sides::{edges, sides};

/// The new positions of the vertices, for a strength from 0 (none) to 1 (all the way).
pub fn tangential(mesh: &Mesh, strength: f64) -> Vec<[f64; 3]> {
    let mut sums = vec![Vector3::zeros(); mesh.vertices.len()];
    let mut counts = vec![0.0; mesh.vertices.len()];
    let mut border = vec![false; mesh.vertices.len()];
    for edge in edges(&sides(&mesh.faces)) {
        let [a, b] = edge[0].edge.map(|k| k as usize);
        for (k, neighbor) in [(a, b), (b, a)] {
            sums[k] += mesh.vertices[neighbor].coords;
            counts[k] += 1.0;
            border[k] |= edge.len() == 1;
        }
    }
    let normals = vertex_normals(mesh);
    let position = |(k, normal): (usize, Vector3<f64>)| {
        let x = mesh.vertices[k].coords;
        if border[k] || counts[k] == 0.0 {
            return x.into();
        }
        let move_by = sums[k] / counts[k] - x;
        (x + strength * (move_by - normal * normal.dot(&move_by))).into()
    };
    normals.into_iter().enumerate().map(position).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_vector, rng, shape, with_isolated_vertices, zoo};

    fn smoothed(mesh: &Mesh, strength: f64) -> Mesh {
        let vertices = tangential(mesh, strength).into_iter().map(Into::into).collect();
        Mesh { vertices, ..mesh.clone() }
    }

    /// On a grid the neighbors of a regular vertex are symmetric, so that the grid is the limit.
    #[test]
    fn a_planar_patch_becomes_regular() {
        let regular = shape("grid:8x8");
        let mut mesh = regular.clone();
        let mut rng = rng(2);
        for x in &mut mesh.vertices {
            if [x.x, x.y].iter().all(|c| (0.01..0.99).contains(c)) {
                let by = 0.04 * random_vector(&mut rng);
                x.x += by.x;
                x.y += by.y;
            }
        }
        for _ in 0..400 {
            mesh = smoothed(&mesh, 0.5);
        }
        for (x, expected) in mesh.vertices.iter().zip(&regular.vertices) {
            assert!((x - expected).norm() <= 1e-9, "{x} {expected}");
        }
    }

    /// Vertices that are off by a tenth of an edge.
    #[test]
    fn the_radius_of_a_sphere_changes_in_second_order_only() {
        let change = |level: u32| {
            let mut mesh = shape(&format!("sphere:{level}"));
            let h = 0.5_f64.powi(level as i32);
            let mut rng = rng(4);
            for x in &mut mesh.vertices {
                *x += 0.1 * h * random_vector(&mut rng);
                x.coords.normalize_mut();
            }
            let moved = smoothed(&mesh, 0.1);
            let away = (mesh.vertices.iter().zip(&moved.vertices)).map(|(a, b)| (a - b).norm());
            let away = away.fold(0.0, f64::max);
            assert!(away > 0.005 * h, "{away}");
            let changes = moved.vertices.iter().map(|x| (x.coords.norm() - 1.0).abs());
            changes.sum::<f64>() / mesh.vertices.len() as f64
        };
        for level in [2, 3, 4] {
            let order = (change(level) / change(level + 1)).log2();
            assert!((order - 2.0).abs() < 0.2, "{level}: {order}");
        }
    }

    #[test]
    fn strength_0_and_vertices_without_faces_stay() {
        for (_, mesh) in zoo() {
            let kept: Vec<[f64; 3]> = mesh.vertices.iter().map(|&x| x.into()).collect();
            assert_eq!(tangential(&mesh, 0.0), kept);
        }
        let isolated = with_isolated_vertices(shape("sphere:1"));
        let moved = smoothed(&isolated, 0.5);
        assert_eq!(moved.vertices.last(), isolated.vertices.last());
        assert_eq!(moved.vertices[0], isolated.vertices[0]);
    }
}
