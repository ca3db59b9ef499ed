//! Colors, texture coordinates and materials of the primitives.
//!
//! ```text
//! COLOR_0: r, g, b, maybe a, clamped to [0, 1]        per vertex; of a block, those of its first primitive with some
//! TEXCOORD_n = (s, t) -> (u, v) = (s, 1 - t)          per corner; the material says which n
//! ```
//!
//! What cannot be read is unknown, and a warning tells why.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.7.2, "Meshes".

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use super::accessor::Reader;
use super::document::{Document, Primitive};
use super::materials::{self, texture_set};
use crate::counted::counted;
use crate::mesh::Mesh;
use crate::mesh::io::colors::Colors;
use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::rules::{INVALID_TEXTURE, valid_uv, warn_untextured};

const UNKNOWN_UV: [f64; 2] = [f64::NAN; 2];

/// The vertices of an accessor of positions at a node.
#[derive(Clone, Copy)]
pub struct Block {
    pub first: u32,
    pub count: u32,
    /// The accessor of its colors.
    pub colors: Option<usize>,
}

/// Texture coordinates with v upwards by accessor, or why they cannot be read.
pub type SharedUv = HashMap<usize, Result<Vec<[f64; 2]>, String>>;

#[derive(Default)]
pub struct Paint {
    /// Of the first vertices; the others have none.
    colors: Vec<[f64; 3]>,
    /// Of the first faces; the others have none.
    uv: Vec<[[f64; 2]; 3]>,
    /// Indices of materials in the file, one per face.
    materials: Vec<Option<u32>>,
    unreadable: Occurrences,
    invalid_uv: Occurrences,
    other_colors: Occurrences,
    no_material: Occurrences,
}

impl Paint {
    /// Sets the colors of a block, unless an earlier primitive did.
    pub fn color(
        &mut self,
        reader: &Reader,
        primitive: &Primitive,
        block: &mut Block,
        place: &str,
    ) {
        let Some(&colors) = primitive.attributes.get("COLOR_0") else { return };
        if let Some(other) = block.colors {
            if other != colors {
                self.other_colors.add(|| place.to_owned());
            }
            return;
        }
        block.colors = Some(colors);
        let rows = reader.rows::<3>(colors, &["VEC3", "VEC4"], true);
        let rows = match rows.and_then(|rows| check_count(&rows, block.count).map(|()| rows)) {
            Ok(rows) => rows,
            Err(message) => {
                self.unreadable.add(|| format!("{place}, COLOR_0: {message}"));
                return;
            }
        };
        let [first, count] = [block.first, block.count].map(|k| k as usize);
        let length = self.colors.len().max(first + count);
        self.colors.resize(length, [f64::NAN; 3]);
        for (color, row) in self.colors[first..].iter_mut().zip(rows) {
            // The specification clamps. NaN stays.
            *color = row.map(|c| c.clamp(0.0, 1.0));
        }
    }

    /// Appends the texture coordinates of faces, whose vertices count from 0.
    pub fn texture(
        &mut self,
        reader: &Reader,
        primitive: &Primitive,
        vertices: u32,
        faces: &[[u32; 3]],
        shared: &mut SharedUv,
        place: &str,
    ) {
        let name = format!("TEXCOORD_{}", texture_set(reader.document, primitive.material));
        let Some(&accessor) = primitive.attributes.get(&name) else { return };
        let uv = match shared.entry(accessor) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(self.upwards(reader, accessor, place)),
        };
        let uv = uv.as_ref().map_err(String::clone);
        match uv.and_then(|uv| check_count(uv, vertices).map(|()| uv)) {
            Ok(uv) => {
                // There is one material per face that was added before.
                self.uv.resize(self.materials.len(), [UNKNOWN_UV; 3]);
                self.uv.extend(faces.iter().map(|face| face.map(|k| uv[k as usize])));
            }
            Err(message) => self.unreadable.add(|| format!("{place}, {name}: {message}")),
        }
    }

    /// The texture coordinates of an accessor.
    fn upwards(
        &mut self,
        reader: &Reader,
        accessor: usize,
        place: &str,
    ) -> Result<Vec<[f64; 2]>, String> {
        let rows = reader.rows::<2>(accessor, &["VEC2"], false)?;
        let invalid = &mut self.invalid_uv;
        let upwards = rows
            .into_iter()
            .enumerate()
            .map(|(k, [s, t])| valid_uv([s, 1.0 - t], invalid, || format!("{place}, vertex {k}")));
        Ok(upwards.collect())
    }

    /// Appends the material of faces, after their texture coordinates.
    pub fn material(
        &mut self,
        document: &Document,
        primitive: &Primitive,
        faces: usize,
        place: &str,
    ) {
        let exists = |&material: &usize| material < document.materials.len();
        let material = primitive.material.filter(exists);
        if primitive.material.is_some() && material.is_none() {
            self.no_material.add(|| place.to_owned());
        }
        let material = material.and_then(|material| u32::try_from(material).ok());
        self.materials.resize(self.materials.len() + faces, material);
    }

    /// The mesh with its colors, texture coordinates and materials; `folder` contains the images.
    pub fn finish(
        mut self,
        path: &Path,
        folder: Option<&Path>,
        reader: &Reader<'_>,
        mut mesh: Mesh,
    ) -> Mesh {
        self.unreadable
            .warn(path, "colors and texture coordinates that cannot be read are unknown");
        self.invalid_uv.warn(path, INVALID_TEXTURE);
        self.other_colors.warn(
            path,
            "of primitives that share positions but not colors, the colors of the first are taken",
        );
        self.no_material.warn(path, "materials that do not exist are left out");
        let mut colors = Colors::new(Some(1.0)).with_capacity(self.colors.len());
        for (k, &color) in self.colors.iter().enumerate() {
            colors.set(k, color, || format!("vertex {k}"));
        }
        mesh.colors = colors.finish(path, mesh.vertices.len(), "vertices");
        if !self.uv.is_empty() {
            self.uv.resize(mesh.faces.len(), [UNKNOWN_UV; 3]);
            mesh.uv = warn_untextured(path, self.uv);
        }
        let uv = mesh.uv.as_deref();
        mesh.materials = materials::of_faces(path, folder, reader, self.materials, uv);
        mesh
    }
}

/// Fails unless there is one element per vertex.
fn check_count<T>(rows: &[T], vertices: u32) -> Result<(), String> {
    match u32::try_from(rows.len()) == Ok(vertices) {
        true => Ok(()),
        false => Err(format!(
            "{} for {}",
            counted(rows.len(), "element", "elements"),
            counted(vertices as usize, "position", "positions")
        )),
    }
}
