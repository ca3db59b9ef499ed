//! Mesh files, one format per module. Each keeps the vertex order of the file.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | any index form, polygons, vertex colors, texture coordinates, materials | exact coordinates, all of these |
//! | PLY | ascii and both binary forms, any property types, polygons, triangle strips, colors of vertices and faces, images | binary little endian, exact coordinates, 8-bit colors, images |
//! | OFF | OFF with any of the prefixes ST, C, N; polygons, colors of vertices and faces | exact coordinates and colors |
//! | VTK | .vtp, .vtu and legacy .vtk, of text or bytes; arrays by their names | .vtp and .vtu, exact coordinates, 8-bit colors |
//! | STL | ascii and binary, equal positions welded | binary, coordinates rounded to 32 bits, from a local origin if they need one |
//! | glTF | 2.0 as `.gltf` and `.glb`: the scene, colors, texture coordinates, materials; not compressed | labels, as `.glb` |
//! | GIFTI | surfaces in all encodings but external files | labels |
//! | FreeSurfer | surfaces of triangles, binary and ascii | labels, as annotations |
//!
//! GIFTI and FreeSurfer also have files of numbers and labels at vertices, see [`read_values`].
//!
//! Polygons are cut into triangles inside themselves, see `polygon.rs`; faces with fewer than 3 corners are left out.
//! Only errors in positions and faces make a file unreadable: missing or invalid colors and texture coordinates are
//! NaN, and one warning per kind reports how many there are and where the first one is.
//!
//! Readers trust nothing: declared counts are checked against the file size before memory is allocated, coordinates
//! must be finite, faces must refer to existing vertices, and any failure is one [`Error`] of one line. Degenerate and
//! duplicate faces and unreferenced vertices are legal and are kept.

mod colors;
mod freesurfer;
mod gifti;
mod gltf;
mod obj;
mod occurrences;
mod off;
mod paths;

mod ply;
mod polygon;
mod rules;
mod scalar;
mod scalars;
mod stl;
mod text;
mod unpack;
mod values;
pub mod vtk;
mod xml;

#[cfg(test)]
mod tests;

use std::io::Write;
use std::path::Path;

use strum::EnumString;

use crate::counted::counted;
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Material, Materials, Mesh, Placement};

use self::occurrences::warn;
use self::rules::{
    INVALID_TEXTURE, TOO_FEW_CORNERS, check_coordinate, check_faces, coordinates, fan, known,
    uv_of_vertices, valid_uv, warn_untextured,
};
use self::unpack::Unpacked;

pub use freesurfer::{Annotation, read_annotation, read_curvature, write_annotation};
pub use gifti::{GiftiArrays, GiftiLabel, read_arrays, write_labels};
pub use gltf::{write_labeled as write_glb, write_labeled_faces as write_glb_of_faces};
pub use ply::write_labeled;
pub use scalars::{Properties, Scalars};
pub use values::{names_values, read_data, read_values};

/// The file formats for triangle meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString)]
#[strum(serialize_all = "lowercase", ascii_case_insensitive)]
pub enum Format {
    /// Wavefront OBJ, with an MTL file for materials.
    Obj,
    /// Polygon file format (PLY).
    Ply,
    /// Object file format (OFF).
    Off,
    /// Stereolithography (STL).
    Stl,
    /// PolyData and unstructured grids of VTK.
    #[strum(serialize = "vtk", serialize = "vtp", serialize = "vtu")]
    Vtk,
    /// glTF 2.0, as text or binary, which is only read.
    #[strum(serialize = "gltf", serialize = "glb")]
    Gltf,
    /// A surface of GIFTI (`.surf.gii`), which is only read.
    Gii,
    /// A surface of FreeSurfer, such as `lh.white`, which is only read. It has no extension; its content tells.
    #[strum(disabled)]
    FreeSurfer,
}

impl Format {
    /// The extensions of the formats that are read and written, for error messages.
    const EXTENSIONS: &str = ".obj, .ply, .off, .stl, .vtp and .vtu";

    /// The format of the extension, in upper or lower case.
    fn of_extension(path: &Path) -> Option<Self> {
        path.extension()?.to_str()?.parse().ok()
    }

    /// The format that the content begins like.
    fn of_content(bytes: &[u8]) -> Option<Self> {
        if ply::recognizes(bytes) {
            Some(Format::Ply)
        } else if freesurfer::recognizes(bytes) {
            Some(Format::FreeSurfer)
        } else if gifti::recognizes(bytes) {
            Some(Format::Gii)
        } else if gltf::recognizes(bytes) {
            Some(Format::Gltf)
        } else if off::recognizes(bytes) {
            Some(Format::Off)
        } else if vtk::recognizes(bytes) {
            Some(Format::Vtk)
        } else if stl::recognizes(bytes) {
            Some(Format::Stl)
        } else if obj::recognizes(bytes) {
            Some(Format::Obj)
        } else {
            None
        }
    }
}

