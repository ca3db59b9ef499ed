//! The names of data, and how images are mapped to a mesh.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::data::projection::{Fit, Projection};
use crate::data::texture::Texel;

/// `colors`, `texture`, `texture:IMAGE`, `image:IMAGE`, `curvature` or `FILE.npy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    /// The colors of the vertices, or else those of the faces and their materials.
    Colors,
    /// The images of the materials, or a given one, by the texture coordinates of the mesh.
    Texture(Option<PathBuf>),
    /// An image on the surface by a projection or by the texture coordinates, see [`Mapping::project`].
    Image(PathBuf),
    /// The mean curvature, see `curved.rs`.
    Curvature,
    /// An array of V or V x d numbers in a `.npy` file, see [`read_data`](crate::npy::read_data).
    File(PathBuf),
}

impl DataSource {
    /// The forms that [`DataSource::from_str`] takes.
    pub const SYNTAX: &str = "colors, texture, texture:IMAGE, image:IMAGE, curvature or FILE.npy";
}

impl FromStr for DataSource {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("colors", _) => Ok(DataSource::Colors),
            ("curvature", _) => Ok(DataSource::Curvature),
            ("texture", _) => Ok(DataSource::Texture(None)),
            (_, Some(("texture", image))) if !image.is_empty() => {
                Ok(DataSource::Texture(Some(image.into())))
            }
            (_, Some(("image", image))) if !image.is_empty() => Ok(DataSource::Image(image.into())),
            (file, _) if file.ends_with(".npy") => Ok(DataSource::File(file.into())),
            _ => Err(format!("must be {}", DataSource::SYNTAX)),
        }
    }
}

impl fmt::Display for DataSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            DataSource::Colors => f.write_str("colors"),
            DataSource::Texture(None) => f.write_str("texture"),
            DataSource::Texture(Some(image)) => write!(f, "texture:{}", image.display()),
            DataSource::Image(image) => write!(f, "image:{}", image.display()),
            DataSource::Curvature => f.write_str("curvature"),
            DataSource::File(path) => path.display().fmt(f),
        }
    }
}

/// How images are mapped to a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mapping {
    /// What a vertex takes of an image.
    pub texel: Texel,
    /// The projection of `image:`; by default xy for a grid, else the texture coordinates.
    pub project: Option<Projection>,
    /// How a plane projection treats the aspect of an image.
    pub fit: Fit,
}
