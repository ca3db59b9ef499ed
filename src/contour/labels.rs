//! Labels of the vertices beside the cells of U: the length of their cut, and where they differ.

use ndarray::ArrayView1;

use super::cells::{Cells, SEVERAL, share};
use crate::mesh::Mesh;
use crate::mesh::geometry::opposite_edges;
use crate::sweep::sum;

/// The length of the cut that labels of the vertices describe: sum_j |(K U)_j| / sqrt 2 for their one-hot rows, in units of
/// the mesh.
///
/// With the edges e_i opposite to the corners, A_j grad phi_i has the length |e_i| / 2. Hence a face that separates corner i
/// from the others contributes |e_i| / 2, the length of its middle line, and one with three labels
/// (1/2) sqrt( (|e_0|^2 + |e_1|^2 + |e_2|^2) / 2 ).
pub fn cut_length(mesh: &Mesh, labels: ArrayView1<'_, i32>) -> f64 {
    sum(mesh.faces.len(), |j| {
        let [a, b, c] = mesh.faces[j].map(|v| labels[v as usize]);
        let edges = opposite_edges(mesh, j);
        match (a == b, b == c, c == a) {
            (true, true, _) => 0.0,
            (_, true, _) => 0.5 * edges[0].norm(),
            (_, _, true) => 0.5 * edges[1].norm(),
            (true, ..) => 0.5 * edges[2].norm(),
            _ => 0.5 * (0.5 * edges.iter().map(|e| e.norm_squared()).sum::<f64>()).sqrt(),
        }
    })
}

impl Cells<'_> {
    /// The share of the area in which the cells of U differ from those of the one-hot rows of labels; 0 without area.
    pub fn share_that_differs(&self, labels: ArrayView1<'_, i32>) -> f64 {
        let corners = |j: usize| self.mesh.faces[j].map(|v| labels[v as usize] as usize);
        let whole = sum(self.whole.len(), |j| {
            let (p, labels) = (usize::from(self.whole[j]), corners(j));
            if self.whole[j] == SEVERAL || labels == [p; 3] {
                return 0.0;
            }
            let face = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            self.mesh.face_area(j) * (1.0 - share(&clipped(&face, p, labels)))
        });
        let divided = sum(self.divided.len(), |i| {
            let face = &self.divided[i];
            let labels = corners(face.face);
            let equal = face.cells.iter().map(|cell| {
                let polygon = face.polygon(cell);
                share(&clipped(&polygon, cell.region, labels))
            });
            self.mesh.face_area(face.face) * (1.0 - equal.sum::<f64>()).max(0.0)
        });
        let area = self.mesh.area();
        if area > 0.0 { (whole + divided) / area } else { 0.0 }
    }
}

/// The part of a convex polygon where the label p of a face is the largest: o_p >= o_r for all r, where o_r is the sum of
/// the barycentric coordinates of the corners with label r.
fn clipped(polygon: &[[f64; 3]], p: usize, labels: [usize; 3]) -> Vec<[f64; 3]> {
    if !labels.contains(&p) {
        return Vec::new();
    }
    let mut polygon = polygon.to_vec();
    for (i, &r) in labels.iter().enumerate() {
        if r == p || labels[..i].contains(&r) {
            continue;
        }
        let of = |x: &[f64; 3], q: usize| -> f64 {
            (0..3).filter(|&i| labels[i] == q).map(|i| x[i]).sum()
        };
        let excess = |x: &[f64; 3]| of(x, p) - of(x, r);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, x) in polygon.iter().enumerate() {
            let y = &polygon[(i + 1) % polygon.len()];
            let (a, b) = (excess(x), excess(y));
            if a >= 0.0 {
                kept.push(*x);
            }
            if a * b < 0.0 {
                let t = a / (a - b);
                kept.push([0, 1, 2].map(|i| x[i] + t * (y[i] - x[i])));
            }
        }
        polygon = kept;
    }
    polygon
}
