//! The shape of single faces.

use nalgebra::{Point3, Vector3};

/// Twice the area vector of a face with these corners.
pub fn normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// 2 sqrt(3) |N| / (sum of the squared lengths of the edges), N as in [`normal`]: 1 for an equilateral face, 0 without area.
pub fn quality(corners: [Point3<f64>; 3]) -> f64 {
    let [a, b, c] = corners;
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if squares > 0.0 { 2.0 * 3.0_f64.sqrt() * normal(corners).norm() / squares } else { 0.0 }
}

/// Whether the angle between two vectors of positive length has at least this cosine.
pub fn within(a: &Vector3<f64>, b: &Vector3<f64>, cosine: f64) -> bool {
    let lengths = a.norm() * b.norm();
    lengths > 0.0 && a.dot(b) >= cosine * lengths
}
