//! The smallest covariance of a region, relative to the covariance of all data.
//!
//! ```text
//! Sigma_p >= FLOOR G,     G = the covariance of the data
//! ```
//!
//! Without such a bound the energy has no minimum: a region with a single datum, or with equal data, has an
//! unbounded density. C. M. Bishop, *Pattern Recognition and Machine Learning*, 2006, section 9.2.1.

use nalgebra::DMatrix;

use super::normal::{MAX_DIMENSION, Moments};
use crate::data::Data;
use crate::error::{Error, Result};

/// No standard deviation of a region is less than 1 % of that of all data in the same direction: about the rounding of
/// colors of 8 bits, below which a spread means nothing.
pub const FLOOR: f64 = 1e-4;

/// The data do not vary in directions in which their correlation matrix has no larger eigenvalue.
const RANK_TOLERANCE: f64 = 1e-8;

/// Data are equal if they differ by no more than this fraction of them.
const EQUAL_WITHIN: f64 = 1e-13;

/// G and its factorization.
#[derive(Clone)]
pub struct Floor {
    /// The mean of the data.
    pub center: Vec<f64>,
    /// G = L L^T, where G is 1 in coordinates of unit variance along directions in which the data do not vary: all
    /// regions have the same covariance there.
    factor: DMatrix<f64>,
    /// L^-1.
    whitening: DMatrix<f64>,
    /// Number of directions in which the data vary.
    pub rank: usize,
}

impl Floor {
    /// Mean and covariance over the vertices of which anything is known.
    ///
    /// # Errors
    /// Data of too many dimensions, and data whose variances leave the range of double precision.
    pub fn of(data: &Data) -> Result<Self> {
        let d = data.dimension;
        if d > MAX_DIMENSION {
            return Err(Error::unsuitable(format!(
                "the data have {d} columns, and the model gaussian takes at most {MAX_DIMENSION}: choose fewer, or \
                 another model"
            )));
        }
        let known = || (0..data.len()).filter_map(|k| data.known(k));
        let n = known().count() as f64;
        let mean_of = |of: &dyn Fn(&[f64]) -> f64| known().map(|c| of(c) / n).sum::<f64>();
        let center: Vec<f64> = (0..d).map(|i| mean_of(&|c| c[i])).collect();
        let deviation = |i: usize| {
            let largest = known().map(|c| (c[i] - center[i]).abs()).fold(0.0, f64::max);
            // Equal data differ from their rounded mean.
            if largest <= EQUAL_WITHIN * center[i].abs() {
                return 0.0;
            }
            largest * mean_of(&|c| ((c[i] - center[i]) / largest).powi(2)).sqrt()
        };
        let deviations: Vec<f64> = (0..d).map(deviation).collect();
        // With room for sums and products of a few variances.
        let is_in_range = |s: f64| (FLOOR * s * s).is_normal() && (s * s / FLOOR).is_finite();
        if deviations.iter().any(|&s| s != 0.0 && !is_in_range(s)) {
            return Err(Error::unsuitable(
                "the variances of the data leave the range of double precision; scale the data",
            ));
        }
        let units: Vec<f64> = deviations.iter().map(|&s| if s > 0.0 { s } else { 1.0 }).collect();
        let unit = |c: &[f64], i: usize| (c[i] - center[i]) / units[i];
        let correlation = DMatrix::from_fn(d, d, |i, j| {
            if deviations[i] * deviations[j] > 0.0 {
                mean_of(&|c| unit(c, i) * unit(c, j))
            } else {
                0.0
            }
        });
        let mut eigen = correlation.symmetric_eigen();
        let varies = |&r: &f64| r > RANK_TOLERANCE;
        let rank = eigen.eigenvalues.iter().filter(|r| varies(r)).count();
        eigen.eigenvalues.apply(|r| *r = if varies(r) { *r } else { 1.0 });
        let correlation = eigen.recompose();
        let factor = correlation.cholesky().expect("all eigenvalues are positive").l();
        let factor = DMatrix::from_fn(d, d, |i, j| units[i] * factor[(i, j)]);
        let whitening = factor.solve_lower_triangular(&DMatrix::identity(d, d));
        let whitening = whitening.expect("L has a positive diagonal");
        Ok(Floor { center, factor, whitening, rank })
    }

    /// L^-1 (c - center).
    pub fn whitened(&self, c: &[f64]) -> impl Iterator<Item = f64> {
        let x: Vec<f64> = c.iter().zip(&self.center).map(|(c, center)| c - center).collect();
        (0..x.len()).map(move |i| (0..=i).map(|j| self.whitening[(i, j)] * x[j]).sum())
    }

    /// The covariance Sigma >= FLOOR G that minimizes the mean cost of data of covariance S: in coordinates in which G is
    /// the identity it has the eigenvectors of S, and its eigenvalues raised to the floor.
    ///
    /// The mean cost is (1/2) ( tr Sigma^-1 S + log det Sigma ) there. By von Neumann's trace inequality the trace is
    /// smallest for common eigenvectors in the same order; then e / sigma + log sigma decreases up to sigma = e and
    /// increases beyond.
    pub fn raised(&self, moments: Moments) -> Moments {
        let d = self.center.len();
        let s = DMatrix::from_fn(d, d, |i, j| moments.covariance[i][j]);
        let mut eigen = (&self.whitening * s * self.whitening.transpose()).symmetric_eigen();
        if eigen.eigenvalues.iter().all(|&e| e >= FLOOR) {
            return moments;
        }
        eigen.eigenvalues.apply(|e| *e = e.max(FLOOR));
        let sigma = &self.factor * eigen.recompose() * self.factor.transpose();
        // Symmetric up to rounding.
        let entry = |i: usize, j: usize| sigma[(i.max(j), i.min(j))];
        let covariance = (0..d).map(|i| (0..d).map(|j| entry(i, j)).collect()).collect();
        Moments { covariance, ..moments }
    }
}
