//! Surfaces to start from: a sphere, a box, the visual hull.

mod choice;
mod cuboid;
mod gaze;
mod hull;
mod signed_distance;
mod tetrahedra;

use nalgebra::Point3;

use crate::mesh::{Mesh, Shape};

pub use choice::Choice;
pub use cuboid::cuboid;
pub use gaze::around;
pub use hull::hull;

/// A sphere: the icosahedron subdivided the given number of times, 0 to 10; 3 for 642 vertices.
pub fn sphere(center: Point3<f64>, radius: f64, subdivisions: u32) -> Mesh {
    let mut mesh = Shape::Sphere { level: subdivisions }.mesh();
    mesh.vertices.iter_mut().for_each(|x| *x = center + radius * x.coords);
    mesh
}

#[cfg(test)]
mod tests;
