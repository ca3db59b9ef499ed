//! Arrays of NumPy, and errors.

use meshseg::{Error, sweep};
use ndarray::Array2;
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// `OSError` for what the system refuses, `ValueError` for anything else.
pub fn raised(error: Error) -> PyErr {
    match error {
        // Of the kind of the error, such as FileNotFoundError.
        Error::Io { ref source, .. } => {
            std::io::Error::new(source.kind(), error.to_string()).into()
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// What is computed without the lock of the interpreter, by threads that end with it: those of a pool that is shared
/// would be missing in a process that Python forks.
pub fn in_parallel<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| sweep::with_threads(None, work)).map_err(raised)
}

/// An array as the library owns it: one copy.
pub fn owned(array: &PyReadonlyArray2<'_, f64>) -> Array2<f64> {
    array.as_array().as_standard_layout().into_owned()
}

/// Triples of numbers as an N x 3 array.
pub fn of_triples<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    triples: &[[T; 3]],
) -> Bound<'py, PyArray2<T>> {
    let flat = triples.as_flattened();
    ndarray::ArrayView2::from_shape((triples.len(), 3), flat).expect("three each").to_pyarray(py)
}

/// The rows of an N x 3 array.
pub fn triples<T: numpy::Element + Copy>(
    name: &str,
    array: &PyReadonlyArray2<'_, T>,
) -> PyResult<Vec<[T; 3]>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        let message = format!("{name}: has the shape {:?}; it must be N x 3", array.shape());
        return Err(PyValueError::new_err(message));
    }
    Ok(array.outer_iter().map(|row| [row[0], row[1], row[2]]).collect())
}
