//! T = L L^T by faer: factored once, solved for all regions at once.

use faer::linalg::solvers::Solve;

use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, Par, Side};
use sprs::CsMat;

use crate::field::Row;

pub struct Cholesky {
    factor: Llt<usize, f64>,
}

impl Cholesky {
    /// Of a symmetric positive definite matrix; none if rounding makes it look indefinite.
    pub fn new(matrix: &CsMat<f64>) -> Option<Self> {
        Cholesky::within(matrix, usize::MAX)
    }

    /// The same; none, too, if the factor would have more entries than that.
    pub fn within(matrix: &CsMat<f64>, entries_of_l: usize) -> Option<Self> {
        let entries: Vec<Triplet<usize, usize, f64>> =
            matrix.iter().map(|(&value, (row, col))| Triplet::new(row, col, value)).collect();
        let matrix = SparseColMat::try_new_from_triplets(matrix.rows(), matrix.cols(), &entries)
            .expect("the entries lie inside the matrix");
        // A parallel triangular solve of so thin a right-hand side is several times slower.
        faer::set_global_parallelism(Par::Seq);
        if entries_of_l < usize::MAX {
            let (symmetric, ordering) = (matrix.symbolic(), SymmetricOrdering::Amd);
            let symbolic =
                factorize_symbolic_cholesky(symmetric, Side::Lower, ordering, Default::default());
            if symbolic.ok()?.len_val() > entries_of_l {
                return None;
            }
        }
        matrix.sp_cholesky(Side::Lower).ok().map(|factor| Cholesky { factor })
    }

    /// Replaces g by the solution, column by column.
    pub fn solve<const M: usize>(&self, g: &mut [Row<M>]) {
        let rows = g.len();
        let flat = flatten_mut(g);
        self.factor.solve_in_place(MatMut::from_row_major_slice_mut(flat, rows, M));
    }
}

/// The V x M numbers of V rows.
fn flatten_mut<const M: usize>(rows: &mut [Row<M>]) -> &mut [f64] {
    let len = rows.len() * M;
    // SAFETY: Row<M> is repr(transparent) over [f64; M], so the slice is len contiguous f64.
    unsafe { std::slice::from_raw_parts_mut(rows.as_mut_ptr().cast(), len) }
}
