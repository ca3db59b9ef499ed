//! Writing STL: binary, coordinates rounded to 32 bits.
//!
//! The rounding error of x is up to 2^-24 |x|. Far from the origin, as in map coordinates, this merges vertices or
//! distorts small faces; positions are then written relative to a local origin, which the header and a warning state.
//! Positions never merge: if the origin does not help, the mesh is refused.

use std::io::{self, Write};
use std::path::Path;

use nalgebra::{Point3, Vector3};

use super::{COUNT_SIZE, HEADER_SIZE};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::io::coordinates;
use crate::mesh::io::occurrences::warn;

/// Rounding errors up to this fraction of the shortest edge cause no warning.
const TOLERATED_LOSS: f64 = 1e-4;
/// A local origin is used if it reduces the error by at least this factor.
const WORTHWHILE_GAIN: f64 = 8.0;

/// The effect of rounding on the corners.
struct Loss {
    /// The number of positions that merge with another.
    merged: usize,
    /// The largest change of a coordinate; infinite if one does not fit.
    error: f64,
}

impl Loss {
    fn of(points: &[Point3<f64>], origin: Vector3<f64>) -> Self {
        let mut rounded = Vec::with_capacity(points.len());
        let mut error = 0.0_f64;
        for x in points {
            let x = x - origin;
            let narrow = coordinates(&x).map(|x| x as f32);
            for (x, narrow) in coordinates(&x).iter().zip(narrow) {
                let change = (x - f64::from(narrow)).abs();
                error = error.max(if change.is_finite() { change } else { f64::INFINITY });
            }
            // Makes the bits of both zeros equal.
            rounded.push(narrow.map(|x| (x + 0.0).to_bits()));
        }
        rounded.sort_unstable();
        rounded.dedup();
        Loss { merged: points.len() - rounded.len(), error }
    }
}

/// The point that the file's coordinates are relative to: 0 unless rounding them would lose too much.
///
/// # Errors
/// Positions would still merge, coordinates are too large, or the faces too many for their count.
pub fn origin(path: &Path, mesh: &Mesh) -> Result<Vector3<f64>> {
    if u32::try_from(mesh.faces.len()).is_err() {
        return Err(Error::unsuitable(format!(
            "{}: the mesh has too many faces for STL; write PLY or OBJ",
            path.display()
        )));
    }
    let points = corners(mesh);
    let shortest = shortest_side(mesh);
    let plain = Loss::of(&points, Vector3::zeros());
    if plain.merged == 0 && plain.error <= TOLERATED_LOSS * shortest {
        return Ok(Vector3::zeros());
    }
    let local = center(&points);
    let shifted = Loss::of(&points, local);
    if plain.error == f64::INFINITY && shifted.error == f64::INFINITY {
        return Err(Error::unsuitable(format!(
            "{}: the coordinates are too large for STL; write PLY or OBJ",
            path.display()
        )));
    }
    if shifted.merged > 0 && plain.merged > 0 {
        return Err(Error::unsuitable(format!(
            "{}: {} with others in the 32-bit coordinates of STL; write PLY or OBJ",
            path.display(),
            counted(shifted.merged, "vertex would merge", "vertices would merge")
        )));
    }
    let moves =
        plain.merged > 0 || (shifted.merged == 0 && plain.error > WORTHWHILE_GAIN * shifted.error);
    let error = if moves { shifted.error } else { plain.error };
    if moves {
        warn(
            path,
            &format!(
                "coordinates are written relative to the origin {}, since 32 bits would lose too much otherwise",
                shown(local)
            ),
        );
    }
    if error > TOLERATED_LOSS * shortest {
        warn(
            path,
            &format!(
                "the 32 bits of STL change coordinates by up to {error:.1e}, while the shortest edge is \
                 {shortest:.1e}; PLY and OBJ keep them"
            ),
        );
    }
    Ok(if moves { local } else { Vector3::zeros() })
}

fn shown(origin: Vector3<f64>) -> String {
    format!("{:?} {:?} {:?}", origin.x, origin.y, origin.z)
}

/// The distinct positions of corners of faces.
fn corners(mesh: &Mesh) -> Vec<Point3<f64>> {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.faces.as_flattened().iter().for_each(|&k| used[k as usize] = true);
    let mut points: Vec<[u64; 3]> = mesh
        .vertices
        .iter()
        .zip(used)
        .filter(|(_, used)| *used)
        .map(|(x, _)| coordinates(x).map(|x| (x + 0.0).to_bits()))
        .collect();
    points.sort_unstable();
    points.dedup();
    points.into_iter().map(|bits| Point3::from(bits.map(f64::from_bits))).collect()
}

/// The smallest nonzero length of a side.
fn shortest_side(mesh: &Mesh) -> f64 {
    let squares = (0..mesh.faces.len()).flat_map(|j| {
        let [a, b, c] = mesh.corners(j);
        [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()]
    });
    squares.filter(|&square| square > 0.0).fold(f64::INFINITY, f64::min).sqrt()
}

/// The center of the bounding box, rounded to a tenth of its size so that it is readable.
fn center(points: &[Point3<f64>]) -> Vector3<f64> {
    let Some(&first) = points.first() else { return Vector3::zeros() };
    let (low, high) =
        points.iter().fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)));
    let size = (high - low).max();
    let middle = nalgebra::center(&low, &high).coords;
    if size == 0.0 {
        return middle;
    }
    let digits = (-size.log10()).floor() + 1.0;
    middle.map(|x| {
        let scale = 10.0_f64.powf(digits.abs());
        // Dividing by a power of ten gives the nearest number to the decimal digits; multiplying does not.
        let rounded =
            if digits > 0.0 { (x * scale).round() / scale } else { (x / scale).round() * scale };
        if rounded.is_finite() { rounded } else { x }
    })
}

/// Writes the mesh. The format cannot hold unreferenced vertices.
pub fn write(out: &mut dyn Write, mesh: &Mesh, origin: Vector3<f64>) -> io::Result<()> {
    let mut title = "binary STL".to_owned();
    if origin != Vector3::zeros() {
        title += &format!(", origin {}", shown(origin));
    }
    let mut header = [0; HEADER_SIZE];
    let length = title.len().min(HEADER_SIZE);
    header[..length].copy_from_slice(&title.as_bytes()[..length]);
    out.write_all(&header)?;
    let count: [u8; COUNT_SIZE] = (mesh.faces.len() as u32).to_le_bytes();
    out.write_all(&count)?;
    for j in 0..mesh.faces.len() {
        let normal = mesh.area_vector(j).try_normalize(0.0).unwrap_or_default().into();
        let [x1, x2, x3] = mesh.corners(j).map(|x| coordinates(&(x - origin)));
        for x in [normal, x1, x2, x3].as_flattened() {
            out.write_all(&(*x as f32).to_le_bytes())?;
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
