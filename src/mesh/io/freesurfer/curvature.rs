//! Numbers at the vertices of a surface of FreeSurfer: `lh.curv`, `lh.sulc`, `lh.thickness`, `lh.area`.
//!
//! ```text
//! ff ff ff, V, F, 1 (numbers per vertex) as i32, V times f32; big endian
//! ```

use std::path::Path;

use super::bytes::Bytes;
use crate::counted::counted;
use crate::error::{Error, Result};

const MAGIC: &[u8] = b"\xff\xff\xff";

/// Whether the file begins like one.
pub fn is_curvature(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads one number per vertex. NaN and infinity are kept.
///
/// # Errors
/// The file is malformed, or has several numbers per vertex.
pub fn read_curvature(path: &Path, bytes: &[u8]) -> Result<Vec<f64>> {
    let Some(mut bytes) = Bytes::behind(path, bytes, MAGIC) else {
        let message = "is not a file of numbers at vertices that FreeSurfer writes today";
        return Err(Error::malformed(path, message));
    };
    let (vertices, _, each) =
        (bytes.count("vertices")?, bytes.int("the number of faces")?, bytes.count("numbers")?);
    if each != 1 {
        let each = counted(each, "number", "numbers");
        return Err(bytes.error(format!("has {each} per vertex; only 1 is supported")));
    }
    let numbers = bytes.records::<4>(vertices, "numbers")?;
    bytes.finish()?;
    Ok(numbers.iter().map(|&x| f64::from(f32::from_be_bytes(x))).collect())
}
