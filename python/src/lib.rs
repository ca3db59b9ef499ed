//! The Python package `meshseg`: arrays of NumPy to and from the verbs of the program.
//!
//! Python's part turns keywords into the arguments of the command line; here a verb is called with what is in memory,
//! without the interpreter's lock. Signals are looked at every 50 ms, by the thread that called.

mod arrays;
mod call;
mod matrices;
mod mesh;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line, and returns its exit code. `program` are the words that start it anew.
#[pyfunction]
fn main(py: Python<'_>, program: Vec<OsString>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| meshseg::cli::main(&program, arguments))
}

#[pymodule]
fn _meshseg(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<mesh::Mesh>()?;
    module.add_function(wrap_pyfunction!(mesh::read_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(call::call, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::operators, module)?)?;
    module.add_function(wrap_pyfunction!(matrices::kmeans, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)
}
