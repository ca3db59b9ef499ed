//! What faces are painted with: named materials, each with a color or an image.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Beyond this a texture coordinate has no digits left for a place in an image.
const LARGEST_COORDINATE: f64 = 1e9;

/// Whether texture coordinates are a place in an image.
pub fn is_place(t: [f64; 2]) -> bool {
    t.iter().all(|t| t.abs() <= LARGEST_COORDINATE)
}

/// The materials of a mesh, and which face has which.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// In the order of the file.
    pub all: Vec<Material>,
    /// F indices in `all`; none where a face has no material.
    pub of_faces: Vec<Option<u32>>,
}

/// One material, by the name that its file gives it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// As in the file, for messages and for writing it.
    pub name: String,
    /// The diffuse color (`Kd` of an MTL file), RGB in [0, 1].
    pub color: Option<[f64; 3]>,
    /// The image of its texture, as found from where the program runs.
    pub image: Option<PathBuf>,
    /// How the image lies; without an image it means nothing.
    pub placement: Placement,
}

/// Where an image lies in the plane of texture coordinates: they are scaled, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The factors of u and v; 1 by default.
    pub scale: [f64; 2],
    /// What is added to u and v once they are scaled; 0 by default.
    pub offset: [f64; 2],
    /// Whether there is one copy of the image, whose edges go on, instead of many.
    pub clamp: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { scale: [1.0; 2], offset: [0.0; 2], clamp: false }
    }
}

impl Placement {
    /// Whether texture coordinates stay what they are.
    pub fn moves_nothing(&self) -> bool {
        let Placement { scale, offset, .. } = Placement::default();
        self.scale == scale && self.offset == offset
    }

    /// What tells it from others.
    pub fn bits(&self) -> [u64; 5] {
        let [[a, b], [c, d]] = [self.scale, self.offset];
        [a.to_bits(), b.to_bits(), c.to_bits(), d.to_bits(), u64::from(self.clamp)]
    }

    /// The coordinates of a face in the image.
    pub fn of(&self, uv: &[[f64; 2]; 3]) -> [[f64; 2]; 3] {
        uv.map(|t| [0, 1].map(|axis| self.scale[axis] * t[axis] + self.offset[axis]))
    }
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

    /// The images, each once, and the index of each material's among them.
    pub fn images(&self) -> (Vec<&Path>, Vec<Option<usize>>) {
        let mut images: Vec<&Path> = Vec::new();
        let mut index_of = HashMap::new();
        let indices = self.all.iter().map(|material| {
            let image = material.image.as_deref()?;
            Some(*index_of.entry(image).or_insert_with(|| {
                images.push(image);
                images.len() - 1
            }))
        });
        let indices = indices.collect();
        (images, indices)
    }
}
