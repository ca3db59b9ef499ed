//! The roughness of the surface, |L X|^2 / 2 with (L X)_k = x_k - mean of its neighbors, and its gradient L^T L X.

use nalgebra::{Point3, Vector3};

use super::edges::Neighbors;

/// (L X)_k; 0 at vertices without neighbors.
pub fn differences(neighbors: &Neighbors, vertices: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    let difference = |(k, x): (usize, &Point3<f64>)| {
        let around = neighbors.of(k);
        if around.is_empty() {
            return Vector3::zeros();
        }
        let sum: Vector3<f64> = around.iter().map(|&i| vertices[i as usize].coords).sum();
        x.coords - sum / around.len() as f64
    };
    vertices.iter().enumerate().map(difference).collect()
}

/// |L X|^2 / 2.
pub fn roughness(neighbors: &Neighbors, vertices: &[Point3<f64>]) -> f64 {
    0.5 * differences(neighbors, vertices).iter().map(Vector3::norm_squared).sum::<f64>()
}

/// Adds eta times the gradient.
pub fn add_gradient(
    neighbors: &Neighbors,
    vertices: &[Point3<f64>],
    eta: f64,
    gradient: &mut [Vector3<f64>],
) {
    for (k, difference) in differences(neighbors, vertices).into_iter().enumerate() {
        let around = neighbors.of(k);
        gradient[k] += eta * difference;
        let share = eta / around.len().max(1) as f64;
        around.iter().for_each(|&i| gradient[i as usize] -= share * difference);
    }
}
