//! A mesh, with its data and with regions from files.

use crate::Result;
use crate::mesh::Source;
use crate::solve::check_mesh;

use super::arguments::Arguments;
use super::data::Data;
use super::input::{Input, of_labels, of_u};

/// Reads the mesh, and the data and regions that the arguments name. Fails if a file cannot be read or does not fit the
/// mesh.
pub fn read(arguments: &Arguments) -> Result<Input> {
    let source = Source::parse(&arguments.surface)?;
    let mesh = source.mesh()?;
    check_mesh(&mesh).map_err(|error| error.of_file(&arguments.surface))?;
    let count = mesh.vertices.len();
    let regions = match (&arguments.u, &arguments.labels) {
        (Some(path), _) => Some(of_u(path, count)?),
        (None, Some(path)) => Some(of_labels(path, count, 1, None)?),
        (None, None) => None,
    };
    let data = Data::read(&source, &mesh, arguments.data.as_ref(), &arguments.mapping());
    let mut lacking_data = String::new();
    let (data, notes) = match data {
        Ok((data, notes)) => (Some(data), notes),
        // Regions can be shown without the data that come with the mesh.
        Err(error) if regions.is_some() && arguments.data.is_none() => {
            lacking_data = error.to_string();
            (None, Vec::new())
        }
        Err(error) => return Err(error),
    };
    Ok(Input {
        mesh,
        data,
        regions,
        means: None,
        notes,
        lacking: [
            lacking_data,
            "there are no regions; supply them with --u U.npy or --labels LABELS.npy, or name the folder of a run"
                .into(),
        ],
    })
}
