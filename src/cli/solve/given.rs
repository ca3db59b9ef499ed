//! What is to be solved.

use std::path::Path;

use ndarray::Array2;

use crate::mesh::{Mesh, Weld};
use crate::seeds::Seeds;
use crate::start::Start;

/// A mesh with one row of costs, one seed and one row of a given start per vertex or face.
pub struct Given<'a> {
    pub mesh: &'a Mesh,
    /// The file of the mesh, if it has one.
    pub source: Option<&'a Path>,
    pub costs: &'a Array2<f64>,
    pub seeds: &'a Seeds,
    pub start: Start,
    /// The mesh with merged vertices, which has the faces of the file.
    pub weld: Option<&'a Weld>,
}
