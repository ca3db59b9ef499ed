//! Files of cameras. The content decides which format a file has, not its name.
//!
//! | format | recognized by |
//! |---|---|
//! | own (TOML) | a line `[[view]]` |
//! | Middlebury `_par.txt` | a first line with the number of views |
//! | OpenMVS `.mvs` | the first bytes `MVSI` |
//! | COLMAP text model | a folder with `cameras.txt` and `images.txt`, or one of the two |

mod colmap;
mod middlebury;
mod numbers;
mod openmvs;
#[cfg(feature = "experiments")]
mod own;

use std::path::{Path, PathBuf};

use super::view::View;
use crate::error::{Error, Result};
use crate::file;

/// The views of a file, and the name of its format.
pub struct ViewFile {
    pub format: &'static str,
    pub views: Vec<View>,
    /// What was left out of it, one sentence each.
    pub warnings: Vec<String>,
}

/// Reads the views of a file or of a COLMAP folder.
///
/// # Errors
/// A file that cannot be read, has an unknown format, is damaged or has an impossible camera.
pub fn read(path: &Path) -> Result<ViewFile> {
    let found = read_any(path)?;
    if found.views.is_empty() {
        return Err(Error::malformed(path, "has no views"));
    }
    Ok(found)
}

fn read_any(path: &Path) -> Result<ViewFile> {
    if path.is_dir() {
        return colmap(path);
    }
    let bytes = file::read(path)?;
    if bytes.starts_with(b"MVSI") {
        let (views, warnings) = openmvs::read(path, &bytes)?;
        return Ok(ViewFile { format: "OpenMVS", views, warnings });
    }
    if let Some(folder) = colmap_folder(path) {
        return colmap(folder);
    }
    let file_name = path.file_name().and_then(|name| name.to_str());
    let unknown = || {
        Err(Error::malformed(
            path,
            "is not a file of cameras: TOML with [[view]], a Middlebury _par.txt, an OpenMVS .mvs or a COLMAP text model \
             (its folder)",
        ))
    };
    if let Some("cameras.bin" | "images.bin") = file_name {
        return Err(Error::malformed(
            path,
            "is a binary COLMAP model; convert it with `colmap model_converter --output_type TXT`",
        ));
    }
    let Ok(text) = std::str::from_utf8(&bytes) else { return unknown() };
    if text.lines().any(|line| line.trim() == "[[view]]") {
        return own(path, text);
    }
    let first = text.lines().next().unwrap_or("").trim();
    match first.parse::<usize>() {
        Ok(count) => Ok(ViewFile {
            format: "Middlebury",
            views: middlebury::read(path, text, count)?,
            warnings: Vec::new(),
        }),
        Err(_) => unknown(),
    }
}

/// The folder of a COLMAP model that a path names by one of its files.
fn colmap_folder(path: &Path) -> Option<&Path> {
    match path.file_name()?.to_str()? {
        "cameras.txt" | "images.txt" => path.parent(),
        _ => None,
    }
}

/// The files that [`read`] reads.
pub fn files(path: &Path) -> Vec<PathBuf> {
    match if path.is_dir() { Some(path) } else { colmap_folder(path) } {
        Some(folder) => ["cameras.txt", "images.txt"].map(|name| folder.join(name)).into(),
        None => vec![path.to_owned()],
    }
}

fn colmap(folder: &Path) -> Result<ViewFile> {
    let views = colmap::read(folder)?;
    Ok(ViewFile { format: "COLMAP", views, warnings: Vec::new() })
}

#[cfg(feature = "experiments")]
fn own(path: &Path, text: &str) -> Result<ViewFile> {
    Ok(ViewFile { format: "TOML", views: own::read(path, text)?, warnings: Vec::new() })
}

/// The views as a file of this program, with all digits of their numbers.
#[cfg(feature = "experiments")]
pub fn to_toml(views: &[View]) -> String {
    own::write(views)
}

#[cfg(not(feature = "experiments"))]
fn own(path: &Path, _: &str) -> Result<ViewFile> {
    Err(Error::malformed(path, "needs the feature `experiments`, which reads TOML"))
}

#[cfg(test)]
mod tests;
