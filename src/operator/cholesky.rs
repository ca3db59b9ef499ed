//! T = L L^T by faer: factored once, solved for all regions at once.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use pulp::bytemuck::TransparentWrapper;
use sprs::CsMat;

use crate::field::Row;

/// One thread: a parallel triangular solve with few right-hand sides is several times slower.
const ONE_THREAD: Par = Par::Seq;

pub struct Cholesky {
    symbolic: Box<SymbolicCholesky<usize>>,
    /// The values of L.
    values: Vec<f64>,
}

impl Cholesky {
    /// Factors a symmetric positive definite matrix; `None` if rounding makes it look indefinite.
    pub fn new(matrix: &CsMat<f64>) -> Option<Self> {
        Cholesky::within(matrix, usize::MAX)
    }

    /// The same; also `None` if L would have more than the given number of entries.
    pub fn within(matrix: &CsMat<f64>, entries_of_l: usize) -> Option<Self> {
        let matrix = matrix.to_csc();
        let (rows, columns, starts) = (matrix.rows(), matrix.cols(), matrix.indptr());
        let pattern = SymbolicSparseColMatRef::new_checked(
            rows,
            columns,
            starts.raw_storage(),
            None,
            matrix.indices(),
        );
        let entries = SparseColMatRef::new(pattern, matrix.data());
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Amd,
            Default::default(),
        )
        .ok()
        .filter(|symbolic| symbolic.len_val() <= entries_of_l)?;
        let mut values = vec![0.0; symbolic.len_val()];
        let room = symbolic.factorize_numeric_llt_scratch::<f64>(ONE_THREAD, Default::default());
        symbolic
            .factorize_numeric_llt(
                &mut values,
                entries,
                Side::Lower,
                Default::default(),
                ONE_THREAD,
                MemStack::new(&mut MemBuffer::try_new(room).ok()?),
                Default::default(),
            )
            .ok()?;
        Some(Cholesky { symbolic: Box::new(symbolic), values })
    }

    /// Replaces g by the solution, column by column.
    pub fn solve<const M: usize>(&self, g: &mut [Row<M>]) {
        let rows = g.len();
        let flat = Row::peel_slice_mut(g).as_flattened_mut();
        let room = self.symbolic.solve_in_place_scratch::<f64>(M, ONE_THREAD);
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_row_major_slice_mut(flat, rows, M),
            ONE_THREAD,
            MemStack::new(&mut MemBuffer::new(room)),
        );
    }
}
