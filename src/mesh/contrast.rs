//! How much a cut along an edge costs, by what changes across it: less at creases, at edges of colors, or where given.
//!
//! ```text
//! normals    exp( -theta^2 / 2 sigma^2 )         theta the angle between the normals of the two faces, sigma = 30 degrees
//! colors     exp( -|c_j - c_k|^2 / 2 sigma^2 )   sigma^2 the mean of |c_j - c_k|^2 over all edges between known colors
//! faces      (w_j + w_k) / 2                     for given weights of faces
//! ```
//!
//! The first two are at least [`LEAST`], so that no cut is free. A face weighs the mean of its edges. Reference for
//! colors: C. Rother, V. Kolmogorov, A. Blake, *GrabCut*, ACM Transactions on Graphics 23(3), 2004.

use super::Mesh;
use super::dual::Dual;
use super::sides::Side;

/// The least weight by normals or colors.
pub const LEAST: f64 = 0.05;

/// sigma of normals, in radians.
const SIGMA: f64 = std::f64::consts::PI / 6.0;

/// What weights edges.
#[derive(Clone, Debug)]
pub enum Contrast {
    /// The angles between faces.
    Normals,
    /// RGB per face; NaN where unknown.
    Colors(Vec<[f64; 3]>),
    /// A positive weight per face.
    Faces(Vec<f64>),
}

impl Contrast {
    /// The faces of a mesh, joined with these weights times the lengths of edges.
    pub fn dual(&self, mesh: &Mesh) -> Dual {
        match self {
            Contrast::Normals => Dual::weighted(mesh, &|a, b| {
                let [one, other] = [a, b].map(|side| mesh.area_vector(side.face()));
                // Faces with the same orientation traverse their edge in opposite directions.
                let other = if a.ascends == b.ascends { -other } else { other };
                let cosine = one.dot(&other) / (one.norm() * other.norm());
                // NaN if a face has no area.
                let theta = if cosine.is_nan() { 0.0 } else { cosine.clamp(-1.0, 1.0).acos() };
                fallen(theta * theta, SIGMA * SIGMA)
            }),
            Contrast::Colors(colors) => {
                let square = |a: &Side, b: &Side| {
                    let [a, b] = [a, b].map(|side| colors[side.face()]);
                    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>()
                };
                let (mut sum, mut count) = (0.0, 0.0);
                Dual::new(mesh).pairs.iter().for_each(|&[j, k]| {
                    let [a, b] = [j, k].map(|j| colors[j as usize]);
                    let square: f64 = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
                    if !square.is_nan() {
                        sum += square;
                        count += 1.0;
                    }
                });
                let mean = sum / count;
                Dual::weighted(mesh, &|a, b| {
                    let square = square(a, b);
                    if mean > 0.0 && !square.is_nan() { fallen(square, mean) } else { 1.0 }
                })
            }
            Contrast::Faces(weights) => {
                Dual::weighted(mesh, &|a, b| 0.5 * (weights[a.face()] + weights[b.face()]))
            }
        }
    }

    /// The weight of each face of a mesh; 1 without neighbors.
    pub fn of_faces(&self, mesh: &Mesh) -> Vec<f64> {
        if let Contrast::Faces(weights) = self {
            return weights.clone();
        }
        let (plain, weighted) = (Dual::new(mesh), self.dual(mesh));
        let mut sums = vec![[0.0; 2]; mesh.faces.len()];
        for ((pair, length), weight) in plain.pairs.iter().zip(&plain.weights).zip(weighted.weights)
        {
            for &j in pair {
                sums[j as usize][0] += weight / length;
                sums[j as usize][1] += 1.0;
            }
        }
        sums.into_iter().map(|[sum, count]| if count > 0.0 { sum / count } else { 1.0 }).collect()
    }
}

fn fallen(square: f64, variance: f64) -> f64 {
    (-0.5 * square / variance).exp().max(LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{flipped, shape, zoo};
    use nalgebra::Point3;

    /// Two faces that meet at an angle.
    fn hinge(angle: f64) -> Mesh {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]];
        let mut vertices: Vec<Point3<f64>> = points.map(Point3::from).to_vec();
        vertices.push(Point3::new(0.5, -angle.cos(), angle.sin()));
        Mesh::new(vertices, vec![[0, 1, 2], [1, 0, 3]])
    }

    #[test]
    fn creases_are_cheap() {
        for (angle, expected) in [(0.0, 1.0), (SIGMA, (-0.5_f64).exp()), (2.5, LEAST)] {
            let mesh = hinge(angle);
            let dual = Contrast::Normals.dual(&mesh);
            assert!((dual.weights[0] - expected).abs() < 1e-12, "{angle}");
            // A flipped face changes nothing.
            let dual = Contrast::Normals.dual(&flipped(mesh.clone()));
            assert!((dual.weights[0] - expected).abs() < 1e-12, "{angle}, flipped");
            let of_faces = Contrast::Normals.of_faces(&mesh);
            assert!(of_faces.iter().all(|w| (w - expected).abs() < 1e-12));
        }
    }

    #[test]
    fn edges_of_colors_are_cheap() {
        let mesh = shape("grid:4x4");
        let left = |j: usize| mesh.corners(j).iter().all(|x| x.x <= 0.5);
        let colors = (0..mesh.faces.len()).map(|j| [f64::from(u8::from(left(j))), 0.2, 0.2]);
        let mut colors: Vec<[f64; 3]> = colors.collect();
        let (plain, dual) = (Dual::new(&mesh), Contrast::Colors(colors.clone()).dual(&mesh));
        for ((pair, plain), weight) in plain.pairs.iter().zip(&plain.weights).zip(&dual.weights) {
            let [a, b] = pair.map(|j| left(j as usize));
            assert!((weight < plain) == (a != b) && (weight == plain) == (a == b));
        }
        // Unknown colors, and colors that are all the same, weigh nothing.
        colors.fill([f64::NAN; 3]);
        assert_eq!(Contrast::Colors(colors.clone()).dual(&mesh).weights, plain.weights);
        colors.fill([0.5; 3]);
        assert_eq!(Contrast::Colors(colors).dual(&mesh).weights, plain.weights);
    }

    #[test]
    fn given_weights_scale_lengths() {
        for (name, mesh) in zoo() {
            let plain = Dual::new(&mesh);
            let dual = Contrast::Faces(vec![3.0; mesh.faces.len()]).dual(&mesh);
            assert_eq!(plain.pairs, dual.pairs, "{name}");
            let close = |(a, b): (&f64, &f64)| (3.0 * a - b).abs() <= 1e-14 * b;
            assert!(plain.weights.iter().zip(&dual.weights).all(close), "{name}");
        }
    }
}
