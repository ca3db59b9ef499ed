//! Points at most limit d(a, b) from each other that are nearest to given ones, by Newton's method, with a multiplier
//! mu_ab for each pair that is as far apart as it may be:
//!
//! ```text
//! ( I + sum mu_ab (e_a - e_b) (e_a - e_b)^T ) q = q_given        1 / |q_a - q_b| = 1 / (limit d(a, b))
//! ```
//!
//! The second line is solved for mu; for a single pair it is linear in mu. Its derivative is that of a positive semidefinite
//! matrix, (e_a - e_b)^T (I + ...)^-1 (e_c - e_d) <q_a - q_b, q_c - q_d>, divided by the cubes of the distances. The same idea,
//! for the radius of a trust region: J. J. Moré, D. C. Sorensen, *Computing a trust region step*, SIAM J. Sci. Stat. Comput. 4,
//! 1983. It is not sure to converge; whoever calls it has another method.

use super::label_metric::LabelMetric;
use crate::field::{Row, Tangent};

/// Distances are exact up to this, in units of the limit.
pub const TOLERANCE: f64 = 1e-12;

/// The largest number of pairs.
const MAX_PAIRS: usize = 32;

/// The largest number of steps.
const MAX_STEPS: usize = 30;

/// The nearest points, from pairs that are about as far apart as they may be and mu_ab (q_a - q_b) for each; `None` if
/// there are too many pairs, or no convergence.
pub fn project<'a, const M: usize>(
    given: Tangent<M>,
    (limit, metric): (f64, LabelMetric),
    found: impl Iterator<Item = (&'a [u8; 2], &'a [f64; 2])>,
) -> Option<Tangent<M>> {
    let (mut pairs, mut multipliers) = ([[0_usize; 2]; MAX_PAIRS], [0.0; MAX_PAIRS]);
    let mut count = 0;
    for (&pair, &[x, y]) in found {
        let pair = pair.map(usize::from);
        let multiplier = f64::hypot(x, y) / (limit * metric.apart(pair[0], pair[1]));
        if multiplier > 0.0 {
            if count == MAX_PAIRS {
                return None;
            }
            (pairs[count], multipliers[count]) = (pair, multiplier);
            count += 1;
        }
    }
    // Distances cannot be more exact than the given points.
    let size = given.0.map(Row::max_abs).into_iter().fold(0.0, f64::max);
    let tolerance = TOLERANCE * limit * metric.smallest() + 8.0 * f64::EPSILON * size;
    for _ in 0..MAX_STEPS {
        let mut inverse = [[0.0; M]; M];
        for (a, row) in inverse.iter_mut().enumerate() {
            row[a] = 1.0;
        }
        for (&[a, b], mu) in pairs[..count].iter().zip(multipliers) {
            inverse[a][a] += mu;
            inverse[b][b] += mu;
            inverse[a][b] -= mu;
            inverse[b][a] -= mu;
        }
        invert(&mut inverse, M);
        let Tangent([x, y]) = given;
        let times = |row: &Row<M>| Row::<M>::from_fn(|a| Row(inverse[a]).dot(*row));
        let (x, y) = (times(&x), times(&y));
        let apart = |[a, b]: [usize; 2]| [x.0[a] - x.0[b], y.0[a] - y.0[b]];
        let mut largest = 0.0;
        let (mut system, mut steps) = ([[0.0; MAX_PAIRS]; MAX_PAIRS], [0.0; MAX_PAIRS]);
        for i in 0..count {
            let [dx, dy] = apart(pairs[i]);
            let (distance, most) =
                (f64::hypot(dx, dy), limit * metric.apart(pairs[i][0], pairs[i][1]));
            largest = f64::max(largest, (distance - most).abs());
            steps[i] = (distance - most) * distance * distance / most;
            for k in 0..count {
                let ([a, b], [c, d]) = (pairs[i], pairs[k]);
                let coupling = inverse[a][c] - inverse[a][d] - inverse[b][c] + inverse[b][d];
                let [ex, ey] = apart(pairs[k]);
                system[i][k] = coupling * (dx * ex + dy * ey);
            }
            // Where points coincide, only sums of multipliers are determined.
            system[i][i] *= 1.0 + 1e-10;
        }

        if !(x.max_abs() + y.max_abs()).is_finite() {
            return None;
        }
        if largest <= tolerance {
            let ([a, b], square) = metric.farthest(&x.0, &y.0);
            if square <= (limit + 2.0 * tolerance / metric.smallest()).powi(2) {
                return Some(Tangent([x, y]));
            }
            if count == MAX_PAIRS || pairs[..count].contains(&[a, b]) {
                return None;
            }
            (pairs[count], multipliers[count]) = ([a, b], 0.0);
            count += 1;
            continue;
        }
        invert(&mut system, count);
        let steps = Row(steps);
        let mut kept = 0;
        for i in 0..count {
            let next = multipliers[i] + Row(system[i]).dot(steps);
            // A pair that would be pushed apart takes no part.
            if next > 0.0 {
                (pairs[kept], multipliers[kept]) = (pairs[i], next);
                kept += 1;
            }
        }
        count = kept;
    }
    None
}

/// Inverts the first n rows and columns of a positive definite matrix in place, exchanging one row and column after the other.
fn invert<const N: usize>(matrix: &mut [[f64; N]; N], n: usize) {
    for k in 0..n {
        let pivot = 1.0 / matrix[k][k];
        let row = matrix[k];
        for i in (0..n).filter(|&i| i != k) {
            let factor = matrix[i][k] * pivot;
            if factor != 0.0 {
                for j in 0..n {
                    matrix[i][j] -= factor * row[j];
                }
            }
            matrix[i][k] = -factor;
        }
        for j in 0..n {
            matrix[k][j] = row[j] * pivot;
        }
        matrix[k][k] = pivot;
    }
}
