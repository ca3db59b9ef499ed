//! Mean curvature as data: of the surface with one side out, in [0, 1], unknown where there is none.
//!
//! It is positive where the surface is convex as seen from outside. A surface whose curvature varies no more than
//! the rounding of its coordinates lets it has nothing to segment: what would be stretched to [0, 1] is noise.

use super::range::{median, robust_range, unit};
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
    /// V numbers in [0, 1], or NaN where there is no curvature; all 0.5 where only rounding makes a difference.
    pub values: Vec<f64>,
    /// The curvatures that 0 and 1 stand for, in 1/length.
    pub range: [f64; 2],
    /// What the user should know, a sentence each: faces that were turned, pieces without an orientation, vertices
    /// without a curvature, constant curvature.
    pub warnings: Vec<String>,
}

/// The middle 96 % of the values of normal noise span four deviations, of a few values repeated somewhat more.
const NOISE_SPAN: f64 = 6.0;

/// Differences below this share of the curvature itself are rounding.
const CURVATURE_ROUNDING: f64 = 1e-6;

/// The mean curvature at the V vertices, of which the extreme 2 % at each end are cut off, mapped to [0, 1].
///
/// Fails if no vertex has a curvature.
pub fn curved(mesh: &Mesh) -> Result<Curved> {
    let Oriented { mesh: oriented, turned, inconsistent_edges, open_patches } = orient(mesh);
    let curvature = mean_curvature(&oriented);
    if curvature.iter().all(|h| h.is_nan()) {
        return Err(Error::unsuitable(
            "no vertex of the mesh has a curvature: all lie on the boundary; subdivide it (meshseg mesh convert \
             --subdivide 1) or use other data",
        ));
    }
    let mut warnings = Vec::new();
    if turned > 0 {
        warnings.push(format!(
            "{turned} of {} faces were turned for the curvature, so that neighbors agree and closed surfaces face \
             outwards; what is written keeps the faces of the file",
            oriented.faces.len()
        ));
    }
    if inconsistent_edges > 0 {
        warnings.push(format!(
            "faces disagree on which side is outside along {inconsistent_edges} edges, where the surface has one \
             side only or more than two faces meet: the sign of the curvature is arbitrary there"
        ));
    }
    if open_patches > 1 {
        warnings.push(format!(
            "{open_patches} pieces of the surface are open, and nothing says which of their sides is outside: the \
             sign of the curvature is that of their faces, and may differ from piece to piece"
        ));
    }
    let unknown = unknown(&oriented, &curvature);
    if unknown > 0 {
        warnings.push(format!(
            "{unknown} vertices have no curvature, since all their neighbors lie on the boundary or they have no \
             area: they are unknown; {INHERIT}"
        ));
    }
    let area = barycentric_areas(&oriented);
    let [low, high] = robust_range(&curvature, &area);
    let noise = NOISE_SPAN * median(&rounding_noise(&oriented, resolution(mesh)), &area);
    let negligible = noise.max(CURVATURE_ROUNDING * low.abs().max(high.abs()));
    let values = if high - low <= negligible {
        warnings.push(format!(
            "the mean curvature is the same everywhere to rounding ({:.6e}, up to {negligible:.0e}): there is nothing \
             to segment",
            0.5 * (low + high)
        ));
        unit(&curvature, [0.0; 2])
    } else {
        unit(&curvature, [low, high])
    };
    Ok(Curved { values, range: [low, high], warnings })
}

/// How many vertices of faces have no curvature.
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

    const NOTHING: &str = "there is nothing to segment";

    /// The coordinates of a mesh as a file keeps them.
    fn rounded(mut mesh: Mesh, round: impl Fn(f64) -> f64) -> Mesh {
        mesh.vertices.iter_mut().for_each(|x| *x = Point3::from(x.coords.map(&round)));
        mesh
    }

    /// A grid bent to a part of a tube of radius 1.
    fn tube(text: &str) -> Mesh {
        let mut mesh = shape(text);
        mesh.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x.cos(), x.x.sin(), x.y));
        mesh
    }

    #[test]
    fn planes_and_tubes_have_nothing_but_rounding_however_they_are_kept() {
        let mut rng = rng(5);
        let digits = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        for (name, mesh) in [("plane", shape("grid:40x30")), ("tube", tube("grid:30x20"))] {
            let turn = random_rotation(&mut rng);
            let turned = |scale: f64| {
                let mut mesh = mesh.clone();
                mesh.vertices.iter_mut().for_each(|x| *x = turn * (*x * scale));
                mesh
            };
            for (kept, mesh) in [
                ("as it is", mesh.clone()),
                ("64 bits", turned(1.0)),
                ("32 bits", rounded(turned(1.0), |x| f64::from(x as f32))),
                ("6 decimals", rounded(turned(1.0), digits(6))),
                ("small", rounded(turned(1e-3), |x| f64::from(x as f32))),
                ("4 decimals of 1e4", rounded(turned(1e4), digits(4))),
            ] {
                let curved = curved(&mesh).unwrap();
                assert!(curved.warnings.iter().any(|w| w.contains(NOTHING)), "{name}, {kept}");
                assert!(curved.values.iter().all(|h| h.is_nan() || *h == 0.5), "{name}, {kept}");
            }
        }
    }

    #[test]
    fn shapes_have_something_however_they_are_kept() {
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
                    !curved.warnings.iter().any(|w| w.contains(NOTHING)),
                    "{:?}",
                    curved.warnings
                );
                let known = || curved.values.iter().copied().filter(|h| !h.is_nan());
                assert_eq!((known().fold(1.0, f64::min), known().fold(0.0, f64::max)), (0.0, 1.0));
            }
        }
    }

    /// One open piece has a sign that is as good as the other; of two, nothing says that they agree.
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
        // A crumb is no piece.
        assert!(!open(&disjoint([one.clone(), one.scaled(0.01)])));
    }

    #[test]
    fn strips_have_none_and_their_ends_are_unknown() {
        let error = curved(&tube("grid:30x1")).err().unwrap().to_string();
        assert!(error.starts_with("no vertex of the mesh has a curvature"), "{error}");
        // Two corners of a grid have neighbors on the boundary only; a strip beside it has nothing else.
        let curved = curved(&disjoint([bumpy(9), tube("grid:30x1")])).unwrap();
        let nan = curved.values.iter().filter(|h| h.is_nan()).count();
        assert_eq!(nan, 2 + 62);
        assert!(curved.warnings.iter().any(|w| w.starts_with("64 vertices have no curvature")));
    }
}
