//! Numbers of vertices or faces that the mesh itself does not keep, such as class probabilities: properties of PLY,
//! arrays of VTK.

use std::path::Path;

use ndarray::Array2;

use super::{Format, ply, vtk};
use crate::error::{Error, Result};

/// The numbers of one element whose names match, in the order of the file.
pub struct Scalars {
    /// Whether they are those of faces.
    pub of_faces: bool,
    /// Their names.
    pub names: Vec<String>,
    /// One row per vertex or face of the file, one column per name.
    pub numbers: Array2<f64>,
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
