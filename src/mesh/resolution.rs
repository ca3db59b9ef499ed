//! How finely the coordinates of a mesh are rounded, as their numbers show it.
//!
//! Files keep 32 bits, or six digits, of what was computed, and a curvature of such coordinates carries their
//! rounding: an error delta of a vertex moves H by about delta / h^2 where edges have length h.

use super::Mesh;

/// Coarser steps than this share of the largest coordinate are where vertices were put, not rounding: cells of a
/// grid, voxels, whole meters.
const COARSEST_ROUNDING: f64 = 1e-5;

/// delta: half the step between neighboring coordinates, about at the largest of them: the coarsest of those that
/// numbers with 64 and 32 bits have, with a fixed number of decimals, and with a fixed number of digits.
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
    // With as many digits as double precision has, all numbers would seem to be multiples.
    // Where the largest is a power of ten, all others lie in the decade below.
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
    fn rounding_is_found_by_the_numbers() {
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

    /// What lies on a lattice was put there.
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
