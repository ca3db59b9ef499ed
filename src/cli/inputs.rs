//! Reads meshes and arrays that belong together; errors name the file at fault.

use std::path::Path;

use meshseg::mesh::{Mesh, source};
use meshseg::operator::Mass;
use meshseg::solve::check_mesh;
use meshseg::{Result, costs, npy, regions, sweep};
use ndarray::Array2;

/// Reads the mesh of the argument MESH; at least one of its faces must have an area.
pub fn mesh_with_area(path: &Path) -> Result<Mesh> {
    let mesh = source(path)?;
    check_mesh(&mesh).map_err(|error| error.of_file(path))?;
    Ok(mesh)
}

/// Reads a mesh and pointwise costs on it, one row per vertex and one column per region, in parallel.
pub fn mesh_with_costs(mesh: &Path, path: &Path) -> Result<(Mesh, Array2<f64>)> {
    let (mesh, costs) = sweep::join(|| mesh_with_area(mesh), || npy::read_rows(path));
    let (mesh, costs) = (mesh?, costs?);
    npy::check_rows(path, &costs, mesh.vertices.len())?;
    regions::check(costs.ncols()).map_err(|error| error.of_file(path))?;
    costs::checked(&costs, Mass::Barycentric).map_err(|error| error.of_file(path))?;
    Ok((mesh, costs))
}
