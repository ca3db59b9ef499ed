//! A mesh with another connectivity, and the interpolation from the vertices of the old one.

use nalgebra::Point3;
use ndarray::{Array2, ArrayView2};

use crate::mesh::Mesh;

/// The result of a change of connectivity.
#[derive(Clone, Debug, PartialEq)]
pub struct Remeshed {
    /// The new mesh, without colors, texture coordinates and materials.
    pub mesh: Mesh,
    /// For each new vertex two old ones, and the weight of the second: values are (1 - weight) of a plus weight of b.
    pub parents: Vec<(u32, u32, f64)>,
}

impl Remeshed {
    /// A mesh with the same vertices and other faces.
    pub(super) fn of_faces(vertices: Vec<Point3<f64>>, faces: Vec<[u32; 3]>) -> Self {
        let parents = (0..vertices.len() as u32).map(|k| (k, k, 0.0)).collect();
        Remeshed { mesh: Mesh::new(vertices, faces), parents }
    }

    /// Values at the new vertices from values at the old ones, a row per vertex.
    pub fn interpolated(&self, values: ArrayView2<'_, f64>) -> Array2<f64> {
        Array2::from_shape_fn((self.parents.len(), values.ncols()), |(k, p)| {
            let (a, b, weight) = self.parents[k];
            (1.0 - weight) * values[(a as usize, p)] + weight * values[(b as usize, p)]
        })
    }
}
