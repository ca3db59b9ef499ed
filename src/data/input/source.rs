//! How data are named, and how images are mapped to a mesh.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::data::projection::{Fit, Projection};
use crate::data::texture::Texel;

/// `colors`, `texture`, `texture:IMAGE`, `image:IMAGE`, `curvature` or `FILE.npy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    Colors,
    /// An image at the texture coordinates, or those that the materials name.
    Texture(Option<PathBuf>),
    /// An image laid on the surface.
    Image(PathBuf),
    Curvature,
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

/// How images come onto a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mapping {
    pub texel: Texel,
    /// Of `image:`; without it the texture coordinates, and xy for a grid.
    pub project: Option<Projection>,
    pub fit: Fit,
}
