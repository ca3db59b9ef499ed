//! Rules for all formats: valid coordinates, faces and texture coordinates, and the treatment of invalid ones.

use std::path::Path;

use nalgebra::Point3;

use super::occurrences::{Occurrences, warn};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::is_position;

/// Coordinates beyond this are refused: areas and their squares would overflow.
const LARGEST_COORDINATE: f64 = 1e50;

/// Written for unknown colors if the format requires a color.
const UNKNOWN_COLOR: [f64; 3] = [0.5; 3];

/// The color to be written.
#[inline]
pub(super) fn known(color: [f64; 3]) -> [f64; 3] {
    if color[0].is_nan() { UNKNOWN_COLOR } else { color }
}

/// Warning about points and lines among the faces.
pub(super) const TOO_FEW_CORNERS: &str = "faces with fewer than 3 corners are left out";

/// Warning about texture coordinates that are NaN, infinite, text, or beyond [`is_position`].
pub(super) const INVALID_TEXTURE: &str =
    "texture coordinates that are not finite numbers, or are beyond 1e9, are unknown";

/// Texture coordinates, both NaN if they are not a position in an image.
#[inline]
pub(super) fn valid_uv(
    t: [f64; 2],
    invalid: &mut Occurrences,
    location: impl FnOnce() -> String,
) -> [f64; 2] {
    if is_position(t) {
        return t;
    }
    invalid.add(location);
    [f64::NAN; 2]
}

/// Checks a coordinate; fails with a message if it is invalid.
#[inline]
pub(super) fn check_coordinate(x: f64) -> std::result::Result<f64, String> {
    if !x.is_finite() {
        Err(format!("{x} is not a finite coordinate"))
    } else if x.abs() > LARGEST_COORDINATE {
        Err(format!(
            "the coordinate {x:e} is too large; scale the mesh to less than {LARGEST_COORDINATE:e}"
        ))
    } else {
        Ok(x)
    }
}

/// Warns of faces that have corners without texture coordinates; returns `None` if no corner has any.
pub(super) fn warn_untextured(path: &Path, uv: Vec<[[f64; 2]; 3]>) -> Option<Vec<[[f64; 2]; 3]>> {
    let missing = |face: &[[f64; 2]; 3]| face.iter().filter(|t| t[0].is_nan()).count();
    let unknown = uv.iter().filter(|face| missing(face) > 0).count();
    if unknown == uv.len() && uv.iter().all(|face| missing(face) == 3) {
        return None;
    }
    if unknown > 0 {
        let faces = uv.len();
        warn(
            path,
            &format!(
                "{unknown} of {} corners without texture coordinates, which are unknown",
                counted(faces, "face has", "faces have")
            ),
        );
    }
    Some(uv)
}

/// Fails if there are no faces. Readers call this before they warn of what they left out, so that an error is one line.
pub(super) fn check_faces(path: &Path, faces: &[[u32; 3]]) -> Result<()> {
    match faces {
        [] => Err(Error::malformed(path, "has no faces")),
        _ => Ok(()),
    }
}

/// The triangles (c_1, c_i, c_{i+1}) of a polygon.
pub(super) fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> + '_ {
    (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]])
}

/// Texture coordinates per face corner from one pair per vertex.
pub(super) fn uv_of_vertices(faces: &[[u32; 3]], uv: &[[f64; 2]]) -> Vec<[[f64; 2]; 3]> {
    faces.iter().map(|face| face.map(|k| uv[k as usize])).collect()
}

/// The coordinates of a point, for writing.
#[inline]
pub(super) fn coordinates(x: &Point3<f64>) -> [f64; 3] {
    [x.x, x.y, x.z]
}
