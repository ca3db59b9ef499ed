//! What data a mesh shows: the colors of its vertices, a texture, its mean curvature, or an array.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::range::robust_unit_range;
use super::texture::{Texture, colors_at_vertices};
use super::{Data, looks};
use crate::error::{Error, Result};
use crate::mesh::curvature::mean_curvature;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Source};
use crate::npy;
use crate::render::colormap::sequential;

/// `colors`, `texture:IMAGE`, `curvature` or `FILE.npy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    Colors,
    Texture(PathBuf),
    Curvature,
    File(PathBuf),
}

impl FromStr for DataSource {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("colors", _) => Ok(DataSource::Colors),
            ("curvature", _) => Ok(DataSource::Curvature),
            (_, Some(("texture", image))) if !image.is_empty() => {
                Ok(DataSource::Texture(image.into()))
            }
            (file, _) if file.ends_with(".npy") => Ok(DataSource::File(file.into())),
            _ => Err("must be colors, texture:IMAGE, curvature or FILE.npy".into()),
        }
    }
}

impl fmt::Display for DataSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            DataSource::Colors => f.write_str("colors"),
            DataSource::Texture(image) => write!(f, "texture:{}", image.display()),
            DataSource::Curvature => f.write_str("curvature"),
            DataSource::File(path) => path.display().fmt(f),
        }
    }
}

/// The data, how it looks, and what to call it.
pub struct Seen {
    pub data: Data,
    /// A color per vertex.
    pub looks: Vec<[f64; 3]>,
    pub name: String,
    /// What 0 and 1 stand for, if the data was mapped.
    pub unit_range: Option<[f64; 2]>,
}

/// The data of a mesh; without a choice the texture or the colors that come with it.
///
/// # Errors
/// Data that the mesh does not have, files that cannot be read or do not fit it.
pub fn see(source: &Source, mesh: &Mesh, choice: Option<&DataSource>) -> Result<Seen> {
    let name = PathBuf::from(source.to_string());
    let of_mesh = |error: Error| error.of_file(&name);
    match (choice, source.texture(), &mesh.colors) {
        (Some(DataSource::Texture(image)), ..) => {
            let texture = Texture::open(image)?;
            let colors = colors_at_vertices(mesh, &texture).map_err(of_mesh)?;
            colored(colors, format!("texture {}", image.display()))
        }
        (Some(DataSource::Curvature), ..) => {
            let (unit, range) = robust_unit_range(&mean_curvature(mesh), &barycentric_areas(mesh));
            Ok(Seen {
                looks: unit.iter().map(|&t| sequential(t)).collect(),
                data: Data::new(1, unit)?,
                name: "mean curvature".into(),
                unit_range: Some(range),
            })
        }
        (Some(DataSource::File(path)), ..) => numbers(mesh, path),
        (None, Some(bytes), _) => {
            let texture = Texture::decode(bytes, &name)?;
            colored(colors_at_vertices(mesh, &texture).map_err(of_mesh)?, "texture".into())
        }
        (Some(DataSource::Colors) | None, _, Some(colors)) => {
            colored(colors.clone(), "colors".into())
        }
        (Some(DataSource::Colors) | None, _, None) => Err(Error::unsuitable(format!(
            "{source}: has no vertex colors; choose --data texture:IMAGE, --data curvature or --data FILE.npy"
        ))),
    }
}

fn colored(colors: Vec<[f64; 3]>, name: String) -> Result<Seen> {
    let data = Data::new(3, colors.iter().flatten().copied().collect())?;
    Ok(Seen { data, looks: colors, name, unit_range: None })
}

/// Data from a file.
fn numbers(mesh: &Mesh, path: &Path) -> Result<Seen> {
    let array = npy::read_data(path)?;
    npy::check_rows(path, &array, mesh.vertices.len())?;
    let data = Data::new(array.ncols(), array.iter().copied().collect())?;
    let looks = looks::colors(&data, &barycentric_areas(mesh));
    Ok(Seen { data, looks, name: path.display().to_string(), unit_range: None })
}
