//! glTF 2.0: `.gltf` (JSON, with its buffers inside as data URIs or next to it) and `.glb` (both in one file).
//!
//! ```text
//! scene -> nodes -> mesh -> primitives -> accessors -> bufferViews -> buffers
//! x = G POSITION,  G = G_parent N,  N = matrix or T R S     a node N, in f64
//! primitive: attributes POSITION, COLOR_0, TEXCOORD_n, indices, material, mode
//! (u, v) = (s, 1 - t)                                       TEXCOORD_n = (s, t) has t downwards
//! ```
//!
//! The default scene is read, or the first one, or all nodes if there are no scenes, or all meshes if there are no
//! nodes. A node is the unit: its primitives share their vertices if they share their positions, since programs split
//! meshes by material; all other vertices stay separate. Vertices and faces are in the order of nodes, primitives and
//! accessors. Transforms that mirror also turn the faces, so that their orientation stays. Repeated indices of strips
//! are stitches, not faces. Points, lines, cameras, lights and animations are left out, and skinned and morphed meshes
//! are in the pose of their positions, which no node transforms if there is a skin.
//!
//! Colors of vertices and `baseColorFactor` are taken as stored, as in the other formats. The specification calls them
//! linear (and images sRGB), but many files hold what was on the screen. Integers are over their largest value, alpha
//! is dropped. Materials have the image of `baseColorTexture`, a file or inside this one; its `KHR_texture_transform`
//! is the placement of the image. Positions and texture coordinates may be integers (`KHR_mesh_quantization`).
//!
//! We use our own reader of the JSON, by serde_json: the crate gltf computes where accessors end in unchecked
//! arithmetic, which a count of 0 or 2^63 overflows, and does not read quantized positions. Every access is checked
//! against the bytes that there are.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, 2021.

mod accessor;
mod assembly;
mod buffers;
mod component;
mod container;
mod document;
mod materials;
mod nodes;
mod paint;
mod parse;
mod primitive;
mod uri;
mod write;

use std::path::Path;

use self::assembly::Assembly;
use self::buffers::Buffers;
use super::text::BYTE_ORDER_MARK;
use crate::error::Result;
use crate::mesh::Mesh;

pub use write::{write_labeled, write_labeled_faces};

/// Whether it begins as binary glTF, or is a JSON object with a key `asset`.
pub fn recognizes(bytes: &[u8]) -> bool {
    const KEY: &[u8] = b"\"asset\"";
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes).trim_ascii_start();
    let is_json = || text.starts_with(b"{") && text.windows(KEY.len()).any(|window| window == KEY);
    bytes.starts_with(container::MAGIC) || is_json()
}

/// `folder` contains the buffers and images that are other files, if they may be read.
pub fn parse(path: &Path, folder: Option<&Path>, bytes: &[u8]) -> Result<Mesh> {
    let content = container::open(path, bytes)?;
    let document = parse::parse(path, content.json)?;
    let buffers = Buffers::load(path, folder, &document, content.binary)?;
    let mut assembly = Assembly::new(path, &document, &buffers);
    for instance in nodes::instances(path, &document)? {
        assembly.add(&instance)?;
    }
    assembly.finish(folder)
}
