//! Reads meshes and arrays that belong together; errors name the file at fault.

use std::borrow::Cow;
use std::path::Path;

use ndarray::Array2;

use crate::domain::Element;
use crate::mesh::{Mesh, source};
use crate::operator::Mass;
use crate::solve::{check_mesh, check_rows_of_faces};
use crate::{Error, Result, costs, npy, regions, sweep};

use super::memory::Memory;

/// Reads the mesh of the argument MESH; at least one of its faces must have an area.
pub fn mesh_with_area(path: &Path) -> Result<Mesh> {
    let mesh = source(path)?;
    check_mesh(&mesh).map_err(|error| error.of_file(path))?;
    Ok(mesh)
}

/// Reads a mesh and pointwise costs on it, one row per vertex or face and one column per region, in parallel.
pub fn mesh_with_costs<'a>(
    mesh: &Path,
    path: &Path,
    on: Element,
    memory: &'a Memory,
) -> Result<(Cow<'a, Mesh>, Cow<'a, Array2<f64>>)> {
    let (read, costs) = sweep::join(|| memory.mesh(mesh), || memory.rows(path));
    let (read, costs) = (read?, costs?);
    check_mesh(&read).map_err(|error| error.of_file(mesh))?;
    let rows = costs.nrows();
    if on == Element::Vertices && rows != read.vertices.len() && rows == read.faces.len() {
        let message = format!("has {rows} rows, one per face: add --on faces");
        return Err(Error::malformed(path, message));
    }
    match on {
        Element::Vertices => npy::check_rows(path, &costs, read.vertices.len())?,
        Element::Faces => check_rows_of_faces("costs", costs.nrows(), &read)
            .map_err(|error| error.of_file(path))?,
    }
    regions::check(costs.ncols()).map_err(|error| error.of_file(path))?;
    costs::checked(&costs, Mass::Barycentric).map_err(|error| error.of_file(path))?;
    Ok((read, costs))
}
