//! What faces are painted with: named materials, each with a color or an image.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

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

impl Materials {
    /// A name that no material has, for faces that have none.
    pub fn unused_name(&self) -> String {
        let mut name = "none".to_owned();
        while self.all.iter().any(|material| material.name == name) {
            name.push('_');
        }
        name
    }

    /// The images, each once, and the place there of each material's.
    pub fn images(&self) -> (Vec<&Path>, Vec<Option<usize>>) {
        let mut images: Vec<&Path> = Vec::new();
        let mut place_of = HashMap::new();
        let places = self.all.iter().map(|material| {
            let image = material.image.as_deref()?;
            Some(*place_of.entry(image).or_insert_with(|| {
                images.push(image);
                images.len() - 1
            }))
        });
        let places = places.collect();
        (images, places)
    }
}
