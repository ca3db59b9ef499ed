//! Sparse matrices in the `.npz` layout of `scipy.sparse.save_npz`.

use std::io::{Cursor, Write};
use std::path::Path;

use ndarray::{Array1, ArrayView1, arr0};
use ndarray_npy::{NpzWriter, WritableElement, WriteDataError};
use py_literal::Value;
use sprs::CsMat;

use crate::error::Result;
use crate::file;

/// Writes a compressed-row matrix with 64-bit indices, as `scipy.sparse.load_npz` reads it. Panics if the matrix is in
/// compressed columns; fails if the file cannot be written.
pub fn write_npz(path: &Path, matrix: &CsMat<f64>) -> Result<()> {
    assert!(matrix.is_csr());
    let integers =
        |numbers: &[usize]| -> Array1<i64> { numbers.iter().map(|&n| n as i64).collect() };
    let bytes = || -> std::result::Result<Vec<u8>, ndarray_npy::WriteNpzError> {
        let mut npz = NpzWriter::new(Cursor::new(Vec::new()));
        npz.add_array("indices", &integers(matrix.indices()))?;
        npz.add_array("indptr", &integers(matrix.indptr().raw_storage()))?;
        npz.add_array("format", &arr0(ByteString(*b"csr")))?;
        npz.add_array("shape", &integers(&[matrix.rows(), matrix.cols()]))?;
        npz.add_array("data", &ArrayView1::from(matrix.data()))?;
        Ok(npz.finish()?.into_inner())
    };
    file::write(path, |out| out.write_all(&bytes().map_err(std::io::Error::other)?))
}

/// A NumPy byte string of N bytes; trailing zeros are not part of it.
#[derive(Clone, Copy)]
pub struct ByteString<const N: usize>(pub [u8; N]);

impl<const N: usize> WritableElement for ByteString<N> {
    fn type_descriptor() -> Value {
        Value::String(format!("|S{N}"))
    }

    fn write<W: Write>(&self, mut writer: W) -> std::result::Result<(), WriteDataError> {
        Ok(writer.write_all(&self.0)?)
    }

    fn write_slice<W: Write>(
        slice: &[Self],
        mut writer: W,
    ) -> std::result::Result<(), WriteDataError> {
        slice.iter().try_for_each(|element| element.write(&mut writer))
    }
}
