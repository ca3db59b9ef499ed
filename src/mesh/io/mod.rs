//! Mesh files. One format a file; each keeps the file's vertex order.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | any index form, polygons, vertex colors, texture coordinates, materials | exact coordinates, all of these |
//! | PLY | ascii and both binary forms, any property types, polygons, triangle strips, colors of vertices and faces, images | binary little endian, exact coordinates, 8-bit colors, images |
//! | OFF | OFF with any of the prefixes ST, C, N; polygons, colors of vertices and faces | exact coordinates and colors |
//! | STL | ascii and binary, equal positions welded | binary, coordinates rounded to 32 bits, from a local origin if they need one |
//!
//! Polygons are cut into triangles inside themselves, see `polygon.rs`; what has fewer than 3 corners is no face and
//! left out. What a file says besides positions and faces never makes it unreadable: colors and texture coordinates
//! that are missing or no numbers are NaN, one sentence a kind says how many and where first.
//!
//! A reader trusts nothing: what a file promises is checked against its size before memory is taken, no
//! coordinate is NaN or infinite, every face refers to vertices that exist, and whatever is wrong becomes
//! one [`Error`] of one line. Degenerate and duplicate faces and unreferenced vertices are legal and stay.

mod colors;
mod obj;
mod off;
mod paths;
mod places;
mod ply;
mod polygon;
mod stl;
mod text;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::Path;

use nalgebra::Point3;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Mesh, Placement, is_place};

use self::places::{Places, warn};

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
    parse_beside(path, path.parent(), format, &bytes)
}

/// Reads a mesh from memory; `path` only serves the messages. What other files say about its materials is unknown.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, format: Format, bytes: &[u8]) -> Result<Mesh> {
    parse_beside(path, None, format, bytes)
}

/// Reads a mesh that may name other files of a folder.
fn parse_beside(path: &Path, folder: Option<&Path>, format: Format, bytes: &[u8]) -> Result<Mesh> {
    let mesh = match format {
        Format::Obj => obj::parse(path, folder, bytes),
        Format::Ply => ply::parse(path, folder, bytes),
        Format::Off => off::parse(path, bytes),
        Format::Stl => stl::parse(path, bytes),
    }?;
    check_faces(path, &mesh.faces)?;
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
    warn_of_losses(path, format, mesh);
    match format {
        Format::Obj => {
            let library = write_materials(path, mesh)?;
            file::write(path, |out: &mut dyn Write| obj::write(out, mesh, library.as_deref()))
        }
        Format::Ply => {
            file::write(path, |out: &mut dyn Write| ply::write(out, mesh, folder_of(path)))
        }
        Format::Off => file::write(path, |out: &mut dyn Write| off::write(out, mesh)),
        Format::Stl => {
            let origin = stl::origin(path, mesh)?;
            file::write(path, |out: &mut dyn Write| stl::write(out, mesh, origin))
        }
    }
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Writes the materials of an OBJ file beside it, if it has some; the name of their file.
fn write_materials(path: &Path, mesh: &Mesh) -> Result<Option<String>> {
    let Some(materials) = &mesh.materials else { return Ok(None) };
    let library = path.with_extension("mtl");
    file::write(&library, |out: &mut dyn Write| {
        obj::write_materials(out, materials, folder_of(path))
    })?;
    Ok(library.file_name().map(|name| name.to_string_lossy().into_owned()))
}

/// Says in one sentence what a mesh has and the format has not, and in another what is made up.
fn warn_of_losses(path: &Path, format: Format, mesh: &Mesh) {
    let images = mesh.materials.as_ref().is_some_and(|m| m.all.iter().any(|m| m.image.is_some()));
    let (colors, face_colors) = (mesh.colors.is_some(), mesh.face_colors.is_some());
    let (uv, materials) = (mesh.uv.is_some(), mesh.materials.is_some());
    let mut lost = Vec::new();
    match format {
        Format::Obj => {
            lost.extend(face_colors.then_some("colors of faces (PLY and OFF hold them)"))
        }
        Format::Ply if materials && images => {
            lost.push("names and colors of materials (OBJ holds them)");
            let placed = mesh.materials.iter().flat_map(|m| &m.all);
            if placed.into_iter().any(|m| m.placement != Placement::default()) {
                lost.push("how materials scale, move or clamp their images (OBJ holds it)");
            }
        }
        Format::Ply => lost.extend(materials.then_some("materials (OBJ holds them)")),
        Format::Off | Format::Stl => {
            if format == Format::Stl {
                lost.extend(colors.then_some("colors of vertices (the other formats hold them)"));
                lost.extend(face_colors.then_some("colors of faces (PLY and OFF hold them)"));
            }
            lost.extend(uv.then_some("texture coordinates (OBJ and PLY hold them)"));
            lost.extend(materials.then_some("materials (OBJ holds them)"));
        }
    }
    if !lost.is_empty() {
        warn(path, &format!("left out: {}", lost.join(", ")));
    }
    if format == Format::Ply {
        let known = |face: &&[[f64; 2]; 3]| face.iter().filter(|t| !t[0].is_nan()).count();
        let partly = mesh.uv.iter().flatten().filter(|face| (1..3).contains(&known(face))).count();
        if partly > 0 {
            let message = format!(
                "left out: the texture coordinates of {partly} faces that have them at some corners only (OBJ holds them)"
            );
            warn(path, &message);
        }
    }
    if matches!(format, Format::Ply | Format::Off) {
        let unknown = mesh.colors.iter().flatten().filter(|color| color[0].is_nan()).count();
        let of_faces = match format {
            Format::Ply => mesh.face_colors.iter().flatten().filter(|c| c[0].is_nan()).count(),
            _ => 0,
        };
        if unknown + of_faces > 0 {
            let message =
                format!("{unknown} vertices and {of_faces} faces without a color are written gray");
            warn(path, &message);
        }
    }
}

/// What stands for a color that is not known, where the format wants one.
const GRAY: [f64; 3] = [0.5; 3];

/// A color to be written.
fn known(color: [f64; 3]) -> [f64; 3] {
    if color[0].is_nan() { GRAY } else { color }
}

/// What becomes of points and lines among the faces.
const TOO_FEW_CORNERS: &str = "faces with fewer than 3 corners are left out";

/// What becomes of texture coordinates that are NaN, infinite, text, or beyond [`is_place`].
const NO_NUMBERS: &str =
    "texture coordinates that are not finite numbers, or are beyond 1e9, count as unknown";

/// Texture coordinates, both NaN if they are no place in an image.
fn place_in_image(t: [f64; 2], odd: &mut Places, place: impl FnOnce() -> String) -> [f64; 2] {
    if is_place(t) {
        return t;
    }
    odd.add(place);
    [f64::NAN; 2]
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

/// Says how many faces have corners without texture coordinates; none at all if no corner has any.
fn warn_untextured(path: &Path, uv: Vec<[[f64; 2]; 3]>) -> Option<Vec<[[f64; 2]; 3]>> {
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
fn check_faces(path: &Path, faces: &[[u32; 3]]) -> Result<()> {
    match faces {
        [] => Err(Error::malformed(path, "has no faces")),
        _ => Ok(()),
    }
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
