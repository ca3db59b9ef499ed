//! Meshes and arrays that fit each other; what does not fit is blamed on its file.

use std::path::Path;

use meshseg::mesh::{Mesh, source};
use meshseg::solve::model_mesh;
use meshseg::{Error, Result, npy, regions, sweep};
use ndarray::Array2;

/// Puts the name of the file in front of what is wrong with its content.
pub fn blame<T>(path: &Path, result: Result<T>) -> Result<T> {
    result.map_err(|error| match error {
        Error::Unsuitable(message) => Error::malformed(path, message),
        other => other,
    })
}

/// The mesh of the argument MESH; at least one of its faces has an area.
fn mesh_with_area(path: &Path) -> Result<Mesh> {
    let mesh = source(path)?;
    blame(path, model_mesh(&mesh))?;
    Ok(mesh)
}

/// A mesh and pointwise costs on it: one row per vertex, one column per region. Both files are read at once.
pub fn mesh_with_costs(mesh: &Path, path: &Path) -> Result<(Mesh, Array2<f64>)> {
    let (mesh, costs) = sweep::join(|| mesh_with_area(mesh), || npy::read_matrix(path));
    let (mesh, costs) = (mesh?, costs?);
    check_rows(path, &costs, &mesh)?;
    blame(path, regions::check(costs.ncols()))?;
    Ok((mesh, costs))
}

pub fn check_rows(path: &Path, array: &Array2<f64>, mesh: &Mesh) -> Result<()> {
    let (rows, vertices) = (array.nrows(), mesh.vertices.len());
    if rows == vertices {
        return Ok(());
    }
    let message =
        format!("has {rows} rows, the mesh {vertices} vertices; one row per vertex is needed");
    Err(Error::malformed(path, message))
}
