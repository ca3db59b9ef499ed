//! The bounding box of a mesh, and the number of its components.

use nalgebra::Point3;
use serde::Serialize;

use super::Mesh;
use super::disjoint_sets::DisjointSets;

/// An axis-parallel box, in units of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundingBox {
    /// The smallest x, y and z.
    pub min: [f64; 3],
    /// The largest x, y and z.
    pub max: [f64; 3],
}

impl BoundingBox {
    /// The length of its diagonal.
    pub fn diagonal(&self) -> f64 {
        (Point3::from(self.max) - Point3::from(self.min)).norm()
    }
}

/// The bounding box of all vertices.
pub fn bounding_box(mesh: &Mesh) -> Option<BoundingBox> {
    let first = mesh.vertices.first()?;
    let (min, max) =
        mesh.vertices.iter().fold((*first, *first), |(min, max), x| (min.inf(x), max.sup(x)));
    Some(BoundingBox { min: min.into(), max: max.into() })
}

/// The number of components of the faces with three different corners, connected through shared vertices.
pub fn components(mesh: &Mesh) -> usize {
    let mut joined = DisjointSets::new(mesh.vertices.len());
    let mut in_face = vec![false; mesh.vertices.len()];
    for &[a, b, c] in mesh.faces.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
        joined.join(a, b);
        joined.join(a, c);
        for v in [a, b, c] {
            in_face[v as usize] = true;
        }
    }
    joined.count(&in_face)
}
