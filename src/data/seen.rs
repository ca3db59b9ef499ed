//! What data a mesh shows: the colors of its vertices, a texture, its mean curvature, or an array.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::Data;
use super::curved::{Curved, SIGN, curved};
use super::range::robust_unit_range;
use super::texture::{Texture, colors_at_vertices};
use crate::error::{Error, Result};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Source, Weld};
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
    /// What the sign of the data means, if it has a meaning that is not plain.
    pub sign: Option<&'static str>,
    pub warnings: Vec<String>,
}

/// The data of a mesh; without a choice the texture or the colors that come with it. If the mesh is what a weld made
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
) -> Result<Seen> {
    let mut seen = look(source, mesh, weld, choice)?;
    if seen.unit_range.is_none() && flatten(&mut seen.data) {
        let what = if matches!(choice, Some(DataSource::File(_))) { "values" } else { "color" };
        seen.warnings.push(format!(
            "{}: all vertices have the same {what}: there is nothing to segment",
            seen.name
        ));
    }
    Ok(seen)
}

/// Differences below this share of the data are rounding.
const ROUNDING: f64 = 1e-9;

/// Makes data constant that are so up to rounding, in each coordinate and where they are known.
fn flatten(data: &mut Data) -> bool {
    let known = |row: &&[f64]| row.iter().all(|x| !x.is_nan());
    let Some(first) = data.values.chunks(data.dimension).find(known).map(<[f64]>::to_vec) else {
        return false;
    };
    let same = |i: usize| {
        let column = data.values.iter().skip(i).step_by(data.dimension).filter(|x| !x.is_nan());
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = column.fold(extremes, |(low, high), &x| (x.min(low), x.max(high)));
        high - low <= ROUNDING * low.abs().max(high.abs())
    };
    if !(0..data.dimension).all(same) {
        return false;
    }
    for row in data.values.chunks_mut(data.dimension).filter(|row| known(&&**row)) {
        row.copy_from_slice(&first);
    }
    true
}

fn look(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
) -> Result<Seen> {
    let name = PathBuf::from(source.to_string());
    let of_mesh = |error: Error| error.of_file(&name);
    match (choice, source.texture(), &mesh.colors) {
        (Some(DataSource::Texture(image)), ..) => {
            let texture = Texture::open(image)?;
            let colors = colors_at_vertices(mesh, &texture).map_err(of_mesh)?;
            colored(colors, format!("texture {}", image.display()))
        }
        (Some(DataSource::Curvature), ..) => {
            let Curved { values, range, warnings } = curved(mesh).map_err(of_mesh)?;
            Ok(Seen {
                looks: values.iter().map(|&t| sequential(t)).collect(),
                data: Data::new(1, values)?,
                name: "mean curvature".into(),
                unit_range: Some(range),
                sign: Some(SIGN),
                warnings,
            })
        }
        (Some(DataSource::File(path)), ..) => numbers(mesh, weld, path),
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
    Ok(Seen { data, looks: colors, name, unit_range: None, sign: None, warnings: Vec::new() })
}

/// Data from a file; three columns within [0, 1] look like the colors they are, others like their first
/// column.
fn numbers(mesh: &Mesh, weld: Option<&Weld>, path: &Path) -> Result<Seen> {
    let array = npy::read_data(path)?;
    npy::check_rows(path, &array, weld.map_or(mesh.vertices.len(), |weld| weld.of.len()))?;
    let d = array.ncols();
    let mut values: Vec<f64> = array.iter().copied().collect();
    if let Some(weld) = weld {
        values = weld.means(&values, d);
    }
    let looks = if d == 3 && values.iter().all(|x| (0.0..=1.0).contains(x)) {
        values.as_chunks::<3>().0.to_vec()
    } else {
        let first: Vec<f64> = values.iter().copied().step_by(d).collect();
        let (unit, _) = robust_unit_range(&first, &barycentric_areas(mesh));
        unit.into_iter().map(sequential).collect()
    };
    let data = Data::new(d, values)?;
    let name = path.display().to_string();
    Ok(Seen { data, looks, name, unit_range: None, sign: None, warnings: Vec::new() })
}
