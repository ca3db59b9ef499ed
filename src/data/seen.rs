//! What data a mesh shows: the textures of its materials, the colors of its vertices or faces, an image laid on
//! it, its mean curvature, or an array.

mod images;
mod own;
mod signal;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::curved::{Curved, SIGN, curved};
use super::projection::{Fit, Projection};
use super::texture::Texel;
use super::{Data, looks};
use crate::colormap::sequential;
use crate::error::{Error, Result};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Source, Weld};
use crate::npy;
use crate::unreached::INHERIT;

pub use images::image_files;

use own::Own;
use signal::flatten;

/// `colors`, `texture`, `texture:IMAGE`, `image:IMAGE`, `curvature` or `FILE.npy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    /// The colors of the vertices, or else those of the faces and their materials.
    Colors,
    /// The images that the materials name, or a given one, at the texture coordinates of the mesh.
    Texture(Option<PathBuf>),
    /// An image laid on the surface by a projection, or at the texture coordinates, see [`Manner::project`].
    Image(PathBuf),
    /// The mean curvature, see [`curved`].
    Curvature,
    /// An array of V or V x d numbers in a `.npy` file, see [`npy::read_data`].
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
pub struct Manner {
    /// What a vertex takes of an image.
    pub texel: Texel,
    /// Of `image:`; without it the texture coordinates, and xy for a grid.
    pub project: Option<Projection>,
    /// How a plane projection treats the aspect of an image.
    pub fit: Fit,
}

/// The data, how it looks, and what to call it.
pub struct Seen {
    /// V x d values.
    pub data: Data,
    /// A color per vertex; NaN where the data are unknown.
    pub looks: Vec<[f64; 3]>,
    /// Such as `mean curvature`, `colors`, or the path of an array; for captions.
    pub name: String,
    /// What 0 and 1 stand for, if the data was mapped.
    pub unit_range: Option<[f64; 2]>,
    /// What was chosen, and what else there is to choose, a line each.
    pub notes: Vec<String>,
    /// What the sign of the data means, if it has a meaning that is not plain.
    pub sign: Option<&'static str>,
    /// What the user should know, a sentence each.
    pub warnings: Vec<String>,
}

/// The data of a mesh; without a choice the textures or the colors that come with it. If the mesh is what a weld made
/// of that of the source, arrays have a row for every vertex of the source, and the merged ones take their means.
///
/// Data that are the same everywhere to rounding become the same, with a warning: nothing is stretched.
///
/// # Errors
/// Data that the mesh does not have, files that cannot be read or do not fit it.
pub fn see(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    manner: &Manner,
) -> Result<Seen> {
    let mut seen = look(source, mesh, weld, choice, manner)?;
    let what = if matches!(choice, Some(DataSource::File(_))) { "values" } else { "colors" };
    if seen.unit_range.is_none()
        && let Some(found) = flatten(&mut seen.data, what)
    {
        seen.warnings.push(format!(
            "{}: {found}: there is nothing to segment; choose other data",
            seen.name
        ));
    }
    Ok(seen)
}

fn look(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    manner: &Manner,
) -> Result<Seen> {
    if manner.project.is_some() && !matches!(choice, Some(DataSource::Image(_))) {
        return Err(Error::unsuitable(
            "--project lays an image on the mesh; name it by --data image:IMAGE",
        ));
    }
    let view = View { source, mesh, manner };
    match choice {
        None => view.own(),
        Some(DataSource::Colors) => {
            match [Own::Vertices, Own::Faces].into_iter().find(|&own| view.has(own)) {
                Some(own) => view.see_own(own, true),
                None => Err(view.lacks("has no colors of vertices, faces or materials")),
            }
        }
        Some(DataSource::Texture(image)) => view.textures(image.as_deref(), true),
        Some(DataSource::Image(image)) => view.image(image),
        Some(DataSource::Curvature) => {
            let curved = curved(mesh).map_err(|error| error.of_file(&view.name()));
            let Curved { values, range, warnings } = curved?;
            Ok(Seen {
                looks: values.iter().map(|&t| sequential(t)).collect(),
                data: Data::new(1, values)?,
                name: "mean curvature".into(),
                unit_range: Some(range),
                notes: Vec::new(),
                sign: Some(SIGN),
                warnings,
            })
        }
        Some(DataSource::File(path)) => numbers(mesh, weld, path),
    }
}

/// A mesh that is looked at.
struct View<'a> {
    source: &'a Source,
    mesh: &'a Mesh,
    manner: &'a Manner,
}

impl View<'_> {
    fn name(&self) -> PathBuf {
        self.source.to_string().into()
    }
}

fn colored(colors: Vec<[f64; 3]>, name: String) -> Result<Seen> {
    let data = Data::new(3, colors.as_flattened().to_vec())?;
    Ok(Seen {
        data,
        looks: colors,
        name,
        unit_range: None,
        notes: Vec::new(),
        sign: None,
        warnings: Vec::new(),
    })
}

/// Data from a file.
fn numbers(mesh: &Mesh, weld: Option<&Weld>, path: &Path) -> Result<Seen> {
    let array = npy::read_data(path)?;
    npy::check_rows(path, &array, weld.map_or(mesh.vertices.len(), |weld| weld.of.len()))?;
    let d = array.ncols();
    let mut values: Vec<f64> = array.iter().copied().collect();
    if let Some(weld) = weld {
        values = weld.means(&values, d);
    }
    let data = Data::new(d, values).map_err(|error| error.of_file(path))?;
    let looks = looks::colors(&data, &barycentric_areas(mesh));
    let name = path.display().to_string();
    let unknown = (0..data.len()).filter(|&k| !data.is_known(k)).count();
    let warnings = match unknown {
        0 => Vec::new(),
        _ => vec![format!("{name}: nothing is known of {unknown} vertices; {INHERIT}")],
    };
    Ok(Seen { data, looks, name, unit_range: None, notes: Vec::new(), sign: None, warnings })
}
