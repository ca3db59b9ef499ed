//! The direction of descent from the last gradients: the limited-memory BFGS method in a Sobolev metric.
//!
//! ```text
//! d = -H g
//! H <- (I - rho s y^T) H (I - rho y s^T) + rho s s^T      for the last pairs, the oldest first
//!   s = X_next - X,   y = g_next - g,   rho = 1 / <s, y>
//! from H = <s, y> / <y, P y> P with the last pair,   P = (I + beta L)^-1 of metric.rs
//! ```
//!
//! H y = s for the last pair: the step that it proposes has the length of a Newton step. Without pairs d is that of the
//! metric. H is positive definite, since only pairs with <s, y> > 0 are kept, so that d descends.
//!
//! Reference: D. C. Liu, J. Nocedal, *On the limited memory BFGS method for large scale optimization*, Mathematical
//! Programming 45, 1989.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::metric::Metric;

/// Pairs that are kept.
const MEMORY: usize = 8;

/// A pair says something of the curvature if <s, y> is more than this share of |s| |y|; less is the noise of sampled
/// gradients.
const MIN_COSINE: f64 = 1e-3;

/// s, y and rho.
struct Pair {
    s: Vec<Vector3<f64>>,
    y: Vec<Vector3<f64>>,
    rho: f64,
}

/// H of the last pairs.
#[derive(Default)]
pub struct QuasiNewton {
    pairs: VecDeque<Pair>,
}

impl QuasiNewton {
    /// Whether H is that of the metric alone.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Takes the motion of the vertices and the change of the gradient of one energy along it, if they have a curvature.
    pub fn add(&mut self, s: Vec<Vector3<f64>>, y: Vec<Vector3<f64>>) {
        let curvature = dot(&s, &y);
        if curvature > MIN_COSINE * (dot(&s, &s) * dot(&y, &y)).sqrt() {
            if self.pairs.len() == MEMORY {
                self.pairs.pop_front();
            }
            self.pairs.push_back(Pair { s, y, rho: 1.0 / curvature });
        }
    }

    /// d for the gradient g, one vector per vertex each.
    pub fn descend(&self, metric: &Metric, g: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut d: Vec<Vector3<f64>> = g.iter().map(|g| -g).collect();
        let mut of_pairs = Vec::with_capacity(self.pairs.len());
        for Pair { s, y, rho } in self.pairs.iter().rev() {
            let a = rho * dot(s, &d);
            add(&mut d, -a, y);
            of_pairs.push(a);
        }
        d = metric.smoothed(&d);
        if let Some(Pair { y, rho, .. }) = self.pairs.back() {
            let scale = 1.0 / (rho * dot(y, &metric.smoothed(y)));
            d.iter_mut().for_each(|d| *d *= scale);
        }
        for (Pair { s, y, rho }, a) in self.pairs.iter().zip(of_pairs.into_iter().rev()) {
            let b = rho * dot(y, &d);
            add(&mut d, a - b, s);
        }
        d
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// a + factor b.
fn add(a: &mut [Vector3<f64>], factor: f64, b: &[Vector3<f64>]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::samples::{random_vector, rng, shape};

    fn random(mesh: &Mesh, seed: u64) -> Vec<Vector3<f64>> {
        let mut rng = rng(seed);
        mesh.vertices.iter().map(|_| random_vector(&mut rng)).collect()
    }

    /// A g for a positive definite A: a diagonal of 1 to 3 beside three times the graph Laplacian.
    fn curved(mesh: &Mesh, g: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut product: Vec<Vector3<f64>> =
            g.iter().zip(0..).map(|(g, k)| f64::from(1 + k % 3) * g).collect();
        for &[a, b, c] in &mesh.faces {
            for [i, j] in [[a, b], [b, c], [c, a]].map(|ends| ends.map(|k| k as usize)) {
                let difference = 1.5 * (g[i] - g[j]);
                product[i] += difference;
                product[j] -= difference;
            }
        }
        product
    }

    #[test]
    fn without_pairs_the_metric_decides() {
        let mesh = shape("torus:9x7");
        let (metric, g) = (Metric::new(&mesh, 5.0), random(&mesh, 1));
        let d = QuasiNewton::default().descend(&metric, &g);
        let negative: Vec<_> = metric.smoothed(&g).iter().map(|d| -d).collect();
        assert_eq!(d, negative);
    }

    #[test]
    fn the_last_pair_is_reproduced_and_directions_descend() {
        let mesh = shape("torus:9x7");
        let metric = Metric::new(&mesh, 5.0);
        let mut newton = QuasiNewton::default();
        for seed in 0..2 * MEMORY as u64 {
            let s = random(&mesh, seed);
            let y = curved(&mesh, &s);
            newton.add(s.clone(), y.clone());
            for (d, s) in newton.descend(&metric, &y).iter().zip(&s) {
                assert!((d + s).norm() <= 1e-11, "{d} {s}");
            }
            let g = random(&mesh, 100 + seed);
            assert!(dot(&newton.descend(&metric, &g), &g) < 0.0);
        }
        assert_eq!(newton.pairs.len(), MEMORY);
    }

    #[test]
    fn pairs_without_a_positive_curvature_are_left_out() {
        let mesh = shape("torus:9x7");
        let s = random(&mesh, 1);
        let mut newton = QuasiNewton::default();
        newton.add(s.clone(), s.iter().map(|s| -s).collect());
        newton.add(s.clone(), vec![Vector3::zeros(); s.len()]);
        assert!(newton.is_empty());
    }

    /// In exact arithmetic a quadratic form needs at most as many steps as it has different eigenvalues in the metric;
    /// gradient descent needs far more.
    #[test]
    fn a_quadratic_form_is_minimized_faster_than_by_gradient_descent() {
        let mesh = shape("torus:9x7");
        let metric = Metric::new(&mesh, 0.0);
        let steps = |remembers: bool| {
            let mut x = random(&mesh, 3);
            let mut newton = QuasiNewton::default();
            let first = dot(&x, &curved(&mesh, &x));
            for step in 0..500 {
                let g = curved(&mesh, &x);
                if dot(&x, &g) <= 1e-10 * first {
                    return step;
                }
                let d = newton.descend(&metric, &g);
                let exact = -dot(&g, &d) / dot(&d, &curved(&mesh, &d));
                add(&mut x, exact, &d);
                if remembers {
                    let s: Vec<_> = d.iter().map(|d| exact * d).collect();
                    let y = curved(&mesh, &s);
                    newton.add(s, y);
                }
            }
            500
        };
        let (newton, gradient) = (steps(true), steps(false));
        assert!(2 * newton < gradient, "{newton} {gradient}");
    }
}
