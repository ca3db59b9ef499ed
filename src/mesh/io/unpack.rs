//! Images inside the file of a mesh, such as a `.glb`, become files next to another one, which only names them.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Image, Materials, Mesh};

/// A mesh whose images are files. Those that were written for it are removed if it is not kept.
pub struct Unpacked<'a> {
    pub mesh: Cow<'a, Mesh>,
    written: Vec<PathBuf>,
}

impl<'a> Unpacked<'a> {
    /// Writes images inside the file of the mesh as `STEM-NAME` next to `path`.
    ///
    /// # Errors
    /// A file cannot be written, or another one has its name; then no image is written.
    pub fn new(path: &Path, mesh: &'a Mesh) -> Result<Self> {
        let mut unpacked = Unpacked { mesh: Cow::Borrowed(mesh), written: Vec::new() };
        let Some(materials) = &mesh.materials else { return Ok(unpacked) };
        let images = || materials.all.iter().filter_map(|material| material.image.as_ref());
        if !images().any(|image| matches!(image, Image::Inside(..))) {
            return Ok(unpacked);
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        // Files that the materials name, whether they exist or not.
        let named: HashSet<_> = images()
            .filter(|image| matches!(image, Image::File(_)))
            .filter_map(|image| image.path().file_name())
            .collect();
        let target = |name: &Path| {
            let mut name = format!("{stem}-{}", name.display());
            while named.contains(name.as_ref() as &std::ffi::OsStr) {
                name = format!("inside-{name}");
            }
            path.with_file_name(name)
        };
        let mut all = materials.all.clone();
        let mut missing = Vec::new();
        for material in &mut all {
            if let Some(Image::Inside(name, bytes)) = &material.image {
                let target = target(name);
                if !exists(&target, bytes)? && !missing.iter().any(|(path, _)| *path == target) {
                    missing.push((target.clone(), bytes.clone()));
                }
                material.image = Some(Image::File(target));
            }
        }
        for (path, bytes) in missing {
            file::write(&path, |out: &mut dyn Write| out.write_all(&bytes))?;
            unpacked.written.push(path);
        }
        let materials = Some(Materials { all, of_faces: materials.of_faces.clone() });
        unpacked.mesh = Cow::Owned(Mesh { materials, ..mesh.clone() });
        Ok(unpacked)
    }

    /// Keeps the images.
    pub fn keep(mut self) {
        self.written.clear();
    }
}

impl Drop for Unpacked<'_> {
    fn drop(&mut self) {
        for path in &self.written {
            // Nothing more can be done.
            let _ = fs::remove_file(path);
        }
    }
}

/// Whether an image is there already. Fails if something else is.
fn exists(path: &Path, bytes: &[u8]) -> Result<bool> {
    match fs::symlink_metadata(path) {
        Err(_) => Ok(false),
        Ok(_) if fs::read(path).is_ok_and(|content| content == bytes) => Ok(true),
        Ok(_) => Err(Error::malformed(
            path,
            "exists and would be replaced by an image of the mesh; move it, or choose another name for the mesh",
        )),
    }
}
