//! Numbers of vertices or faces that the mesh itself does not keep, such as class probabilities: properties of PLY,
//! arrays of VTK.

use ndarray::Array2;

/// The numbers of one element whose names match, in the order of the file.
pub struct Scalars {
    /// Whether they are those of faces.
    pub of_faces: bool,
    /// Their names.
    pub names: Vec<String>,
    /// One row per vertex or face of the file, one column per name.
    pub numbers: Array2<f64>,
}
