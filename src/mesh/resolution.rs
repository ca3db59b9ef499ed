//! The rounding of the coordinates of a mesh, detected from their values.
//!
//! Files store coordinates with 32 bits or six digits, and curvature amplifies this rounding: an error delta of a
//! vertex changes H by about delta / h^2 where edges have length h.

use super::Mesh;

/// Steps coarser than this fraction of the largest coordinate are positions on purpose, not rounding: cells of a grid,
/// voxels, whole meters.
const COARSEST_ROUNDING: f64 = 1e-5;

/// delta: half the step between adjacent coordinate values near the largest coordinate, for the coarsest matching
/// format: 64 bits, 32 bits, a fixed number of decimals, or a fixed number of digits.
pub fn resolution(mesh: &Mesh) -> f64 {
    let coordinates = || mesh.vertices.iter().flat_map(|x| [x.x, x.y, x.z]);
    let largest = coordinates().fold(0.0, |largest, x: f64| x.abs().max(largest));
    if largest == 0.0 {
        return 0.0;
    }
    let bits = if coordinates().all(|x| f64::from(x as f32) == x) { 24 } else { 53 };
    let binary = 0.5 * largest * 2.0_f64.powi(1 - bits);
    let digits_before_point = |x: f64| x.abs().log10().floor() as i32 + 1;
    let fixed = |decimals: i32| coordinates().all(|x| is_multiple(x, -decimals));
    let significant = |digits: i32| {
        coordinates().all(|x| x == 0.0 || is_multiple(x, digits_before_point(x) - digits))
    };
    // With the digits of double precision, every number would look like a multiple. If the largest is a power of ten,
    // all others are in the decade below.
    let power = |digits: i32| largest.log10().ceil() as i32 - digits;
    let coarsest = |rounded: &dyn Fn(i32) -> bool| (1..=13).find(|&digits| rounded(digits));
    let decimal = [coarsest(&|digits| fixed(-power(digits))), coarsest(&significant)];
    let steps = decimal.into_iter().flatten().map(|digits| 0.5 * 10.0_f64.powi(power(digits)));
    steps.filter(|step| *step <= COARSEST_ROUNDING * largest).fold(binary, f64::max)
}

/// Whether x is a multiple of a power of ten, up to the rounding of double precision.
fn is_multiple(x: f64, power: i32) -> bool {
    let multiple = if power > 0 { x / 10.0_f64.powi(power) } else { x * 10.0_f64.powi(-power) };
    (multiple - multiple.round()).abs() <= 4.0 * f64::EPSILON * multiple.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{bumpy, rng, shape};
    use nalgebra::Point3;

    fn rounded(round: impl Fn(f64) -> f64) -> Mesh {
        let mut mesh = bumpy(20);
        mesh.vertices.iter_mut().for_each(|x| *x = Point3::from(x.coords.map(&round)));
        mesh
    }

    #[test]
    fn rounding_is_detected_from_the_values() {
        let text = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        let scientific =
            |digits: usize| move |x: f64| format!("{x:.*e}", digits - 1).parse().unwrap();
        let largest = rounded(|x| x).vertices.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
        assert!((1.0..2.0).contains(&largest));
        for (mesh, delta) in [
            (rounded(|x| x), largest * 2.0_f64.powi(-53)),
            (rounded(|x| f64::from(x as f32)), largest * 2.0_f64.powi(-24)),
            (rounded(text(6)), 5e-7),
            (rounded(text(9)), 5e-10),
            (rounded(scientific(6)), 5e-6),
            (rounded(scientific(9)), 5e-9),
        ] {
            let found = resolution(&mesh);
            assert!((found / delta - 1.0).abs() < 1e-6, "{found:e} is not {delta:e}");
        }
    }

    /// Points on a lattice are not rounded.
    #[test]
    fn lattices_are_exact() {
        for text in ["grid:10x10", "grid:8x5"] {
            let mesh = shape(text);
            assert!(resolution(&mesh) <= 2.0_f64.powi(-24));
        }
        let voxels = shape("grid:10x10").scaled(10.0);
        assert!(resolution(&voxels) <= 10.0 * 2.0_f64.powi(-24));
        assert_eq!(resolution(&Mesh::default()), 0.0);
        let mut one = shape("grid:2x2");
        let (mesh, _) = crate::samples::shuffled(&one, &mut rng(3));
        assert_eq!(resolution(&mesh), resolution(&one));
        one.vertices.clear();
        assert_eq!(resolution(&one), 0.0);
    }
}
