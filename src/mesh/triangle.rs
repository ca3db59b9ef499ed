//! The point of a triangle that is nearest to another point.

use nalgebra::Point3;

/// Barycentric coordinates of the point of a triangle nearest to x. Reference: C. Ericson, *Real-time collision
/// detection*, 2005, section 5.1.5.
pub fn nearest_weights(x: Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (ax, bx, cx) = (x - a, x - b, x - c);
    let (d1, d2) = (ab.dot(&ax), ac.dot(&ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(&bx), ac.dot(&bx));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let (d5, d6) = (ab.dot(&cx), ac.dot(&cx));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    // Rounding may make one slightly negative.
    let weights = [va, vb, vc].map(|w| f64::max(w, 0.0));
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}
