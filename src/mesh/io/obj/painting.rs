//! The materials of an OBJ file: the material of each face, and their descriptions in libraries.

use std::collections::HashMap;
use std::path::Path;

use super::mtl;
use crate::file;
use crate::mesh::io::occurrences::{Occurrences, warn};
use crate::mesh::io::text::{decode, quote, without_comment};
use crate::mesh::{Material, Materials};

#[derive(Default)]
pub struct Painting {
    libraries: Vec<Vec<u8>>,
    /// Names of the materials in the order of first use.
    names: Vec<String>,
    index_of: HashMap<String, u32>,
    current: Option<u32>,
    of_faces: Vec<Option<u32>>,
}

impl Painting {
    pub fn library(&mut self, names: &[u8]) {
        // The same line is often repeated before each object.
        if !self.libraries.iter().any(|library| library == names) {
            self.libraries.push(names.to_vec());
        }
    }

    /// The material of the faces after the first `faces`.
    pub fn begin(&mut self, name: &[u8], faces: usize) {
        self.of_faces.resize(faces, self.current);
        let name = decode(name);
        self.current = Some(*self.index_of.entry(name.clone()).or_insert_with(|| {
            self.names.push(name);
            // There is at most one name per line of a file that fits into memory.
            self.names.len() as u32 - 1
        }));
    }

    pub fn finish(mut self, path: &Path, folder: Option<&Path>, faces: usize) -> Option<Materials> {
        if self.names.is_empty() {
            return None;
        }
        self.of_faces.resize(faces, self.current);
        let mut described = HashMap::new();
        let mut unreadable = Occurrences::default();
        if let Some(folder) = folder {
            for path in self.libraries.iter().flat_map(|names| mtl::libraries(folder, names)) {
                match file::read(&path) {
                    // The first description of a name counts.
                    Ok(bytes) => {
                        mtl::parse(&path, &bytes).into_iter().for_each(|(name, material)| {
                            described.entry(name).or_insert(material);
                        })
                    }
                    Err(error) => unreadable.add(|| error.to_string()),
                }
            }
        }
        if !unreadable.is_empty() {
            unreadable
                .warn(path, "material libraries cannot be read, so colors and images are missing");
        } else if folder.is_some() && !self.libraries.is_empty() {
            let unknown: Vec<_> =
                self.names.iter().filter(|name| find(&described, name).is_none()).collect();
            if let Some(first) = unknown.first() {
                let first = quote(first.as_bytes());
                warn(
                    path,
                    &format!(
                        "materials without a description in a library have no color and no image ({}, the first: \
                         {first})",
                        unknown.len()
                    ),
                );
            }
        }
        let all = self.names.into_iter().map(|name| {
            find(&described, &name)
                .cloned()
                .unwrap_or_else(|| Material { name, ..Material::default() })
        });
        Some(Materials { all: all.collect(), of_faces: self.of_faces })
    }
}

/// The description of a material, whose name may be followed by a comment.
fn find<'a>(described: &'a HashMap<String, Material>, name: &str) -> Option<&'a Material> {
    described
        .get(name)
        .or_else(|| described.get(std::str::from_utf8(without_comment(name.as_bytes())).ok()?))
}
