//! Curvature as data: computed on the consistently oriented surface, mapped to [0, 1], unknown where it is undefined.
//!
//! Mean curvature and shape index are positive where the surface is convex as seen from outside; Gaussian curvature
//! needs no side. If the curvature varies no more than the rounding of the coordinates explains, there is nothing to
//! segment: stretching it to [0, 1] would only amplify noise.

use super::range::{median, robust_range, unit};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::curvature::{self, Curvature, CurvatureKind};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::orient::{Oriented, orient};
use crate::mesh::{Mesh, resolution};
use crate::unreached::INHERIT;

/// Curvature as data.
pub struct Curved {
    /// V numbers in [0, 1], NaN where the curvature is undefined; all 0.5 if it varies by rounding only.
    pub values: Vec<f64>,
    /// The curvatures that are mapped to 0 and 1, in the unit of their kind.
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

/// The range of the shape index.
const SHAPE_INDEX_RANGE: [f64; 2] = [-1.0, 1.0];

/// The curvature at the V vertices, mapped to [0, 1]: the shape index from [-1, 1], others clipped by 2 % at each end.
///
/// Fails if no vertex has a curvature.
pub fn curved(mesh: &Mesh, kind: CurvatureKind) -> Result<Curved> {
    let oriented = orient(mesh);
    let surface = &oriented.mesh;
    let Curvature { values: curvature, noise, flat } =
        curvature::at_vertices(surface, kind, resolution(mesh));
    if curvature.iter().all(|h| h.is_nan()) {
        return Err(none(kind, flat));
    }
    let mut warnings = Vec::new();
    if kind.sign().is_some() {
        warnings.extend(side_warnings(&oriented));
    }
    warnings.extend(unknown_warnings(surface, kind, &curvature, flat));
    let area = barycentric_areas(surface);
    let [low, high] = robust_range(&curvature, &area);
    let negligible =
        (NOISE_SPAN * median(&noise, &area)).max(CURVATURE_ROUNDING * low.abs().max(high.abs()));
    let range = if kind == CurvatureKind::ShapeIndex { SHAPE_INDEX_RANGE } else { [low, high] };
    let values = if high - low <= negligible {
        warnings.push(format!(
            "the {} is constant up to rounding ({:.6e}, within {negligible:.0e}): there is nothing to segment",
            kind.words(),
            0.5 * (low + high)
        ));
        unit(&curvature, [0.0; 2])
    } else {
        unit(&curvature, range)
    };
    Ok(Curved { values, range, warnings })
}

/// The error if no vertex has a curvature.
fn none(kind: CurvatureKind, flat: usize) -> Error {
    let subdivide = "subdivide the mesh (meshseg mesh convert --subdivide 1)";
    Error::unsuitable(match kind {
        _ if flat > 0 => "no vertex of the mesh has a shape index: the surface is flat up to the rounding of its \
                          coordinates; use other data"
            .into(),
        CurvatureKind::Mean | CurvatureKind::Gaussian => format!(
            "no vertex of the mesh has a curvature: all lie on the boundary; {subdivide} or use other data"
        ),
        CurvatureKind::MeanQuadric | CurvatureKind::ShapeIndex => format!(
            "no vertex of the mesh has a curvature: all lie on the boundary, or too few vertices around them \
             determine a quadric; {subdivide}, or use --data curvature or other data"
        ),
    })
}

/// Warnings about the sides of the surface, on which the sign depends.
fn side_warnings(oriented: &Oriented) -> Vec<String> {
    let &Oriented { mesh: ref oriented, flipped, inconsistent_edges, open_patches } = oriented;
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
    warnings
}

/// Warnings about the vertices of faces that have no curvature.
fn unknown_warnings(
    mesh: &Mesh,
    kind: CurvatureKind,
    curvature: &[f64],
    flat: usize,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if flat > 0 {
        warnings.push(format!(
            "{} flat up to the rounding of the coordinates and {} no shape index: they are unknown; {INHERIT}",
            counted(flat, "vertex is", "vertices are"),
            if flat == 1 { "has" } else { "have" }
        ));
    }
    let others = unknown(mesh, curvature) - flat;
    if others > 0 {
        let reason = match kind {
            CurvatureKind::Mean | CurvatureKind::Gaussian => {
                "all neighbors lie on the boundary or there is no area"
            }
            CurvatureKind::MeanQuadric | CurvatureKind::ShapeIndex => {
                "all neighbors lie on the boundary or too few vertices around determine a quadric"
            }
        };
        warnings.push(format!(
            "{}, because {reason}: they are unknown; {INHERIT}",
            counted(others, "vertex has no curvature", "vertices have no curvature")
        ));
    }
    warnings
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
    use crate::names::Named;
    use crate::samples::{bumpy, disjoint, random_rotation, rng, shape};
    use nalgebra::Point3;
    use std::f64::consts::TAU;

    fn mean(mesh: &Mesh) -> Result<Curved> {
        curved(mesh, CurvatureKind::Mean)
    }

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

    /// The mesh turned, and in files of several formats.
    fn in_formats(mesh: &Mesh) -> Vec<(&'static str, Mesh)> {
        let digits = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        let turn = random_rotation(&mut rng(5));
        let turned = |scale: f64| {
            let mut mesh = mesh.clone();
            mesh.vertices.iter_mut().for_each(|x| *x = turn * (*x * scale));
            mesh
        };
        vec![
            ("as it is", mesh.clone()),
            ("64 bits", turned(1.0)),
            ("32 bits", rounded(turned(1.0), |x| f64::from(x as f32))),
            ("6 decimals", rounded(turned(1.0), digits(6))),
            ("small", rounded(turned(1e-3), |x| f64::from(x as f32))),
            ("4 decimals of 1e4", rounded(turned(1e4), digits(4))),
        ]
    }

    fn assert_constant(mesh: &Mesh, kind: CurvatureKind, name: &str) {
        let curved = curved(mesh, kind).unwrap();
        let constant = |w: &String| w.contains(NOTHING_TO_SEGMENT) && w.contains(kind.words());
        assert!(curved.warnings.iter().any(constant), "{name} {kind:?} {:?}", curved.range);
        assert!(curved.values.iter().all(|h| h.is_nan() || *h == 0.5), "{name} {kind:?}");
    }

    #[test]
    fn planes_and_tubes_have_constant_curvature_in_any_number_format() {
        for (name, mesh) in [("plane", shape("grid:40x30")), ("tube", tube("grid:30x20"))] {
            for (format, mesh) in in_formats(&mesh) {
                for kind in [CurvatureKind::Mean, CurvatureKind::Gaussian] {
                    assert_constant(&mesh, kind, &format!("{name}, {format}"));
                }
            }
        }
    }

    /// Fits next to the boundary of a tube differ from others; of a long one they are less than 2 % of the area.
    #[test]
    fn planes_and_long_tubes_have_constant_quadrics_in_any_number_format() {
        let tube = {
            let (around, along) = (24, 300);
            let vertices = (0..around * along).map(|k| {
                let angle = TAU * f64::from(k % around) / f64::from(around);
                Point3::new(angle.cos(), angle.sin(), 0.2 * f64::from(k / around))
            });
            let at = |i: u32, j: u32| j * around + i % around;
            let cell = |k: u32| {
                let (i, j) = (k % around, k / around);
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                [[a, b, c], [a, c, d]]
            };
            Mesh::new(vertices.collect(), (0..around * (along - 1)).flat_map(cell).collect())
        };
        for (format, mesh) in in_formats(&shape("grid:40x30")) {
            assert_constant(&mesh, CurvatureKind::MeanQuadric, &format!("plane, {format}"));
            let error = curved(&mesh, CurvatureKind::ShapeIndex).err().unwrap().to_string();
            assert!(
                error.contains("no vertex of the mesh has a shape index: the surface is flat"),
                "{error}"
            );
        }
        for (format, mesh) in in_formats(&tube) {
            for kind in [CurvatureKind::MeanQuadric, CurvatureKind::ShapeIndex] {
                assert_constant(&mesh, kind, &format!("tube, {format}"));
            }
        }
    }

    /// The shape index of a surface that is flat except for a hill is known on the hill only.
    #[test]
    fn flat_vertices_have_no_shape_index() {
        let mut hill = shape("grid:60x60");
        hill.vertices.iter_mut().for_each(|x| {
            let square = 16.0 * ((x.x - 0.5).powi(2) + (x.y - 0.5).powi(2));
            x.z = 0.1 * (1.0 - square).max(0.0).powi(3);
        });
        let curved = curved(&hill, CurvatureKind::ShapeIndex).unwrap();
        // Two corners have no neighbors inside.
        let flat = curved.values.iter().filter(|s| s.is_nan()).count() - 2;
        assert!(
            curved.warnings.iter().any(|w| w.starts_with(&format!("{flat} vertices are flat")))
        );
        for (x, s) in hill.vertices.iter().zip(&curved.values) {
            let distance = (x.x - 0.5).hypot(x.y - 0.5);
            assert!(s.is_nan() == (distance > 0.27) || (0.24..0.3).contains(&distance));
            assert!(distance > 0.05 || *s > 0.9, "{distance} {s}");
        }
        assert_eq!(curved.range, [-1.0, 1.0]);
    }

    #[test]
    fn other_shapes_have_varying_curvature_in_any_number_format() {
        let digits = |digits: usize| move |x: f64| format!("{x:.digits$}").parse().unwrap();
        let mut waves = shape("grid:60x40");
        waves.vertices.iter_mut().for_each(|x| x.z = 1e-3 * (9.0 * x.x).sin() * (7.0 * x.y).cos());
        let lattice = rounded(shape("sphere:4").scaled(20.0), f64::round);
        for mesh in [shape("torus:60x38"), bumpy(15), waves, lattice] {
            for mesh in [
                mesh.clone(),
                mesh.clone().scaled(1e4),
                rounded(mesh.clone(), |x| f64::from(x as f32)),
                rounded(mesh, digits(6)),
            ] {
                for &kind in CurvatureKind::names() {
                    let kind = CurvatureKind::named(kind).unwrap();
                    let Curved { values, warnings, .. } = curved(&mesh, kind).unwrap();
                    assert!(
                        !warnings.iter().any(|w| w.contains(NOTHING_TO_SEGMENT)),
                        "{warnings:?}"
                    );
                    let known = || values.iter().copied().filter(|h| !h.is_nan());
                    let extremes = (known().fold(1.0, f64::min), known().fold(0.0, f64::max));
                    if kind == CurvatureKind::ShapeIndex {
                        assert!(0.0 <= extremes.0 && extremes.0 < extremes.1 && extremes.1 <= 1.0);
                    } else {
                        assert_eq!(extremes, (0.0, 1.0));
                    }
                }
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
            let warnings = mean(mesh).unwrap().warnings;
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
        let error = mean(&tube("grid:30x1")).err().unwrap().to_string();
        assert!(error.starts_with("no vertex of the mesh has a curvature"), "{error}");
        // Two corners of a grid have only neighbors on the boundary; so have all vertices of the strip next to it.
        let curved = mean(&disjoint([bumpy(9), tube("grid:30x1")])).unwrap();
        let nan = curved.values.iter().filter(|h| h.is_nan()).count();
        assert_eq!(nan, 2 + 62);
        assert!(curved.warnings.iter().any(|w| w.starts_with("64 vertices have no curvature")));
    }
}
