//! Meshes and arrays that fit each other; what does not fit is blamed on its file.

use std::path::Path;

use meshseg::mesh::{Mesh, source};
use meshseg::operator::Mass;
use meshseg::solve::check_mesh;
use meshseg::{Result, costs, npy, regions, sweep};
use ndarray::Array2;

/// The mesh of the argument MESH; at least one of its faces has an area.
fn mesh_with_area(path: &Path) -> Result<Mesh> {
    let mesh = source(path)?;
    check_mesh(&mesh).map_err(|error| error.of_file(path))?;
    Ok(mesh)
}

/// A mesh and pointwise costs on it: one row per vertex, one column per region. Both files are read at once.
pub fn mesh_with_costs(mesh: &Path, path: &Path) -> Result<(Mesh, Array2<f64>)> {
    let (mesh, costs) = sweep::join(|| mesh_with_area(mesh), || npy::read_rows(path));
    let (mesh, costs) = (mesh?, costs?);
    npy::check_rows(path, &costs, mesh.vertices.len())?;
    regions::check(costs.ncols()).map_err(|error| error.of_file(path))?;
    costs::checked(&costs, Mass::Barycentric).map_err(|error| error.of_file(path))?;
    Ok((mesh, costs))
}
