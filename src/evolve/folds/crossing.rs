//! Whether two triangles pass through each other.
//!
//! They do if an edge of one has its ends on different sides of the other and passes through it. Signs of determinants
//! within their rounding error count as 0, so that triangles that touch do not cross.
//!
//! Reference for the error bound: J. R. Shewchuk, *Adaptive precision floating-point arithmetic and fast robust
//! geometric predicates*, Discrete & Computational Geometry 18, 1997.

use nalgebra::Point3;

/// The relative error of the determinant, (7 + 56 u) u for u = 2^-53.
const ERROR: f64 = (7.0 + 56.0 * UNIT) * UNIT;
const UNIT: f64 = 0.5 * f64::EPSILON;

/// Whether the triangles have a common point and neither only touches the other.
pub fn cross(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3]) -> bool {
    any_edge_pierces(a, b) || any_edge_pierces(b, a)
}

fn any_edge_pierces(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3]) -> bool {
    let heights = a.map(|x| side(&b[0], &b[1], &b[2], &x));
    (0..3).any(|i| {
        let end = (i + 1) % 3;
        heights[i] * heights[end] < 0 && passes(&a[i], &a[end], b)
    })
}

/// Whether the line p q passes through a triangle, its border included.
fn passes(p: &Point3<f64>, q: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> bool {
    let signs = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    signs.iter().all(|&sign| sign >= 0) || signs.iter().all(|&sign| sign <= 0)
}

/// The sign of det(a - d, b - d, c - d); 0 if it is uncertain.
fn side(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, d: &Point3<f64>) -> i8 {
    let (a, b, c) = (a - d, b - d, c - d);
    let minors = [(b, c), (c, a), (a, b)].map(|(s, t)| (s.x * t.y, t.x * s.y));
    let heights = [a.z, b.z, c.z];
    let (mut determinant, mut size) = (0.0, 0.0);
    for ((plus, minus), height) in minors.into_iter().zip(heights) {
        determinant += height * (plus - minus);
        size += height.abs() * (plus.abs() + minus.abs());
    }
    if determinant.abs() <= ERROR * size || !determinant.is_normal() {
        0
    } else if determinant > 0.0 {
        1
    } else {
        -1
    }
}
