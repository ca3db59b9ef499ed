//! The length of the cuts, TV(U) = sum_j |(K U)_j|, and its gradient with respect to the vertices for fixed U.
//!
//! ```text
//! e2 = x2 - x1,   e3 = x3 - x1,   ua = u2 - u1,   ub = u3 - u1
//! r_p = ua_p e3 - ub_p e2,   n = sqrt( sum_p |r_p|^2 ),   |(K U)_j| = n / 2
//! d/de3 = sum_p ua_p r_p / (2n),   d/de2 = - sum_p ub_p r_p / (2n);   n = 0 gives 0
//! ```
//!
//! The sums over p need only |ua|^2, ua.ub and |ub|^2, which do not change while the surface moves.

use nalgebra::Vector3;

use super::coloring::Coloring;
use crate::mesh::Mesh;
use crate::sweep;

/// |ua|^2, ua.ub and |ub|^2 of each face.
pub struct Contrasts(Vec<[f64; 3]>);

impl Contrasts {
    /// Those of labels on the faces of a mesh.
    pub fn new(mesh: &Mesh, coloring: &Coloring) -> Self {
        let m = coloring.regions();
        let of_face = |j: usize| {
            let [u1, u2, u3] = mesh.faces[j].map(|k| &coloring.u[k as usize * m..][..m]);
            let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
            for p in 0..m {
                let (a, b) = (u2[p] - u1[p], u3[p] - u1[p]);
                aa += a * a;
                ab += a * b;
                bb += b * b;
            }
            [aa, ab, bb]
        };
        Contrasts(sweep::collect(mesh.faces.len(), of_face))
    }

    /// TV(U).
    pub fn total_variation(&self, mesh: &Mesh) -> f64 {
        sweep::sum(self.0.len(), |j| self.face(mesh, j).map_or(0.0, |face| 0.5 * face.n))
    }

    /// Adds lambda times the gradient.
    pub fn add_gradient(&self, mesh: &Mesh, lambda: f64, gradient: &mut [Vector3<f64>]) {
        for (j, corners) in mesh.faces.iter().enumerate() {
            let Some(Cut { e2, e3, n }) = self.face(mesh, j) else { continue };
            let [aa, ab, bb] = self.0[j];
            let c = lambda / (2.0 * n);
            let d3 = c * (aa * e3 - ab * e2);
            let d2 = -c * (ab * e3 - bb * e2);
            let [k1, k2, k3] = corners.map(|k| k as usize);
            gradient[k1] -= d2 + d3;
            gradient[k2] += d2;
            gradient[k3] += d3;
        }
    }

    /// The cut in face j, if there is one.
    #[inline(always)]
    fn face(&self, mesh: &Mesh, j: usize) -> Option<Cut> {
        let [aa, ab, bb] = self.0[j];
        if aa == 0.0 && bb == 0.0 {
            return None;
        }
        let [x1, x2, x3] = mesh.corners(j);
        let (e2, e3) = (x2 - x1, x3 - x1);
        let squared = aa * e3.norm_squared() - 2.0 * ab * e2.dot(&e3) + bb * e2.norm_squared();
        (squared > 0.0).then(|| Cut { e2, e3, n: squared.sqrt() })
    }
}

struct Cut {
    e2: Vector3<f64>,
    e3: Vector3<f64>,
    n: f64,
}
