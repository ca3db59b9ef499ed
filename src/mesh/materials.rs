//! What faces are painted with: named materials, each with a color or an image.

use std::path::PathBuf;

/// The materials of a mesh, and which face has which.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    pub all: Vec<Material>,
    /// F places in `all`; none where a face has no material.
    pub of_faces: Vec<Option<u32>>,
}

/// One material, by the name that its file gives it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    pub name: String,
    /// The diffuse color (`Kd` of an MTL file), RGB in [0, 1].
    pub color: Option<[f64; 3]>,
    /// The image of its texture, as found from where the program runs.
    pub image: Option<PathBuf>,
}
