//! Sparse matrices as MatrixMarket text.

use std::path::Path;

use sprs::CsMat;

use crate::error::Result;
use crate::file;

/// Coordinates from 1, shortest decimals that read back exactly.
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
