//! The gradient in a Sobolev metric.
//!
//! ```text
//! P g = (I + beta L)^-1 g        L = D - A: degrees and adjacency of the vertices
//! ```
//!
//! L does not depend on positions, so that I + beta L is factored once per connectivity. A translation passes
//! unchanged, and noise of neighboring vertices is damped by 1 / (1 + beta times an eigenvalue of L). -P g descends, since
//! the matrix is positive definite.
//!
//! Reference: G. Sundaramoorthi, A. Yezzi, A. Mennucci, *Sobolev active contours*, IJCV 73(3), 2007.

use nalgebra::Vector3;
use sprs::TriMat;

use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::sides::{edges, sides};
use crate::operator::Cholesky;

/// A larger beta leaves hardly any direction but translations, and no digits.
pub const MAX_BETA: f64 = 1e9;

/// I + beta L of a mesh, factored.
pub struct Metric(Cholesky);

impl Metric {
    /// The metric of the edges of a mesh, each once. beta = 0 is the metric of L2 at the vertices.
    ///
    /// # Panics
    /// beta is not from 0 to 1e9.
    pub fn new(mesh: &Mesh, beta: f64) -> Self {
        assert!((0.0..=MAX_BETA).contains(&beta), "beta = {beta}");
        let n = mesh.vertices.len();
        let mut diagonal = vec![1.0; n];
        let mut matrix = TriMat::new((n, n));
        for edge in edges(&sides(&mesh.faces)) {
            let [a, b] = edge[0].edge.map(|k| k as usize);
            if a != b {
                diagonal[a] += beta;
                diagonal[b] += beta;
                matrix.add_triplet(a, b, -beta);
                matrix.add_triplet(b, a, -beta);
            }
        }
        diagonal.iter().enumerate().for_each(|(k, &d)| matrix.add_triplet(k, k, d));
        Metric(Cholesky::new(&matrix.to_csr()).expect("I + beta L is positive definite"))
    }

    /// P g, one vector per vertex each.
    ///
    /// # Panics
    /// The number of vectors is not that of the vertices.
    pub fn smoothed(&self, g: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut d: Vec<Row<3>> = g.iter().map(|&g| Row(g.into())).collect();
        self.0.solve(&mut d);
        d.into_iter().map(|Row(d)| d.into()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_vector, rng, shape, zoo};
    use nalgebra::DMatrix;

    fn random(mesh: &Mesh, seed: u64) -> Vec<Vector3<f64>> {
        let mut rng = rng(seed);
        mesh.vertices.iter().map(|_| random_vector(&mut rng)).collect()
    }

    /// I + beta L from the neighbors of each pair of vertices.
    fn dense(mesh: &Mesh, beta: f64) -> DMatrix<f64> {
        let n = mesh.vertices.len();
        let joined = |a: usize, b: usize| {
            let has = |face: &[u32; 3], k: usize| face.contains(&(k as u32));
            a != b && mesh.faces.iter().any(|face| has(face, a) && has(face, b))
        };
        let adjacency = DMatrix::from_fn(n, n, |a, b| f64::from(joined(a, b)));
        let degrees = DMatrix::from_diagonal(&adjacency.column_sum());
        DMatrix::identity(n, n) + beta * (degrees - adjacency)
    }

    #[test]
    fn smoothed_gradients_solve_the_dense_system() {
        for (name, mesh) in zoo() {
            for beta in [0.5, 20.0] {
                let g = random(&mesh, 3);
                let d = Metric::new(&mesh, beta).smoothed(&g);
                let matrix = dense(&mesh, beta);
                for i in 0..3 {
                    let column = |rows: &[Vector3<f64>]| {
                        DMatrix::from_iterator(rows.len(), 1, rows.iter().map(|row| row[i]))
                    };
                    let residual = (&matrix * column(&d) - column(&g)).amax();
                    assert!(residual <= 1e-12, "{name} {beta}: {residual}");
                }
            }
        }
    }

    #[test]
    fn translations_pass_unchanged() {
        for (name, mesh) in zoo() {
            let g = Vector3::new(1.0, -2.0, 0.5);
            for d in Metric::new(&mesh, 50.0).smoothed(&vec![g; mesh.vertices.len()]) {
                let error = (d - g).amax();
                assert!(error <= 1e-12, "{name}: {error}");
            }
        }
    }

    #[test]
    fn beta_0_is_the_gradient() {
        let mesh = shape("torus:9x7");
        let g = random(&mesh, 5);
        assert_eq!(Metric::new(&mesh, 0.0).smoothed(&g), g);
    }

    #[test]
    fn smoothed_gradients_ascend_and_are_smooth() {
        for (name, mesh) in zoo() {
            for (seed, beta) in (0..).zip([0.0, 1.0, 20.0, 1e4]) {
                let g = random(&mesh, seed);
                let d = Metric::new(&mesh, beta).smoothed(&g);
                let product = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
                    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
                };
                assert!(product(&g, &d) > 0.0, "{name}");
                assert!(product(&d, &d) <= product(&g, &g) * (1.0 + 1e-12), "{name}");
            }
        }
    }
}
