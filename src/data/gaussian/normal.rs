//! The normal distribution of a region: its parameters, its density, and how far two of them differ.
//!
//! Symmetric matrices are packed: the entries (i, j) with j <= i, row by row, d (d + 1) / 2 of them.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Maximum dimension of the data: a covariance has d (d + 1) / 2 numbers, and a region has to determine them.
pub const MAX_DIMENSION: usize = 16;

/// mu_p and Sigma_p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moments {
    /// d numbers, in the units of the data.
    pub mean: Vec<f64>,
    /// The d rows of a positive definite matrix, in the units of squared data.
    pub covariance: Vec<Vec<f64>>,
}

impl Moments {
    /// Fails with a message if Sigma is not a symmetric positive definite matrix of the dimension of mu.
    pub fn check(&self) -> Result<(), &'static str> {
        let (d, rows) = (self.mean.len(), &self.covariance);
        if rows.len() != d || rows.iter().any(|row| row.len() != d) {
            return Err(
                "the covariance must have as many rows and columns as the mean has numbers",
            );
        }
        if (0..d).any(|i| (0..i).any(|j| rows[i][j] != rows[j][i])) {
            return Err("the covariance is not symmetric");
        }
        let sigma = DMatrix::from_fn(d, d, |i, j| rows[i][j]);
        let regular =
            sigma.cholesky().is_some_and(|factor| factor.l().iter().all(|l| l.is_finite()));
        if regular { Ok(()) } else { Err("the covariance is not positive definite") }
    }

    /// Sigma = L L^T, L lower triangular. Panics if Sigma is not positive definite.
    fn factor(&self) -> DMatrix<f64> {
        let d = self.mean.len();
        assert!(self.covariance.len() == d && self.covariance.iter().all(|row| row.len() == d));
        let sigma = DMatrix::from_fn(d, d, |i, j| self.covariance[i][j]);
        sigma.cholesky().expect("covariances are positive definite").l()
    }
}

/// Number of entries of a packed matrix.
pub fn packed(d: usize) -> usize {
    d * (d + 1) / 2
}

/// Minus the logarithm of a normal density, prepared to be evaluated at many data.
pub struct Density {
    mean: Vec<f64>,
    /// L, packed, with the reciprocals of its diagonal.
    factor: Vec<f64>,
    /// Sigma^-1, packed, with entries off the diagonal doubled.
    precision: Vec<f64>,
    /// (1/2) log det Sigma + (d/2) log 2 pi.
    constant: f64,
}

impl Density {
    /// Panics if Sigma is not positive definite.
    pub fn new(moments: &Moments) -> Self {
        let d = moments.mean.len();
        let l = moments.factor();
        let identity = DMatrix::identity(d, d);
        let inverse = l.solve_lower_triangular(&identity).expect("L has a positive diagonal");
        let precision = inverse.tr_mul(&inverse);
        let pack = |entry: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..d).flat_map(|i| (0..=i).map(move |j| entry(i, j))).collect()
        };
        Density {
            mean: moments.mean.clone(),
            factor: pack(&|i, j| if i == j { 1.0 / l[(i, i)] } else { l[(i, j)] }),
            precision: pack(&|i, j| {
                if i == j { precision[(i, i)] } else { 2.0 * precision[(i, j)] }
            }),
            constant: l.diagonal().iter().map(|l| l.ln()).sum::<f64>() + 0.5 * d as f64 * TAU.ln(),
        }
    }

    /// (1/2) (c - mu)^T Sigma^-1 (c - mu) + (1/2) log det Sigma + (d/2) log 2 pi; for data of mean c and of the packed
    /// scatter S, if it is not empty, the mean of that over them: with (1/2) tr Sigma^-1 S in addition.
    #[inline(always)]
    pub fn cost(&self, c: &[f64], scatter: &[f64]) -> f64 {
        let squared = match c.len() {
            1 => self.squared::<1>(c),
            2 => self.squared::<2>(c),
            3 => self.squared::<3>(c),
            _ => self.squared_of_any_dimension(c),
        };
        let within: f64 = self.precision.iter().zip(scatter).map(|(a, b)| a * b).sum();
        0.5 * (squared + within) + self.constant
    }

    /// |L^-1 (c - mu)|^2 by forward substitution.
    #[inline(always)]
    fn squared<const D: usize>(&self, c: &[f64]) -> f64 {
        let (mut y, mut sum) = ([0.0; D], 0.0);
        for i in 0..D {
            let row = &self.factor[packed(i)..=packed(i) + i];
            let known: f64 = (0..i).map(|j| row[j] * y[j]).sum();
            y[i] = (c[i] - self.mean[i] - known) * row[i];
            sum += y[i] * y[i];
        }
        sum
    }

    fn squared_of_any_dimension(&self, c: &[f64]) -> f64 {
        let (mut y, mut sum) = ([0.0; MAX_DIMENSION], 0.0);
        for i in 0..c.len() {
            let row = &self.factor[packed(i)..=packed(i) + i];
            let known: f64 = row.iter().zip(&y[..i]).map(|(l, y)| l * y).sum();
            y[i] = (c[i] - self.mean[i] - known) * row[i];
            sum += y[i] * y[i];
        }
        sum
    }
}

