//! The source of a mesh: a file, a generated shape, or an example embedded in the program.

use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

use super::io::{self, Format};
use super::{Mesh, Shape};
use crate::error::{Error, Result};

const SPOT: &[u8] = include_bytes!("../../assets/spot/spot_triangulated.obj");
const SPOT_TEXTURE: &[u8] = include_bytes!("../../assets/spot/spot_texture.png");

/// The source that the argument MESH names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A mesh file, see [`io`].
    File(PathBuf),
    /// A generated surface.
    Shape(Shape),
    /// `builtin:spot`: the textured cow of Keenan Crane, subdivided twice so that vertices resolve the texture;
    /// 46,850 vertices, 93,696 faces.
    Spot,
}

impl Source {
    /// The name of an existing file denotes that file; otherwise `builtin:NAME`, `torus:...`, `sphere:...` and the other
    /// names of [`Shape::SYNTAX`] are examples and shapes, any other `WORD:...` without a dot or a slash is refused, and everything
    /// else is a path.
    ///
    /// # Errors
    /// The argument has an unknown word or builtin name, or a malformed shape.
    pub fn parse(argument: impl AsRef<OsStr>) -> Result<Self> {
        let argument = argument.as_ref();
        let file = || Source::File(argument.into());
        if Path::new(argument).exists() {
            return Ok(file());
        }
        match argument.to_str().and_then(|text| text.split_once(':')) {
            Some(("builtin", "spot")) => Ok(Source::Spot),
            Some(("builtin", name)) => Err(Error::unsuitable(format!(
                "builtin:{}: is not an example; use builtin:spot",
                name.escape_debug()
            ))),
            Some((name, size)) if Shape::NAMES.contains(&name) => {
                Ok(Source::Shape(format!("{name}:{size}").parse()?))
            }
            // A single letter may be a drive name.
            Some((word, rest))
                if word.len() > 1
                    && word.bytes().all(|b| b.is_ascii_alphabetic())
                    && !rest.contains(['.', '/', '\\']) =>
            {
                Err(Error::unsuitable(format!(
                    "{word}:{}: is neither a file nor a shape; name a file, builtin:spot, {}",
                    rest.escape_debug(),
                    Shape::SYNTAX
                )))
            }
            _ => Ok(file()),
        }
    }

    /// Reads or generates the mesh. Fails if it is a file that cannot be read as a mesh.
    pub fn mesh(&self) -> Result<Mesh> {
        match self {
            Source::File(path) => io::read(path),
            Source::Shape(shape) => Ok(shape.mesh()),
            Source::Spot => {
                let spot = io::parse(Path::new("builtin:spot"), Format::Obj, SPOT)?;
                Ok(spot.subdivided().subdivided())
            }
        }
    }

    /// The same, with the texture coordinates of a shape.
    ///
    /// # Errors
    /// As [`Source::mesh`].
    pub fn textured_mesh(&self) -> Result<Mesh> {
        match self {
            Source::Shape(shape) => Ok(shape.textured()),
            Source::File(_) | Source::Spot => self.mesh(),
        }
    }

    /// The embedded texture of the mesh, as the bytes of a PNG file. Only `builtin:spot` has one.
    pub fn texture(&self) -> Option<&'static [u8]> {
        match self {
            Source::Spot => Some(SPOT_TEXTURE),
            Source::File(_) | Source::Shape(_) => None,
        }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Source::File(path) => path.display().fmt(f),
            Source::Shape(shape) => shape.fmt(f),
            Source::Spot => f.write_str("builtin:spot"),
        }
    }
}

/// The mesh that the argument MESH names, see [`Source::parse`].
///
/// # Errors
/// As [`Source::parse`] and [`Source::mesh`].
pub fn source(argument: impl AsRef<OsStr>) -> Result<Mesh> {
    Source::parse(argument)?.mesh()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Statistics;

    #[test]
    fn spot_is_closed_textured_and_resolved() {
        let mesh = source("builtin:spot").unwrap();
        let s = Statistics::of(&mesh);
        assert_eq!((s.vertices, s.faces), (46_850, 93_696));
        assert_eq!((s.euler_characteristic, s.boundary_edges), (2, 0));
        assert_eq!((s.components, s.inconsistent_edges), (1, 0));
        // The author's coordinates slightly leave the unit square.
        let uv = mesh.uv.unwrap();
        let mut numbers = uv.as_flattened().as_flattened().iter();
        assert!(numbers.all(|t| (-0.06..=1.01).contains(t)));
        let texture = Source::Spot.texture().unwrap();
        assert!(texture.starts_with(b"\x89PNG"));
    }

    #[test]
    fn arguments_name_files_shapes_and_examples() {
        let shape = |text: &str| Source::Shape(text.parse().unwrap());
        assert_eq!(Source::parse("torus:4x3").unwrap(), shape("torus:4x3"));
        assert_eq!(Source::parse("sphere:2").unwrap().to_string(), "sphere:2");
        for path in ["no/such.obj", "spot", "no:such.obj", "C:\\bunny.ply", ""] {
            assert_eq!(Source::parse(path).unwrap(), Source::File(path.into()));
            assert!(source(path).is_err());
        }
        for wrong in ["builtin:bunny", "builtin:", "torus:", "grid:0x1", "sphere:99"] {
            let message = Source::parse(wrong).unwrap_err().to_string();
            assert!(!message.contains('\n') && message.contains(wrong), "{message}");
        }
    }
}
