//! Mean curvature as data: computed on the consistently oriented surface, mapped to [0, 1], unknown where it is
//! undefined.
//!
//! It is positive where the surface is convex as seen from outside. If the curvature varies no more than the rounding
//! of the coordinates explains, there is nothing to segment: stretching it to [0, 1] would only amplify noise.

use super::range::{median, robust_range, unit};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::curvature::{mean_curvature, rounding_noise};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::orient::{Oriented, orient};
use crate::mesh::{Mesh, resolution};
use crate::unreached::INHERIT;

/// The sign, in words.
pub const CURVATURE_SIGN: &str = "positive where the surface is convex as seen from outside";

/// Curvature as data.
pub struct Curved {
    /// V numbers in [0, 1], NaN where the curvature is undefined; all 0.5 if it varies by rounding only.
    pub values: Vec<f64>,
    /// The curvatures that are mapped to 0 and 1, in 1/length.
    pub range: [f64; 2],
    /// Warnings, one sentence each: flipped faces, pieces without an orientation, vertices without a curvature,
    /// constant curvature.
    pub warnings: Vec<String>,
}

/// The middle 96 % of normally distributed values span four standard deviations; a few repeated values span somewhat
/// more.
const NOISE_SPAN: f64 = 6.0;

/// Differences below this fraction of the curvature itself are rounding errors.
const CURVATURE_ROUNDING: f64 = 1e-6;

/// The mean curvature at the V vertices, clipped by 2 % at each end and mapped to [0, 1].
///
/// Fails if no vertex has a curvature.
pub fn curved(mesh: &Mesh) -> Result<Curved> {
    let Oriented { mesh: oriented, flipped, inconsistent_edges, open_patches } = orient(mesh);
    let curvature = mean_curvature(&oriented);
    if curvature.iter().all(|h| h.is_nan()) {
        return Err(Error::unsuitable(
            "no vertex of the mesh has a curvature: all lie on the boundary; subdivide the mesh (meshseg mesh convert \
             --subdivide 1) or use other data",
        ));
    }
    let mut warnings = Vec::new();
    if flipped > 0 {
        warnings.push(format!(
            "{flipped} of {} were flipped to compute the curvature, so that neighbors agree and closed surfaces face \
             outwards; written meshes keep the faces of the file",
            counted(oriented.faces.len(), "face", "faces")
        ));
    }
    if inconsistent_edges > 0 {
        warnings.push(format!(
            "faces disagree on which side is outside along {}, where the surface is one-sided or more than two faces \
             meet: the sign of the curvature is arbitrary there",
            counted(inconsistent_edges, "edge", "edges")
        ));
    }
    if open_patches > 1 {
        warnings.push(format!(
            "{open_patches} pieces of the surface are open, so it is unknown which of their sides is outside: the \
             sign of the curvature follows the orientation of their faces and may differ from piece to piece"
        ));
    }
    let unknown = unknown(&oriented, &curvature);
    if unknown > 0 {
        warnings.push(format!(
            "{}, because all neighbors lie on the boundary or there is no area: they are unknown; {INHERIT}",
            counted(unknown, "vertex has no curvature", "vertices have no curvature")
        ));
    }
    let area = barycentric_areas(&oriented);
    let [low, high] = robust_range(&curvature, &area);
    let noise = NOISE_SPAN * median(&rounding_noise(&oriented, resolution(mesh)), &area);
    let negligible = noise.max(CURVATURE_ROUNDING * low.abs().max(high.abs()));
    let values = if high - low <= negligible {
        warnings.push(format!(
            "the mean curvature is constant up to rounding ({:.6e}, within {negligible:.0e}): there is nothing \
             to segment",
            0.5 * (low + high)
        ));
        unit(&curvature, [0.0; 2])
    } else {
        unit(&curvature, [low, high])
    };
    Ok(Curved { values, range: [low, high], warnings })
}

