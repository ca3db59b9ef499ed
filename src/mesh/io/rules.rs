//! What holds in every format: valid coordinates, faces and texture coordinates, and what becomes of invalid ones.

use std::path::Path;

use nalgebra::Point3;

use super::occurrences::{Occurrences, warn};
use crate::error::{Error, Result};
use crate::mesh::is_place;

/// Coordinates beyond this are refused: areas and their squares would leave the range of `f64`.
const LARGEST_COORDINATE: f64 = 1e50;

/// What stands for a color that is not known, where the format wants one.
const UNKNOWN_COLOR: [f64; 3] = [0.5; 3];

/// A color to be written.
pub(super) fn known(color: [f64; 3]) -> [f64; 3] {
    if color[0].is_nan() { UNKNOWN_COLOR } else { color }
}

/// What becomes of points and lines among the faces.
pub(super) const TOO_FEW_CORNERS: &str = "faces with fewer than 3 corners are left out";

/// What becomes of texture coordinates that are NaN, infinite, text, or beyond [`is_place`].
pub(super) const INVALID_TEXTURE: &str =
    "texture coordinates that are not finite numbers, or are beyond 1e9, count as unknown";

/// Texture coordinates, both NaN if they are not a position in an image.
pub(super) fn place_in_image(
    t: [f64; 2],
    odd: &mut Occurrences,
    place: impl FnOnce() -> String,
) -> [f64; 2] {
    if is_place(t) {
        return t;
    }
    odd.add(place);
    [f64::NAN; 2]
}

/// What is wrong with a coordinate, if anything.
pub(super) fn check_coordinate(x: f64) -> std::result::Result<f64, String> {
    if !x.is_finite() {
        Err(format!("{x} is not a finite coordinate"))
    } else if x.abs() > LARGEST_COORDINATE {
        Err(format!(
            "the coordinate {x:e} is too large; scale the mesh below {LARGEST_COORDINATE:e}"
        ))
    } else {
        Ok(x)
    }
}

/// Says how many faces have corners without texture coordinates; none at all if no corner has any.
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
                "{unknown} of {faces} faces have corners without texture coordinates, which count as unknown"
            ),
        );
    }
    Some(uv)
}

/// A mesh has faces. Readers look before they say what they left out, since an error is one line.
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

/// A point as its coordinates, to be written.
pub(super) fn coordinates(x: &Point3<f64>) -> [f64; 3] {
    [x.x, x.y, x.z]
}
