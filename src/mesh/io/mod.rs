//! Mesh files. One format a file; each keeps the file's vertex order.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | any index form, polygons, vertex colors, texture coordinates | exact coordinates, colors and texture coordinates |
//! | PLY | ascii and both binary forms, any property types, polygons, triangle strips | binary little endian, exact coordinates, 8-bit colors |
//! | OFF | OFF with any of the prefixes ST, C, N; polygons | exact coordinates and colors |
//! | STL | ascii and binary, equal positions welded | binary, coordinates rounded to 32 bits |
//!
//! A reader trusts nothing: what a file promises is checked against its size before memory is taken, no
//! coordinate is NaN or infinite, every face refers to vertices that exist, and whatever is wrong becomes
//! one [`Error`] of one line. Degenerate and duplicate faces and unreferenced vertices are legal and stay.

mod obj;
mod off;
mod ply;
mod stl;
mod text;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::Path;

use nalgebra::Point3;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::Mesh;

pub use ply::write_labeled;

/// Coordinates beyond this are refused: areas and their squares would leave the range of `f64`.
const LARGEST_COORDINATE: f64 = 1e50;

/// The file formats for triangle meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Obj,
    Ply,
    Off,
    Stl,
}

impl Format {
    /// What users read when their format is not among these.
    const NAMES: &str = ".obj, .ply, .off and .stl";

    /// By the extension, in any case.
    fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Format::Obj),
            "ply" => Some(Format::Ply),
            "off" => Some(Format::Off),
            "stl" => Some(Format::Stl),
            _ => None,
        }
    }

    /// By how the content begins.
    fn of_content(bytes: &[u8]) -> Option<Self> {
        if ply::recognizes(bytes) {
            Some(Format::Ply)
        } else if off::recognizes(bytes) {
            Some(Format::Off)
        } else if stl::recognizes(bytes) {
            Some(Format::Stl)
        } else if obj::recognizes(bytes) {
            Some(Format::Obj)
        } else {
            None
        }
    }
}

/// Reads a mesh. The format is that of the extension, or else the one the content begins like.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is not a valid mesh with at least one face.
pub fn read(path: &Path) -> Result<Mesh> {
    let bytes = file::read(path)?;
    let format =
        Format::of_extension(path).or_else(|| Format::of_content(&bytes)).ok_or_else(|| {
            Error::malformed(
                path,
                format!("is no known mesh format; convert it to one of {}", Format::NAMES),
            )
        })?;
    parse(path, format, &bytes)
}

/// Reads a mesh from memory; `path` only serves the messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, format: Format, bytes: &[u8]) -> Result<Mesh> {
    let mesh = match format {
        Format::Obj => obj::parse(path, bytes),
        Format::Ply => ply::parse(path, bytes),
        Format::Off => off::parse(path, bytes),
        Format::Stl => stl::parse(path, bytes),
    }?;
    if mesh.faces.is_empty() {
        return Err(Error::malformed(path, "has no faces"));
    }
    if u32::try_from(mesh.vertices.len()).is_err() {
        return Err(Error::malformed(path, "has more than 2^32 - 1 vertices"));
    }
    Ok(mesh)
}

/// Whether the format of the extension has texture coordinates.
pub fn holds_texture(path: &Path) -> bool {
    matches!(Format::of_extension(path), Some(Format::Obj | Format::Ply))
}

/// Writes a mesh in the format of the extension. Whatever the format cannot hold is left out with a warning.
///
/// # Errors
/// The extension is unknown, the coordinates do not fit into the format, or the file cannot be written.
pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    let format = Format::of_extension(path).ok_or_else(|| {
        Error::unsuitable(format!(
            "{}: the extension names no known mesh format; use one of {}",
            path.display(),
            Format::NAMES
        ))
    })?;
    if mesh.colors.is_some() && format == Format::Stl {
        tracing::warn!("{}: STL holds no colors", path.display());
    }
    if mesh.uv.is_some() && !holds_texture(path) {
        tracing::warn!(
            "{}: texture coordinates are left out; OBJ and PLY hold them",
            path.display()
        );
    }
    if format == Format::Stl {
        stl::check_range(path, mesh)?;
    }
    file::write(path, |out: &mut dyn Write| match format {
        Format::Obj => obj::write(out, mesh),
        Format::Ply => ply::write(out, mesh),
        Format::Off => off::write(out, mesh),
        Format::Stl => stl::write(out, mesh),
    })
}

/// What is wrong with a coordinate, if anything.
fn check_coordinate(x: f64) -> std::result::Result<f64, String> {
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

/// A color component in [0, 1], up to the rounding of programs that write it.
fn check_color(c: f64) -> std::result::Result<f64, String> {
    const ROUNDING: f64 = 1e-6;
    if (-ROUNDING..=1.0 + ROUNDING).contains(&c) {
        Ok(c.clamp(0.0, 1.0))
    } else {
        Err(format!("the color component {c:?} is outside [0, 1]"))
    }
}

/// A texture coordinate: any finite number, since textures may repeat.
fn check_texture(t: f64) -> std::result::Result<f64, String> {
    if t.is_finite() { Ok(t) } else { Err(format!("{t} is not a finite texture coordinate")) }
}

/// The triangles (c_1, c_i, c_{i+1}) of a polygon.
fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> + '_ {
    (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]])
}

/// Texture coordinates per face corner from one pair per vertex.
fn uv_of_vertices(faces: &[[u32; 3]], uv: &[[f64; 2]]) -> Vec<[[f64; 2]; 3]> {
    faces.iter().map(|face| face.map(|k| uv[k as usize])).collect()
}

/// A point as its coordinates, to be written.
fn coordinates(x: &Point3<f64>) -> [f64; 3] {
    [x.x, x.y, x.z]
}
