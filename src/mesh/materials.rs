//! The materials of faces: named, each with a color or an image.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Beyond this, a texture coordinate has no digits left for a position in an image.
const LARGEST_COORDINATE: f64 = 1e9;

/// Whether texture coordinates denote a position in an image.
pub fn is_position(t: [f64; 2]) -> bool {
    t.iter().all(|t| t.abs() <= LARGEST_COORDINATE)
}

/// The materials of a mesh, and the material of each face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// In the order of the file.
    pub all: Vec<Material>,
    /// F indices into `all`; `None` if a face has no material.
    pub of_faces: Vec<Option<u32>>,
}

/// One named material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// As in the file; for messages and for writing.
    pub name: String,
    /// The diffuse color (`Kd` of an MTL file), RGB in [0, 1].
    pub color: Option<[f64; 3]>,
    /// The image of its texture.
    pub image: Option<Image>,
    /// How the image is placed; without meaning if there is no image.
    pub placement: Placement,
}

/// The image of a texture.
#[derive(Clone, PartialEq, Eq, Hash)]
pub enum Image {
    /// A file, relative to the working directory.
    File(PathBuf),
    /// The name, and the content of a PNG or JPEG file, inside the file of the mesh.
    Inside(PathBuf, Arc<[u8]>),
}

impl Image {
    /// The file, or the name of an image that is in none.
    pub fn path(&self) -> &Path {
        match self {
            Image::File(path) | Image::Inside(path, _) => path,
        }
    }
}

impl fmt::Debug for Image {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Image::File(path) => formatter.debug_tuple("File").field(path).finish(),
            Image::Inside(name, bytes) => {
                formatter.debug_tuple("Inside").field(name).field(&bytes.len()).finish()
            }
        }
    }
}

/// The placement of an image in the plane of texture coordinates, which are scaled, then translated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The factors of u and v; 1 by default.
    pub scale: [f64; 2],
    /// The offsets added to u and v after scaling; 0 by default.
    pub offset: [f64; 2],
    /// Whether there is one copy of the image, whose edges extend beyond it, instead of many.
    pub clamp: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { scale: [1.0; 2], offset: [0.0; 2], clamp: false }
    }
}

impl Placement {
    /// Whether texture coordinates are unchanged.
    pub fn is_identity(&self) -> bool {
        let Placement { scale, offset, .. } = Placement::default();
        self.scale == scale && self.offset == offset
    }

    /// Its bits, as a key.
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

    /// The images, each once, and for each material the index of its image.
    pub fn images(&self) -> (Vec<&Path>, Vec<Option<usize>>) {
        let mut images: Vec<&Path> = Vec::new();
        let mut index_of = HashMap::new();
        let indices = self.all.iter().map(|material| {
            let image = material.image.as_ref()?.path();
            Some(*index_of.entry(image).or_insert_with(|| {
                images.push(image);
                images.len() - 1
            }))
        });
        let indices = indices.collect();
        (images, indices)
    }
}