/// The number of vertices of faces that have no curvature.
fn unknown(mesh: &Mesh, curvature: &[f64]) -> usize {
    let mut unknown = vec![false; curvature.len()];
    for &v in mesh.faces.iter().flatten() {
        unknown[v as usize] = curvature[v as usize].is_nan();
    }
    unknown.iter().filter(|&&unknown| unknown).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{bumpy, disjoint, random_rotation, rng, shape};
    use nalgebra::Point3;

    const NOTHING_TO_SEGMENT: &str = "there is nothing to segment";

    /// The mesh with its coordinates rounded as in a file.
    fn rounded(mut mesh: Mesh, round: impl Fn(f64) -> f64) -> Mesh {
        mesh.vertices.iter_mut().for_each(|x| *x = Point3::from(x.coords.map(&round)));
        mesh
    }

    /// A grid bent into a part of a tube of radius 1.
    fn tube(text: &str) -> Mesh {
        let mut mesh = shape(text);
        mesh.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x.cos(), x.x.sin(), x.y));
        mesh
    }

    #[test]
    fn planes_and_tubes_have_constant_curvature_in_any_number_format() {
        let mut rng = rng(5);
        let digits = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        for (name, mesh) in [("plane", shape("grid:40x30")), ("tube", tube("grid:30x20"))] {
            let turn = random_rotation(&mut rng);
            let flipped = |scale: f64| {
                let mut mesh = mesh.clone();
                mesh.vertices.iter_mut().for_each(|x| *x = turn * (*x * scale));
                mesh
            };
            for (kept, mesh) in [
                ("as it is", mesh.clone()),
                ("64 bits", flipped(1.0)),
                ("32 bits", rounded(flipped(1.0), |x| f64::from(x as f32))),
                ("6 decimals", rounded(flipped(1.0), digits(6))),
                ("small", rounded(flipped(1e-3), |x| f64::from(x as f32))),
                ("4 decimals of 1e4", rounded(flipped(1e4), digits(4))),
            ] {
                let curved = curved(&mesh).unwrap();
                assert!(
                    curved.warnings.iter().any(|w| w.contains(NOTHING_TO_SEGMENT)),
                    "{name}, {kept}"
                );
                assert!(curved.values.iter().all(|h| h.is_nan() || *h == 0.5), "{name}, {kept}");
            }
        }
    }

    #[test]
    fn other_shapes_have_varying_curvature_in_any_number_format() {
        let digits = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        let mut waves = shape("grid:60x40");
        waves.vertices.iter_mut().for_each(|x| x.z = 1e-3 * (9.0 * x.x).sin());
        let lattice = rounded(shape("sphere:4").scaled(20.0), f64::round);
        for mesh in [shape("torus:60x38"), bumpy(15), waves, lattice] {
            for mesh in [
                mesh.clone(),
                mesh.clone().scaled(1e4),
                rounded(mesh.clone(), |x| f64::from(x as f32)),
                rounded(mesh, digits(6)),
            ] {
                let curved = curved(&mesh).unwrap();
                assert!(
                    !curved.warnings.iter().any(|w| w.contains(NOTHING_TO_SEGMENT)),
                    "{:?}",
                    curved.warnings
                );
                let known = || curved.values.iter().copied().filter(|h| !h.is_nan());
                assert_eq!((known().fold(1.0, f64::min), known().fold(0.0, f64::max)), (0.0, 1.0));
            }
        }
    }

    /// The sign of a single open piece is a matter of convention; those of two pieces may contradict each other.
    #[test]
    fn open_pieces_are_counted() {
        let one = tube("grid:30x20");
        let mut other = one.clone();
        other.faces.iter_mut().for_each(|face| face.swap(1, 2));
        let open = |mesh: &Mesh| {
            let warnings = curved(mesh).unwrap().warnings;
            warnings.iter().any(|w| w.starts_with("2 pieces of the surface are open"))
        };
        assert!(open(&disjoint([one.clone(), other])));
        let closed = shape("sphere:3").scaled(0.5);
        assert!(!open(&disjoint([one.clone(), closed])) && !open(&one));
        // A tiny piece does not count.
        assert!(!open(&disjoint([one.clone(), one.scaled(0.01)])));
    }

    #[test]
    fn strips_have_no_curvature_and_corners_of_grids_are_unknown() {
        let error = curved(&tube("grid:30x1")).err().unwrap().to_string();
        assert!(error.starts_with("no vertex of the mesh has a curvature"), "{error}");
        // Two corners of a grid have only neighbors on the boundary; so have all vertices of the strip next to it.
        let curved = curved(&disjoint([bumpy(9), tube("grid:30x1")])).unwrap();
        let nan = curved.values.iter().filter(|h| h.is_nan()).count();
        assert_eq!(nan, 2 + 62);
        assert!(curved.warnings.iter().any(|w| w.starts_with("64 vertices have no curvature")));
    }
}
