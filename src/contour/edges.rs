//! The cut of labels of the faces of a mesh: a path along edges.

use ndarray::ArrayView1;

use super::polylines::{Contours, Segment};
use crate::mesh::Mesh;
use crate::mesh::sides::{edges, sides};

impl Contours {
    /// The edges whose faces have different labels, F labels from 0 to 63. An edge with more than two faces is there
    /// once for each pair of their labels.
    pub fn between_faces(mesh: &Mesh, labels: ArrayView1<'_, i32>) -> Self {
        let mut segments = Vec::new();
        let sides = sides(&mesh.faces);
        for sides in edges(&sides) {
            let [a, b] = sides[0].edge;
            if a == b {
                continue;
            }
            let mut found: Vec<u8> = sides.iter().map(|side| labels[side.face()] as u8).collect();
            found.sort_unstable();
            found.dedup();
            for (i, &p) in found.iter().enumerate() {
                segments.extend(
                    found[i + 1..].iter().map(|&r| Segment { regions: [p, r], ends: [a, b] }),
                );
            }
        }
        Contours::of_segments(segments, mesh.vertices.len(), |v| mesh.vertices[v as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::dual::Dual;
    use crate::samples::{assert_within, rng, shape, zoo};
    use ndarray::Array1;
    use rand::RngExt;

    /// The length of the cut is that which the labels pay for, on surfaces whose edges have two faces.
    #[test]
    fn the_cut_has_the_length_that_labels_pay_for() {
        let mut rng = rng(1201);
        for text in ["torus:12x9", "sphere:2", "grid:7x5"] {
            let mesh = shape(text);
            let labels: Array1<i32> =
                (0..mesh.faces.len()).map(|_| rng.random_range(0..3)).collect();
            let contours = Contours::between_faces(&mesh, labels.view());
            let dual = Dual::new(&mesh);
            let differ =
                |&(&[j, k], _): &(&[u32; 2], &f64)| labels[j as usize] != labels[k as usize];
            let paid: f64 =
                dual.pairs.iter().zip(&dual.weights).filter(differ).map(|(_, w)| w).sum();
            assert_within(contours.length(), paid, 1e-12, paid);
        }
    }

    /// Two halves of a grid have one straight cut; equal labels have none, on any mesh.
    #[test]
    fn a_straight_cut_is_one_polyline() {
        let mesh = shape("grid:6x4");
        let left = |j: usize| mesh.corners(j).iter().map(|x| x.x).sum::<f64>() / 3.0 < 0.5;
        let labels: Array1<i32> = (0..mesh.faces.len()).map(|j| i32::from(left(j))).collect();
        let contours = Contours::between_faces(&mesh, labels.view());
        assert_eq!(contours.polylines.len(), 1);
        assert!(!contours.polylines[0].is_closed());
        for (_, mesh) in zoo() {
            let labels = Array1::zeros(mesh.faces.len());
            assert!(Contours::between_faces(&mesh, labels.view()).polylines.is_empty());
        }
    }
}
