//! Sparse matrices as MatrixMarket text.

use std::path::Path;

use sprs::CsMat;

use crate::error::Result;
use crate::file;

/// Writes a real general matrix in coordinate form: indices from 1, shortest decimals that read back exactly. Fails if
/// the file cannot be written.
pub fn write_matrix_market(path: &Path, matrix: &CsMat<f64>) -> Result<()> {
    file::write(path, |out| {
        writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
        writeln!(out, "{} {} {}", matrix.rows(), matrix.cols(), matrix.nnz())?;
        for (value, (row, column)) in matrix {
            writeln!(out, "{} {} {value:e}", row + 1, column + 1)?;
        }
        Ok(())
    })
}
