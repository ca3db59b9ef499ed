//! Operators as the arrays of compressed sparse rows, and k-means.

use meshseg::data::kmeans as clusters;
use meshseg::mesh::geometry::{barycentric_areas, mixed_voronoi_areas};
use meshseg::operator::{Matrix, mass};
use meshseg::solve::model_mesh;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use sprs::CsMat;

use crate::arrays::{in_parallel, owned, raised};
use crate::mesh::Mesh;

/// K, M and the Laplacian as (data, indices, indptr, shape), the lumped masses and the areas of the faces as arrays.
#[pyfunction]
pub fn operators<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyDict>> {
    let found = in_parallel(py, || {
        let (model, warnings) = model_mesh(&mesh.mesh)?;
        let k = Matrix::new(&model);
        let matrices = [k.csr().clone(), mass::consistent_matrix(&model), k.laplacian()];
        let faces = (0..model.faces.len()).map(|j| model.face_area(j)).collect::<Vec<f64>>();
        let areas = [faces, barycentric_areas(&model), mixed_voronoi_areas(&model)];
        Ok((matrices, areas, warnings))
    })?;
    let ([k, m, laplacian], areas, warnings) = found.map_err(raised)?;
    let found = PyDict::new(py);
    for (name, matrix) in [("K", k), ("M", m), ("laplacian", laplacian)] {
        found.set_item(name, compressed(py, matrix))?;
    }
    for (name, numbers) in ["face_areas", "mass_barycentric", "mass_voronoi"].iter().zip(areas) {
        found.set_item(name, numbers.into_pyarray(py))?;
    }
    found.set_item("warnings", warnings)?;
    Ok(found)
}

type Compressed<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
    (usize, usize),
);

fn compressed(py: Python<'_>, matrix: CsMat<f64>) -> Compressed<'_> {
    let shape = matrix.shape();
    let (starts, indices, numbers) = matrix.into_raw_storage();
    let signed =
        |indices: Vec<usize>| -> Vec<i64> { indices.into_iter().map(|i| i as i64).collect() };
    let (indices, starts) = (signed(indices), signed(starts));
    (numbers.into_pyarray(py), indices.into_pyarray(py), starts.into_pyarray(py), shape)
}

/// The centers of area-weighted k-means, m x d.
#[pyfunction]
pub fn kmeans<'py>(
    py: Python<'py>,
    data: PyReadonlyArray2<'py, f64>,
    weights: PyReadonlyArray1<'py, f64>,
    regions: usize,
    seed: u64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (data, weights) = (owned(&data), weights.as_array().to_vec());
    if weights.len() != data.nrows() {
        let message = format!("weights: has {} numbers for {} rows", weights.len(), data.nrows());
        return Err(PyValueError::new_err(message));
    }
    if !weights.iter().all(|w| *w >= 0.0 && w.is_finite()) || !weights.iter().any(|w| *w > 0.0) {
        let message = "weights: must be finite, 0 or more, and not all 0";
        return Err(PyValueError::new_err(message));
    }
    if data.ncols() == 0 || !data.iter().all(|x| x.is_finite()) {
        return Err(PyValueError::new_err("data: must be finite numbers, with a column at least"));
    }
    meshseg::regions::check(regions).map_err(raised)?;
    let d = data.ncols();
    let centers = in_parallel(py, || {
        let mut rng = Pcg64::seed_from_u64(seed);
        let data = data.as_slice().expect("in standard layout");
        clusters::kmeans(data, d, &weights, regions, &mut rng)
    })?;
    let flat: Vec<f64> = centers.into_iter().flatten().collect();
    let centers = ndarray::Array2::from_shape_vec((regions, d), flat).expect("rows of d numbers");
    Ok(centers.into_pyarray(py))
}
