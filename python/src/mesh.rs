//! `Mesh`: vertices and faces, held once for many calls.

use std::path::PathBuf;

use meshseg::counted::counted;
use meshseg::mesh::source;
use nalgebra::Point3;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{in_parallel, of_triples, raised, triples};

/// A triangle mesh; `meshseg.Mesh` describes it.
#[pyclass(module = "meshseg._meshseg", frozen)]
pub struct Mesh {
    pub mesh: meshseg::Mesh,
    /// Where it was read, so that the images of its materials are found.
    pub path: Option<PathBuf>,
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (vertices, faces, colors=None, face_colors=None))]
    fn new(
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, i64>,
        colors: Option<PyReadonlyArray2<'_, f64>>,
        face_colors: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        let points = triples("vertices", &vertices)?;
        if let Some(v) = points.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
            let message = format!("vertices: row {v} has an entry that is not finite");
            return Err(PyValueError::new_err(message));
        }
        let count = points.len();
        let index = |(j, corners): (usize, [i64; 3])| {
            let inside = corners.iter().all(|&v| (0..count as i64).contains(&v));
            let inside = inside && count <= u32::MAX as usize;
            inside.then(|| corners.map(|v| v as u32)).ok_or_else(|| {
                PyValueError::new_err(format!(
                    "faces: row {j} is {corners:?}; the {count} vertices are numbered from 0"
                ))
            })
        };
        let faces = triples("faces", &faces)?.into_iter().enumerate().map(index);
        let faces = faces.collect::<PyResult<Vec<_>>>()?;
        let color = |name: &str, rows: Option<PyReadonlyArray2<'_, f64>>, needed: usize| {
            let Some(rows) = rows else { return Ok(None) };
            let rows = triples(name, &rows)?;
            match rows.len() == needed {
                true => Ok(Some(rows)),
                false => Err(PyValueError::new_err(format!(
                    "{name}: has {} rows; the mesh needs {needed}",
                    rows.len()
                ))),
            }
        };
        let colors = color("colors", colors, count)?;
        let face_colors = color("face_colors", face_colors, faces.len())?;
        let vertices = points.into_iter().map(Point3::from).collect();
        let mesh = meshseg::Mesh { colors, face_colors, ..meshseg::Mesh::new(vertices, faces) };
        Ok(Mesh { mesh, path: None })
    }

    /// V x 3 positions.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let rows: Vec<[f64; 3]> = self.mesh.vertices.iter().map(|x| [x.x, x.y, x.z]).collect();
        of_triples(py, &rows)
    }

    /// F x 3 indices of vertices.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        of_triples(py, &self.mesh.faces)
    }

    /// V x 3 colors in [0, 1], or None.
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        self.mesh.colors.as_ref().map(|colors| of_triples(py, colors))
    }

    /// F x 3 colors in [0, 1], or None.
    #[getter]
    fn face_colors<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        self.mesh.face_colors.as_ref().map(|colors| of_triples(py, colors))
    }

    /// The total area, in squared units of the mesh.
    #[getter]
    fn area(&self, py: Python<'_>) -> PyResult<f64> {
        in_parallel(py, || self.mesh.area())
    }

    /// Where it was read.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.path.clone()
    }

    fn __repr__(&self) -> String {
        let (vertices, faces) = (self.mesh.vertices.len(), self.mesh.faces.len());
        let [vertices, faces] = [(vertices, "vertex", "vertices"), (faces, "face", "faces")]
            .map(|(n, one, many)| counted(n, one, many));
        format!("Mesh({vertices}, {faces})")
    }
}

/// The mesh of a file, of `builtin:spot`, or of a shape.
#[pyfunction]
pub fn read_mesh(py: Python<'_>, path: PathBuf) -> PyResult<Mesh> {
    let mesh = in_parallel(py, || source(&path))?.map_err(raised)?;
    Ok(Mesh { mesh, path: Some(path) })
}
