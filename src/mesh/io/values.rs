//! Numbers and labels at vertices in the files of other programs: arrays of GIFTI, and numbers and annotations of
//! FreeSurfer. Each becomes an array with a row per vertex.
//!
//! | file | columns |
//! |---|---|
//! | `.func.gii`, `.shape.gii`, `.time.gii` | the numbers of each array |
//! | `.label.gii` | the row of the label in the table, `???` not counted, from 0; -1 if it has none |
//! | `lh.thickness`, `lh.curv` and the like | the number |
//! | `.annot` | the row of the label in the table of the file, from 0; -1 if the table does not have it |

use std::path::Path;

use ndarray::Array2;

use super::{freesurfer, gifti};
use crate::error::{Error, Result};
use crate::file;
use crate::npy;

/// Whether this is the name of a file for [`read_values`]: it ends in `.gii` or `.annot`, or begins with `lh.` or `rh.`
/// and is no array or table.
pub fn names_values(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_ascii_lowercase());
    let name = name.unwrap_or_default();
    let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
    let hemisphere = ["lh.", "rh."].iter().any(|start| name.starts_with(start));
    ends(&[".gii", ".annot"]) || (hemisphere && !ends(&[".npy", ".npz", ".csv"]))
}

/// Reads the numbers or labels at vertices of a file that [`names_values`] knows; entries may be NaN or infinite. The
/// content decides on the format, except that annotations are known by `.annot`.
///
/// # Errors
/// The file cannot be read, is malformed, or has no such numbers.
pub fn read_values(path: &Path) -> Result<Array2<f64>> {
    let bytes = file::read(path)?;
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    if gifti::recognizes(&bytes) {
        return Ok(gifti::read_arrays(path, &bytes)?.known());
    }
    let column = if freesurfer::is_curvature(&bytes) {
        freesurfer::read_curvature(path, &bytes)?
    } else if extension.is_some_and(|extension| extension == "annot") {
        let labels = freesurfer::read_annotation(path, &bytes)?.labels;
        labels.into_iter().map(f64::from).collect()
    } else {
        let message = match freesurfer::recognizes(&bytes) {
            true => "is a surface; name a file of numbers at its vertices",
            false => {
                "has no numbers at vertices in a known format; supply GIFTI, or numbers (curv) or .annot of FreeSurfer"
            }
        };
        return Err(Error::malformed(path, message));
    };
    Array2::from_shape_vec((column.len(), 1), column)
        .map_err(|error| Error::malformed(path, error.to_string()))
}

/// Data at vertices: a file for [`read_values`], or else an array of NumPy, see [`npy::read_data`]. Entries are finite,
/// or NaN where unknown.
///
/// # Errors
/// As these, and if an entry is infinite.
pub fn read_data(path: &Path) -> Result<Array2<f64>> {
    if !names_values(path) {
        return npy::read_data(path);
    }
    let values = read_values(path)?;
    npy::check_data(path, &values)?;
    Ok(values)
}