/// The square root of the symmetric Kullback-Leibler divergence
///
/// ```text
/// J(a, b) = E_a (s_b - s_a) + E_b (s_a - s_b)
///         = (1/2) ( tr Sigma_a^-1 Sigma_b + tr Sigma_b^-1 Sigma_a - 2 d + |mu_a - mu_b|^2_{Sigma_a^-1 + Sigma_b^-1} )
/// ```
///
/// which is what it costs to take data of either region for data of the other. It does not change with the units of the
/// data; for a common Sigma it is the Mahalanobis distance of the means. S. Kullback, *Information Theory and
/// Statistics*, 1959, chapter 9.
pub fn distance(a: &Moments, b: &Moments) -> f64 {
    if a == b {
        return 0.0;
    }
    let factors = [a, b].map(Moments::factor);
    let [l_a, l_b] = &factors;
    let solved = |l: &DMatrix<f64>, right: &DMatrix<f64>| {
        l.solve_lower_triangular(right).expect("L has a positive diagonal")
    };
    // tr Y Y^T + tr (Y Y^T)^-1 - 2 d = |Y - Y^-T|^2 for Y = L_a^-1 L_b, without cancellation.
    let spread = (solved(l_a, l_b) - solved(l_b, l_a).transpose()).norm_squared();
    let between = a.mean.iter().zip(&b.mean).map(|(a, b)| a - b);
    let between = DVector::from_iterator(a.mean.len(), between);
    let whitened = |l: &DMatrix<f64>| {
        let solution = l.solve_lower_triangular(&between);
        solution.expect("L has a positive diagonal").norm_squared()
    };
    (0.5 * (spread + whitened(l_a) + whitened(l_b))).sqrt()
}

/// Weighted sums over data, relative to a center.
#[derive(Clone)]
pub struct Sums {
    /// sum w.
    pub mass: f64,
    /// sum w (c - center).
    first: Vec<f64>,
    /// sum w ((c - center) (c - center)^T + S), packed.
    second: Vec<f64>,
}

impl Sums {
    /// Of no data in R^d.
    pub fn new(d: usize) -> Self {
        Sums { mass: 0.0, first: vec![0.0; d], second: vec![0.0; packed(d)] }
    }

    /// Adds data of weight w, mean c and packed scatter S, which is empty for a single datum.
    #[inline(always)]
    pub fn add(&mut self, w: f64, c: &[f64], scatter: &[f64], center: &[f64]) {
        self.mass += w;
        let mut x = [0.0; MAX_DIMENSION];
        for (i, (c, center)) in c.iter().zip(center).enumerate() {
            x[i] = c - center;
            let weighted = w * x[i];
            self.first[i] += weighted;
            let row = &mut self.second[packed(i)..=packed(i) + i];
            row.iter_mut().zip(&x).for_each(|(sum, x)| *sum += weighted * x);
        }
        self.second.iter_mut().zip(scatter).for_each(|(sum, s)| *sum += w * s);
    }

    /// Adds the sums of other data.
    pub fn merge(&mut self, other: &Sums) {
        self.mass += other.mass;
        self.first.iter_mut().zip(&other.first).for_each(|(a, b)| *a += b);
        self.second.iter_mut().zip(&other.second).for_each(|(a, b)| *a += b);
    }

    /// The mean and the covariance, whose eigenvalues may be zero; the mass is positive.
    pub fn moments(&self, center: &[f64]) -> Moments {
        let offset: Vec<f64> = self.first.iter().map(|sum| sum / self.mass).collect();
        let entry = |i: usize, j: usize| {
            self.second[packed(i.max(j)) + i.min(j)] / self.mass - offset[i] * offset[j]
        };
        let d = center.len();
        Moments {
            mean: center.iter().zip(&offset).map(|(center, x)| center + x).collect(),
            covariance: (0..d).map(|i| (0..d).map(|j| entry(i, j)).collect()).collect(),
        }
    }
}
