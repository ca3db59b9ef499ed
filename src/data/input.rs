//! The data of a mesh: the textures of its materials, the colors of its vertices or faces, an image mapped to it,
//! its curvature, views of calibrated cameras, or an array.

mod images;
mod own;
mod reader;
mod signal;
mod source;

use std::path::Path;

use ndarray::Array2;

use super::curved::{Curved, curved};
use super::views::{self, ViewOptions, Viewed};
use super::{Data, palette};
use crate::colormap::sequential;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Source, Weld, io};
use crate::npy;
use crate::unreached::INHERIT;

pub use images::{density, image_files};
pub use reader::{InputData, UnitRange};
pub use source::{DataSource, Mapping};

use own::Own;
use reader::Reader;
use signal::flatten;

/// Reads the data of a mesh; without a choice the textures or colors that belong to it. If the mesh was welded, arrays
/// have one row per vertex of the source, and merged vertices take the means.
///
/// Data that are constant up to rounding are made constant, with a warning, so that rounding errors are not segmented.
///
/// # Errors
/// The mesh does not have the requested data, or a file cannot be read or does not fit the mesh.
pub fn read(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    mapping: &Mapping,
) -> Result<InputData> {
    let input = read_choice(source, mesh, weld, choice, mapping)?;
    let what = if matches!(choice, Some(DataSource::File(_))) { "values" } else { "colors" };
    Ok(flattened(input, what))
}

/// The data in an array that would otherwise be read from the file of this name: one row per vertex, as it was before
/// the mesh was welded.
///
/// # Errors
/// The array does not fit the mesh, has no columns, or an entry is infinite.
pub fn of_array(
    path: &Path,
    array: &Array2<f64>,
    mesh: &Mesh,
    weld: Option<&Weld>,
) -> Result<InputData> {
    npy::check_data(path, array)?;
    Ok(flattened(numbers(path, array, mesh, weld)?, "values"))
}

/// Makes data constant that are so up to rounding.
fn flattened(mut input: InputData, what: &str) -> InputData {
    if input.unit_range.is_none()
        && let Some(found) = flatten(&mut input.data, what)
    {
        input.warnings.push(format!(
            "{}: {found}, so there is nothing to segment; choose other data",
            input.name
        ));
    }
    input
}

fn read_choice(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    mapping: &Mapping,
) -> Result<InputData> {
    if mapping.project.is_some() && !matches!(choice, Some(DataSource::Image(_))) {
        return Err(Error::unsuitable(
            "--project needs an image to project onto the mesh; name it with --data image:IMAGE",
        ));
    }
    let reader = Reader { source, mesh, mapping };
    match choice {
        None => reader.own(),
        Some(DataSource::Colors) => {
            match [Own::Vertices, Own::Faces].into_iter().find(|&own| reader.has(own)) {
                Some(own) => reader.read_own(own, true),
                None => Err(reader.lacks("has no colors of vertices, faces or materials")),
            }
        }
        Some(DataSource::Texture(image)) => reader.textures(image.as_deref(), true),
        Some(DataSource::Image(image)) => reader.image(image),
        Some(&DataSource::Curvature(kind)) => {
            let curved = curved(mesh, kind).map_err(|error| error.of_file(&reader.name()));
            let Curved { values, range, warnings } = curved?;
            Ok(InputData {
                colors: values.iter().map(|&t| sequential(t)).collect(),
                data: Data::new(1, values)?,
                name: kind.words().into(),
                unit_range: Some(UnitRange {
                    ends: range,
                    inverse_lengths: kind.inverse_lengths(),
                }),
                notes: Vec::new(),
                sign: kind.sign(),
                warnings,
                evidence: None,
                coverage: None,
            })
        }
        Some(DataSource::Views(file)) => seen(mesh, file, &mapping.views),
        Some(DataSource::File(path)) => numbers(path, &io::read_data(path)?, mesh, weld),
    }
}

/// The pixels of views.
fn seen(mesh: &Mesh, file: &Path, options: &ViewOptions) -> Result<InputData> {
    let Viewed { means: data, evidence, coverage } = views::read(file, mesh, options)?;
    Ok(InputData {
        colors: palette::colors(&data, &barycentric_areas(mesh)),
        data,
        name: format!("views {}", file.display()),
        unit_range: None,
        notes: vec![coverage.sentence()],
        sign: None,
        warnings: coverage.warnings.clone(),
        evidence: Some(evidence),
        coverage: Some(coverage),
    })
}

/// The data in the array of a file.
fn numbers(
    path: &Path,
    array: &Array2<f64>,
    mesh: &Mesh,
    weld: Option<&Weld>,
) -> Result<InputData> {
    npy::check_rows(path, array, weld.map_or(mesh.vertices.len(), |weld| weld.of.len()))?;
    let d = array.ncols();
    let mut values: Vec<f64> = array.iter().copied().collect();
    if let Some(weld) = weld {
        values = weld.means(&values, d);
    }
    let data = Data::new(d, values).map_err(|error| error.of_file(path))?;
    let colors = palette::colors(&data, &barycentric_areas(mesh));
    let name = path.display().to_string();
    let unknown = (0..data.len()).filter(|&k| !data.is_known(k)).count();
    let warnings = match unknown {
        0 => Vec::new(),
        _ => vec![format!(
            "{name}: {}; {INHERIT}",
            counted(unknown, "vertex has no data", "vertices have no data")
        )],
    };
    Ok(InputData {
        data,
        colors,
        name,
        unit_range: None,
        notes: Vec::new(),
        sign: None,
        warnings,
        evidence: None,
        coverage: None,
    })
}
