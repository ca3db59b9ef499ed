//! Images inside the file of a mesh, such as a `.glb`, become files next to another one, which only names them.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Image, Materials, Mesh};

/// The mesh with files in place of images inside its own, written as `STEM-NAME` next to `path`.
///
/// # Errors
/// A file cannot be written, or another one has its name.
pub fn unpacked<'a>(path: &Path, mesh: &'a Mesh) -> Result<Cow<'a, Mesh>> {
    let is_inside = |image: &Image| matches!(image, Image::Inside(..));
    let Some(materials) = &mesh.materials else { return Ok(Cow::Borrowed(mesh)) };
    if !materials.all.iter().filter_map(|material| material.image.as_ref()).any(is_inside) {
        return Ok(Cow::Borrowed(mesh));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut all = materials.all.clone();
    for material in &mut all {
        if let Some(Image::Inside(name, bytes)) = &material.image {
            let target = path.with_file_name(format!("{stem}-{}", name.display()));
            write(&target, bytes)?;
            material.image = Some(Image::File(target));
        }
    }
    let materials = Some(Materials { all, of_faces: materials.of_faces.clone() });
    Ok(Cow::Owned(Mesh { materials, ..mesh.clone() }))
}

/// Writes an image unless it is there.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    if path.exists() {
        return match file::read(path)? == bytes {
            true => Ok(()),
            false => Err(Error::malformed(
                path,
                "exists and would be replaced by an image of the mesh; move it, or choose another name for the mesh",
            )),
        };
    }
    file::write(path, |out: &mut dyn Write| out.write_all(bytes))
}