/// Reads a mesh. The extension determines the format, or else the beginning of the content.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is not a valid mesh with at least one face.
pub fn read(path: &Path) -> Result<Mesh> {
    let bytes = file::read(path)?;
    let format =
        Format::of_extension(path).or_else(|| Format::of_content(&bytes)).ok_or_else(|| {
            Error::malformed(
                path,
                format!(
                    "is not in a known mesh format; convert it to one of {} (.gltf, .glb, .gii and surfaces of FreeSurfer are read, too)",
                    Format::EXTENSIONS
                ),
            )
        })?;
    parse_beside(path, path.parent(), format, &bytes)
}

/// Reads a mesh from memory; `path` is only for messages. Other files with its materials are not read.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, format: Format, bytes: &[u8]) -> Result<Mesh> {
    parse_beside(path, None, format, bytes)
}

/// Reads a mesh that may name other files in a folder.
fn parse_beside(path: &Path, folder: Option<&Path>, format: Format, bytes: &[u8]) -> Result<Mesh> {
    let mesh = match format {
        Format::Obj => obj::parse(path, folder, bytes),
        Format::Ply => ply::parse(path, folder, bytes),
        Format::Off => off::parse(path, bytes),
        Format::Stl => stl::parse(path, bytes),
        Format::Vtk => vtk::parse(path, bytes),
        Format::Gltf => gltf::parse(path, folder, bytes),
        Format::Gii => gifti::parse(path, bytes),
        Format::FreeSurfer => freesurfer::parse(path, bytes),
    }?;
    check_faces(path, &mesh.faces)?;
    if u32::try_from(mesh.vertices.len()).is_err() {
        return Err(Error::malformed(path, "has more than 2^32 - 1 vertices"));
    }
    Ok(mesh)
}

/// Reads the numbers of vertices or of faces whose element, `vertex` or `face`, and name `matches`.
///
/// # Errors
/// The file has neither format or is not valid, or vertices and faces, or neither, have such numbers.
pub fn read_scalars(
    path: &Path,
    bytes: &[u8],
    matches: &dyn Fn(&str, &str) -> bool,
) -> Result<Scalars> {
    match Format::of_extension(path).or_else(|| Format::of_content(bytes)) {
        Some(Format::Ply) => ply::read_scalars(path, bytes, matches),
        Some(Format::Vtk) => vtk::read_scalars(path, bytes, matches),
        _ => Err(Error::malformed(
            path,
            "properties are read from PLY and VTK; give the numbers of other meshes as a file",
        )),
    }
}

/// Reads what a file has at its vertices and at its faces besides the mesh, which is that of the file: properties of PLY
/// and arrays of VTK, as far as there is one number for each vertex or face. Warns of others.
///
/// # Errors
/// The file cannot be read, or is not valid.
pub fn read_properties(path: &Path, mesh: &Mesh) -> Result<Properties> {
    if !matches!(Format::of_extension(path), Some(Format::Ply | Format::Vtk) | None) {
        return Ok(Properties::default());
    }
    let bytes = file::read(path)?;
    let mut found = match Format::of_extension(path).or_else(|| Format::of_content(&bytes)) {
        Some(Format::Ply) => ply::read_properties(path, &bytes)?,
        Some(Format::Vtk) => vtk::read_properties(path, &bytes)?,
        _ => Properties::default(),
    };
    let of_vertices = (&mut found.of_vertices, mesh.vertices.len(), "vertices");
    for (scalars, count, many) in [of_vertices, (&mut found.of_faces, mesh.faces.len(), "faces")] {
        if scalars.take_if(|scalars| scalars.numbers.nrows() != count).is_some() {
            tracing::warn!(
                "{}: its properties of {many} do not reach the results, since the mesh has {count} {many}: triangle \
                 strips have none",
                path.display()
            );
        }
    }
    Ok(found)
}

/// Whether the format of the extension can hold texture coordinates.
pub fn holds_texture(path: &Path) -> bool {
    matches!(Format::of_extension(path), Some(Format::Obj | Format::Ply))
}

/// Writes a mesh in the format of the extension. A warning names what the format cannot hold and is left out. Images
/// inside the file of the mesh become files next to this one.
///
/// # Errors
/// The extension is unknown or that of a format that is only read, the coordinates do not fit into the format, or the
/// file cannot be written.
pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    let format = writable_format(path)?;
    warn_of_losses(path, format, mesh);
    match format {
        Format::Obj => {
            let unpacked = Unpacked::new(path, mesh)?;
            let library = write_materials(path, &unpacked.mesh)?;
            file::write(path, |out: &mut dyn Write| {
                obj::write(out, &unpacked.mesh, library.as_deref())
            })?;
            unpacked.keep();
            Ok(())
        }
        Format::Ply => {
            let unpacked = Unpacked::new(path, mesh)?;
            let folder = folder_of(path);
            file::write(path, |out: &mut dyn Write| ply::write(out, &unpacked.mesh, folder))?;
            unpacked.keep();
            Ok(())
        }
        Format::Off => file::write(path, |out: &mut dyn Write| off::write(out, mesh)),
        Format::Stl => {
            let origin = stl::origin(path, mesh)?;
            file::write(path, |out: &mut dyn Write| stl::write(out, mesh, origin))
        }
        Format::Vtk => vtk::write_mesh(path, mesh),
        Format::Gltf | Format::Gii | Format::FreeSurfer => unreachable!("it is not writable"),
    }
}

