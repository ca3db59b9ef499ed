//! Closed-form bounds on the rows and columns of K, from which every step size follows without tuning.
//!
//! ```text
//! l_j = lmax(K_j K_j^T)     K_j = [K_j1 K_j2 K_j3] in R^{2 x 3}
//! b_j = lmax( sum_{k=1..3} g_k g_k^T ),  g_k = K_jk / |K_jk|       (between 3/2 and 3; g_k = 0 for K_jk = 0)
//! ```
//!
//! With them |K_j u|^2 <= b_j sum_k |K_jk|^2 |u_k|^2: for any face weights w_j >= 0 the matrix
//! K^T diag(w) K is at most diag( sum_{j at k} w_j b_j |K_jk|^2 ), and for positive definite diagonal D
//! this bounds lmax(D^-1 K^T diag(w) K). It is exact on a grid of right-angled isosceles triangles.

use super::Operator;
use crate::sweep::{ranges, scatter, sweep_parts};

/// K_j1, K_j2, K_j3.
type Columns = [[f64; 2]; 3];

/// l_j, squared units of length.
#[inline(always)]
pub fn row_bound(columns: Columns) -> f64 {
    let [mut a, mut b, mut c] = [0.0; 3];
    for [x, y] in columns {
        a += x * x;
        b += x * y;
        c += y * y;
    }
    // Relative to the trace, so that squares neither overflow nor underflow, however large or small the face is.
    let trace = a + c;
    let inverse = 1.0 / trace;
    trace * largest_eigenvalue(1.0, (a - c) * inverse, b * inverse)
}

/// b_j, dimensionless.
#[inline(always)]
pub fn column_bound(columns: Columns) -> f64 {
    let (mut trace, mut difference, mut b) = (0.0, 0.0, 0.0);
    for [x, y] in columns {
        let square = squared([x, y]);
        let [one, weight] = if square > 0.0 { [1.0, 1.0 / square] } else { [0.0; 2] };
        trace += one;
        difference += weight * (x - y) * (x + y);
        b += weight * x * y;
    }
    largest_eigenvalue(trace, difference, b)
}

/// The largest eigenvalue of the symmetric 2 x 2 matrix (a b; b c), from its trace, a - c and b.
#[inline(always)]
fn largest_eigenvalue(trace: f64, difference: f64, b: f64) -> f64 {
    0.5 * (trace + (difference * difference + 4.0 * b * b).sqrt())
}

/// |K_jk|^2.
#[inline(always)]
pub fn squared([a, b]: [f64; 2]) -> f64 {
    a * a + b * b
}

/// Number of faces per block, a few vectors: square roots and divisions of a vector take about as long as of a number.
const FACES_AT_ONCE: usize = 16;

/// `bound(K_j1, K_j2, K_j3)` of every face, F numbers.
pub fn of_faces(k: &impl Operator, bound: impl Fn(Columns) -> f64 + Sync) -> Vec<f64> {
    let mut bounds = vec![0.0; k.faces()];
    sweep_parts(
        &mut bounds,
        &ranges(k.faces()),
        #[inline(always)]
        |first, bounds| {
            for (block, bounds) in bounds.chunks_mut(FACES_AT_ONCE).enumerate() {
                let first = first + block * FACES_AT_ONCE;
                // [corner][axis][face]
                let mut columns = [[[1.0; FACES_AT_ONCE]; 2]; 3];
                for i in 0..bounds.len() {
                    for (columns, column) in columns.iter_mut().zip(k.face(first + i).columns) {
                        (columns[0][i], columns[1][i]) = (column[0], column[1]);
                    }
                }
                let mut found = [0.0; FACES_AT_ONCE];
                for (i, found) in found.iter_mut().enumerate() {
                    let [a, b, c] = &columns;
                    *found = bound([[a[0][i], a[1][i]], [b[0][i], b[1][i]], [c[0][i], c[1][i]]]);
                }
                bounds.copy_from_slice(&found[..bounds.len()]);
            }
        },
    );
    bounds
}

/// sum_{j at k} w_j b_j |K_jk|^2 for every vertex, V numbers: a diagonal matrix above K^T diag(w) K. `weight(j)` is
/// w_j, nonnegative.
pub fn diagonal_above(k: &impl Operator, weight: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
    let b = of_faces(k, column_bound);
    scatter(
        k.vertices(),
        k.faces(),
        #[inline(always)]
        |j| k.face(j).corners,
        #[inline(always)]
        |j| {
            let face = k.face(j);
            let scale = weight(j) * b[j];
            face.columns.map(|column| scale * squared(column))
        },
    )
}
