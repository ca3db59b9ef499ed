//! The JSON of a glTF file, as far as meshes need it.
//!
//! ```text
//! scenes, nodes, meshes, accessors, bufferViews, buffers, materials, textures, images, samplers: lists, whose entries
//! refer to each other by their index from 0;  scene: the index of the default scene
//! ```
//!
//! Values of a wrong type are errors, except in materials and images, of which only that list, entry or name is missing
//! then. Unknown keys are skipped, and indices are checked where they are used.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 5, "Properties Reference".

use std::collections::HashMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
pub struct Document {
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Primitives>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<View>,
    pub buffers: Vec<Buffer>,
    #[serde(deserialize_with = "list")]
    pub materials: Vec<Entry<Material>>,
    #[serde(deserialize_with = "list")]
    pub textures: Vec<Entry<Texture>>,
    #[serde(deserialize_with = "list")]
    pub images: Vec<Entry<Image>>,
    #[serde(deserialize_with = "list")]
    pub samplers: Vec<Entry<Sampler>>,
}

/// An entry that may have values of a wrong type.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum Entry<T> {
    Valid(T),
    Invalid(IgnoredAny),
}

/// A list, or nothing in place of a value of another type.
fn list<'a, T: Deserialize<'a>, D: Deserializer<'a>>(from: D) -> Result<Vec<Entry<T>>, D::Error> {
    Ok(match Entry::deserialize(from)? {
        Entry::Valid(list) => list,
        Entry::Invalid(_) => Vec::new(),
    })
}

/// A text, or nothing in place of a value of another type.
fn text<'a, D: Deserializer<'a>>(from: D) -> Result<Option<String>, D::Error> {
    Ok(match Entry::deserialize(from)? {
        Entry::Valid(text) => Some(text),
        Entry::Invalid(_) => None,
    })
}

/// An entry of a list, if it exists and is valid.
pub fn entry<T>(list: &[Entry<T>], index: usize) -> Option<&T> {
    match list.get(index)? {
        Entry::Valid(entry) => Some(entry),
        Entry::Invalid(_) => None,
    }
}

#[derive(Deserialize)]
pub struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub struct Node {
    #[serde(default)]
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    /// Column by column.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// A quaternion x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

/// A mesh.
#[derive(Deserialize)]
pub struct Primitives {
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: HashMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    pub mode: Option<u32>,
    #[serde(default)]
    pub targets: Vec<IgnoredAny>,
    #[serde(default)]
    pub extensions: HashMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

/// Elements that replace some of those of the view.
#[derive(Deserialize)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparsePart {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct View {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    #[serde(default, deserialize_with = "text")]
    pub name: Option<String>,
    #[serde(rename = "pbrMetallicRoughness")]
    metallic: Option<Surface>,
    #[serde(default)]
    extensions: MaterialExtensions,
}

#[derive(Deserialize, Default)]
struct MaterialExtensions {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    glossy: Option<Surface>,
}

/// The color and the image of a material, in the names of its two kinds.
#[derive(Deserialize)]
pub struct Surface {
    #[serde(rename = "baseColorFactor", alias = "diffuseFactor")]
    pub color: Option<Vec<f64>>,
    #[serde(rename = "baseColorTexture", alias = "diffuseTexture")]
    pub texture: Option<TextureUse>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureUse {
    pub index: usize,
    tex_coord: Option<usize>,
    #[serde(default)]
    extensions: TextureExtensions,
}

#[derive(Deserialize, Default)]
struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureTransform {
    pub offset: Option<[f64; 2]>,
    #[serde(default)]
    pub rotation: f64,
    pub scale: Option<[f64; 2]>,
    tex_coord: Option<usize>,
}

#[derive(Deserialize)]
pub struct Texture {
    pub source: Option<usize>,
    pub sampler: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    #[serde(default, deserialize_with = "text")]
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Sampler {
    pub wrap_s: Option<u32>,
    pub wrap_t: Option<u32>,
}

impl Material {
    pub fn surface(&self) -> Option<&Surface> {
        self.metallic.as_ref().or(self.extensions.glossy.as_ref())
    }
}

impl TextureUse {
    pub fn transform(&self) -> Option<&TextureTransform> {
        self.extensions.transform.as_ref()
    }

    /// The n of `TEXCOORD_n`.
    pub fn set(&self) -> usize {
        let transform = self.transform().and_then(|transform| transform.tex_coord);
        transform.or(self.tex_coord).unwrap_or(0)
    }
}