fn writable_format(path: &Path) -> Result<Format> {
    match Format::of_extension(path) {
        Some(Format::Gltf | Format::Gii | Format::FreeSurfer) => Err(Error::unsuitable(format!(
            "{}: glTF, GIFTI and FreeSurfer are only read; use one of {}",
            path.display(),
            Format::EXTENSIONS
        ))),
        Some(format) => Ok(format),
        None => Err(Error::unsuitable(format!(
            "{}: the extension is not that of a mesh format; use one of {}",
            path.display(),
            Format::EXTENSIONS
        ))),
    }
}

/// Whether [`write_labeled_faces`] can write a file of this name.
///
/// # Errors
/// The extension is unknown, or that of a format without labels.
pub fn check_labeled_faces(path: &Path) -> Result<()> {
    match writable_format(path)? {
        Format::Stl | Format::Vtk => Err(Error::unsuitable(format!(
            "{}: the labels of faces are written to .ply, .obj or .off",
            path.display()
        ))),
        _ => Ok(()),
    }
}

/// Writes the positions and faces of a mesh with a label per face: PLY has a property `label` and colors of faces, OBJ
/// materials `region-0`, `region-1`, ... in a file next to it, OFF colors of faces.
///
/// `labels` has one entry per face, `colors` one RGB in [0, 1] per label.
///
/// # Errors
/// Those of [`check_labeled_faces`], and the file cannot be written.
pub fn write_labeled_faces(
    path: &Path,
    mesh: Mesh,
    labels: &[u8],
    colors: &[[f64; 3]],
) -> Result<()> {
    check_labeled_faces(path)?;
    let plain = Mesh::new(mesh.vertices, mesh.faces);
    let materials = || Materials {
        all: colors
            .iter()
            .enumerate()
            .map(|(p, &color)| Material {
                name: format!("region-{p}"),
                color: Some(color),
                ..Material::default()
            })
            .collect(),
        of_faces: labels.iter().map(|&p| Some(u32::from(p))).collect(),
    };
    let face_colors = || labels.iter().map(|&p| colors[usize::from(p)]).collect();
    match writable_format(path)? {
        Format::Ply => ply::write_labeled_faces(path, &plain, labels, colors),
        Format::Obj => write(path, &Mesh { materials: Some(materials()), ..plain }),
        _ => write(path, &Mesh { face_colors: Some(face_colors()), ..plain }),
    }
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Writes the materials of an OBJ file next to it, if there are any, and returns the name of their file.
fn write_materials(path: &Path, mesh: &Mesh) -> Result<Option<String>> {
    let Some(materials) = &mesh.materials else { return Ok(None) };
    let library = path.with_extension("mtl");
    file::write(&library, |out: &mut dyn Write| {
        obj::write_materials(out, materials, folder_of(path))
    })?;
    Ok(library.file_name().map(|name| name.to_string_lossy().into_owned()))
}

/// Warns of what the format cannot hold, and of what is written without being known.
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
        Format::Off | Format::Stl | Format::Vtk => {
            if format == Format::Stl {
                lost.extend(colors.then_some("colors of vertices (the other formats hold them)"));
                lost.extend(face_colors.then_some("colors of faces (PLY and OFF hold them)"));
            }
            lost.extend(uv.then_some("texture coordinates (OBJ and PLY hold them)"));
            lost.extend(materials.then_some("materials (OBJ holds them)"));
        }
        Format::Gltf | Format::Gii | Format::FreeSurfer => {}
    }
    if !lost.is_empty() {
        warn(path, &format!("left out: {}", lost.join(", ")));
    }
    if format == Format::Ply {
        let known = |face: &&[[f64; 2]; 3]| face.iter().filter(|t| !t[0].is_nan()).count();
        let partly = mesh.uv.iter().flatten().filter(|face| (1..3).contains(&known(face))).count();
        if partly > 0 {
            let message = format!(
                "left out: the texture coordinates of {} at some corners only (OBJ holds them)",
                counted(partly, "face that has them", "faces that have them")
            );
            warn(path, &message);
        }
    }
    if matches!(format, Format::Ply | Format::Off | Format::Vtk) {
        let unknown = mesh.colors.iter().flatten().filter(|color| color[0].is_nan()).count();
        let of_faces = match format {
            Format::Ply | Format::Vtk => {
                mesh.face_colors.iter().flatten().filter(|c| c[0].is_nan()).count()
            }
            _ => 0,
        };
        if unknown + of_faces > 0 {
            let message = format!(
                "{} and {} without a color are written as gray",
                counted(unknown, "vertex", "vertices"),
                counted(of_faces, "face", "faces")
            );
            warn(path, &message);
        }
    }
}
