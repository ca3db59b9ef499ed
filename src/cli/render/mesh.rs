//! A mesh, with its data and with regions from files.

use std::path::PathBuf;

use crate::Result;
use crate::mesh::Source;
use crate::solve::check_mesh;

use super::arguments::Arguments;
use super::data::Data;
use super::input::{Input, Labeled, labels_of, of_u};

/// Reads the mesh, and the data and regions that the arguments name. Fails if a file cannot be read or does not fit the
/// mesh.
pub fn read(arguments: &Arguments) -> Result<Input> {
    let source = Source::parse(&arguments.surface)?;
    let mesh = source.mesh()?;
    check_mesh(&mesh).map_err(|error| error.of_file(&arguments.surface))?;
    let of_u = |path: &PathBuf| of_u(path, mesh.vertices.len());
    let u = arguments.u.as_ref().map(of_u).transpose()?;
    let labels = arguments.labels.as_ref().filter(|_| u.is_none());
    let labels = labels.map(|path| labels_of(path, &mesh)).transpose()?;
    let has_regions = u.is_some() || labels.is_some();
    let data = Data::read(&source, &mesh, arguments.data.as_ref(), &arguments.mapping());
    let mut lacking_data = String::new();
    let (data, notes) = match data {
        Ok((data, notes)) => (Some(data), notes),
        // Regions can be shown without the data that come with the mesh.
        Err(error) if has_regions && arguments.data.is_none() => {
            lacking_data = error.to_string();
            (None, Vec::new())
        }
        Err(error) => return Err(error),
    };
    let (mesh, data, regions) = match labels {
        None => (mesh, data, u),
        Some((on, labels)) => {
            let labeled = Labeled::new(mesh, (on, &labels), 1, None);
            let data = data.map(|data| labeled.data(data));
            (labeled.mesh, data, Some(labeled.regions))
        }
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
