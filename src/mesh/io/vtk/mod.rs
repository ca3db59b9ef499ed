//! Files of VTK, as ParaView and pyvista have them: XML (`xml.rs`, .vtp and .vtu) and legacy (`legacy.rs`, .vtk).
//!
//! Polygons, strips and pixels become triangles; vertices and lines are left out. Colors are arrays named RGB, RGBA or
//! Colors of three or four components, in [0, 1] or bytes; texture coordinates are those named so, or UV. Other arrays
//! are read by their names ([`read_scalars`]).

mod grid;
mod legacy;
mod numbers;
mod payload;
mod write;
mod xml;

use std::path::Path;

use crate::error::Result;
use crate::mesh::Mesh;

use super::scalars::{Properties, Scalars};
use grid::Grid;

pub use write::{Content, Kind, Rows, write, write_mesh};

/// Whether the content begins as such a file does.
pub fn recognizes(bytes: &[u8]) -> bool {
    legacy::recognizes(bytes) || xml::recognizes(bytes)
}

fn grid(path: &Path, bytes: &[u8]) -> Result<Grid> {
    match legacy::recognizes(bytes) {
        true => legacy::parse(path, bytes),
        false => xml::parse(path, bytes),
    }
}

/// The mesh of a file.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    grid(path, bytes)?.mesh(path)
}

/// The arrays of points or of cells whose element, `vertex` or `face`, and name `matches`.
pub fn read_scalars(
    path: &Path,
    bytes: &[u8],
    matches: &dyn Fn(&str, &str) -> bool,
) -> Result<Scalars> {
    grid(path, bytes)?.scalars(path, matches)
}

/// All arrays of points and of cells.
pub fn read_properties(path: &Path, bytes: &[u8]) -> Result<Properties> {
    grid(path, bytes)?.properties(path)
}
