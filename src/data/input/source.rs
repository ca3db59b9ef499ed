//! The names of data, and how images are mapped to a mesh.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::data::projection::{Fit, Projection};
use crate::data::texture::Texel;
use crate::data::views::ViewOptions;
use crate::mesh::curvature::CurvatureKind;
use crate::mesh::io;
use crate::names::{Named, must_be_one_of};

/// `colors`, `texture`, `texture:IMAGE`, `image:IMAGE`, `curvature`, `curvature:KIND`,
/// `views:FILE`, `FILE.npy`, `FILE.gii`, `FILE.annot`, or `lh.NAME` and `rh.NAME` of FreeSurfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    /// The colors of the vertices, or else those of the faces and their materials.
    Colors,
    /// The images of the materials, or a given one, by the texture coordinates of the mesh.
    Texture(Option<PathBuf>),
    /// An image on the surface by a projection or by the texture coordinates, see [`Mapping::project`].
    Image(PathBuf),
    /// A curvature of the surface, see `curved.rs`; `curvature` alone is the mean curvature.
    Curvature(CurvatureKind),
    /// Images of calibrated cameras, from a file of views, see [`views`](crate::data::views).
    Views(PathBuf),
    /// An array of V or V x d numbers in a file of NumPy, GIFTI or FreeSurfer, see [`read_data`](io::read_data).
    File(PathBuf),
}

impl DataSource {
    /// The forms that [`DataSource::from_str`] takes.
    pub const SYNTAX: &str = "colors, texture, texture:IMAGE, image:IMAGE, curvature, curvature:mean-quadric, \
                              curvature:gaussian, curvature:shape-index, views:FILE, FILE.npy, FILE.gii, FILE.annot or lh.NAME";
}

impl FromStr for DataSource {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("colors", _) => Ok(DataSource::Colors),
            ("curvature", _) => Ok(DataSource::Curvature(CurvatureKind::Mean)),
            (_, Some(("curvature", kind))) => {
                let names = CurvatureKind::names();
                let kind = CurvatureKind::named(kind);
                kind.map(DataSource::Curvature)
                    .ok_or_else(|| format!("the kind of curvature {}", must_be_one_of(names)))
            }
            ("texture", _) => Ok(DataSource::Texture(None)),
            (_, Some(("texture", image))) if !image.is_empty() => {
                Ok(DataSource::Texture(Some(image.into())))
            }
            (_, Some(("image", image))) if !image.is_empty() => Ok(DataSource::Image(image.into())),
            (_, Some(("views", file))) if !file.is_empty() => Ok(DataSource::Views(file.into())),
            (file, _) if file.ends_with(".npy") || io::names_values(Path::new(file)) => {
                Ok(DataSource::File(file.into()))
            }
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
            DataSource::Curvature(CurvatureKind::Mean) => f.write_str("curvature"),
            DataSource::Curvature(kind) => write!(f, "curvature:{}", kind.name()),
            DataSource::Views(file) => write!(f, "views:{}", file.display()),
            DataSource::File(path) => path.display().fmt(f),
        }
    }
}

/// How images are mapped to a mesh.
#[derive(Clone, Debug, Default)]
pub struct Mapping {
    /// What a vertex takes of an image.
    pub texel: Texel,
    /// The projection of `image:`; by default xy for a grid, else the texture coordinates.
    pub project: Option<Projection>,
    /// How a plane projection treats the aspect of an image.
    pub fit: Fit,
    /// Which pixels of views count.
    pub views: ViewOptions,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_round_trips_and_errors_list_the_names() {
        for text in [
            "colors",
            "texture",
            "texture:a.png",
            "image:b.jpg",
            "curvature",
            "views:v.toml",
            "d.npy",
            "a.func.gii",
            "subject/surf/lh.thickness",
            "rh.aparc.annot",
        ] {
            assert_eq!(text.parse::<DataSource>().unwrap().to_string(), text);
        }
        for &name in CurvatureKind::names() {
            let text = format!("curvature:{name}");
            let source: DataSource = text.parse().unwrap();
            assert_eq!(source, DataSource::Curvature(CurvatureKind::named(name).unwrap()));
            assert_eq!(source.to_string().parse(), Ok(source));
            assert!(name == "mean" || DataSource::SYNTAX.contains(&text), "{text}");
        }
        for text in ["curvature:", "curvature:mean-cotangent", "curvature:Gaussian"] {
            assert_eq!(
                text.parse::<DataSource>(),
                Err("the kind of curvature must be one of mean, mean-quadric, gaussian, shape-index"
                    .into())
            );
        }
        for text in ["curved", "lh", "surf/xlh.curv", "lh.curv/data", "lh.data.csv"] {
            let expected = format!("must be {}", DataSource::SYNTAX);
            assert_eq!(text.parse::<DataSource>(), Err(expected));
        }
    }
}
