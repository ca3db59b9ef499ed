//! Gaussian curvature at the vertices by the angle defect (M. Meyer, M. Desbrun, P. Schröder, A. Barr, *Discrete
//! Differential-Geometry Operators for Triangulated 2-Manifolds*, 2003, equation 9):
//!
//! ```text
//! K_v = (2 pi - sum over the faces at v of the angle theta at v) / a_v
//! ```
//!
//! with the mixed Voronoi areas a_v. On a closed surface the defects sum to 2 pi chi (Gauss-Bonnet). K does not depend
//! on the side of the surface. With x_i, x_{i+1} the corners of a face next to v, a = x_i - x_v, b = x_{i+1} - x_v and
//! the normal n, an angle changes by
//!
//! ```text
//! d theta = < -n x a / |a|^2, dx_i - dx_v > + < n x b / |b|^2, dx_{i+1} - dx_v >
//! ```
//!
//! which cancels where the surface is flat. There, heights z change it by
//!
//! ```text
//! cot theta / 2 ((z_i - z_v)^2 / |a|^2 + (z_{i+1} - z_v)^2 / |b|^2) - (z_i - z_v) (z_{i+1} - z_v) / |a x b|
//! ```

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::fan::{at_fans, links};
use crate::mesh::Mesh;
use crate::mesh::geometry::mixed_voronoi_areas;

/// The rounding error of a computed angle, and of the sum of a few, in radians.
const ANGLE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// K at the V vertices and its standard deviation if coordinates are rounded by up to delta, both in 1/length^2.
///
/// The formula is valid where the faces form one closed fan. Other vertices, such as those on the boundary, take the
/// mean of their neighbors that have one; K is NaN if there are none.
pub fn gaussian_curvature(mesh: &Mesh, delta: f64) -> Vec<[f64; 2]> {
    let (mesh, _) = mesh.without_degenerate_faces();
    let area = mixed_voronoi_areas(&mesh);
    // The standard deviation of a number that is uniformly distributed between -delta and delta.
    let deviation = delta / 3.0_f64.sqrt();
    at_fans(mesh.vertices.len(), &links(&mesh), || {
        let mut defect = Defect::default();
        let (mesh, area) = (&mesh, &area);
        move |v, ring| {
            let x = mesh.vertices[v];
            let edges = ring.iter().map(|&k| mesh.vertices[k as usize] - x);
            defect.at(edges, deviation).map(|defect| defect / area[v])
        }
    })
}

/// The angle defect of one vertex, and what its deviation is computed from.
#[derive(Default)]
struct Defect {
    edges: Vec<Vector3<f64>>,
    /// The derivative of the sum of the angles by each neighbor.
    gradient: Vec<Vector3<f64>>,
    /// The quadratic form of the heights where the surface is flat: its diagonal, and the entry of each neighbor and
    /// the next.
    diagonal: Vec<f64>,
    next: Vec<f64>,
}

impl Defect {
    /// The defect, and its standard deviation if each coordinate has the given one.
    fn at(&mut self, edges: impl Iterator<Item = Vector3<f64>>, deviation: f64) -> [f64; 2] {
        self.edges.clear();
        self.edges.extend(edges);
        let n = self.edges.len();
        for (list, zero) in [(&mut self.diagonal, 0.0), (&mut self.next, 0.0)] {
            list.clear();
            list.resize(n, zero);
        }
        self.gradient.clear();
        self.gradient.resize(n, Vector3::zeros());
        let mut defect = TAU;
        for i in 0..n {
            let (a, b) = (self.edges[i], self.edges[(i + 1) % n]);
            let cross = a.cross(&b);
            let (sin, cos) = (cross.norm(), a.dot(&b));
            defect -= sin.atan2(cos);
            let normal = cross / sin;
            let (aa, bb) = (a.norm_squared(), b.norm_squared());
            self.gradient[i] -= normal.cross(&a) / aa;
            self.gradient[(i + 1) % n] += normal.cross(&b) / bb;
            self.diagonal[i] += 0.5 * cos / sin / aa;
            self.diagonal[(i + 1) % n] += 0.5 * cos / sin / bb;
            self.next[i] = -0.5 / sin;
        }
        let variance = deviation.powi(2);
        let squared = variance * self.first_order() + 2.0 * variance.powi(2) * self.second_order();
        [defect, (squared + n as f64 * ANGLE_ROUNDING.powi(2)).sqrt()]
    }

    /// The variance to first order, for coordinates of variance 1. The derivative by the vertex itself is minus the sum.
    fn first_order(&self) -> f64 {
        let sum: Vector3<f64> = self.gradient.iter().sum();
        sum.norm_squared() + self.gradient.iter().map(Vector3::norm_squared).sum::<f64>()
    }

    /// The squared Frobenius norm of the quadratic form, its rows for the vertex itself included.
    fn second_order(&self) -> f64 {
        let n = self.edges.len();
        let (mut squares, mut total) = (0.0, 0.0);
        for i in 0..n {
            let row = self.diagonal[i] + self.next[i] + self.next[(i + n - 1) % n];
            squares += self.diagonal[i].powi(2) + 2.0 * self.next[i].powi(2) + 2.0 * row.powi(2);
            total += row;
        }
        squares + total * total
    }
}
