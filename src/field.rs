//! The two value types of the method: a row u_k of the labels U at a vertex, and the two rows of (K U)_j or of the dual
//! field q_j on a face, in the orthonormal frame of the face.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use pulp::bytemuck::TransparentWrapper;

/// u_k in R^m: one number per region at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Row<const M: usize>(pub [f64; M]);

// SAFETY: `repr(transparent)`, without any other field.
unsafe impl<const M: usize> TransparentWrapper<[f64; M]> for Row<M> {}

/// q_j in R^{2 x m}: one tangent vector per region on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Tangent<const M: usize>(pub [Row<M>; 2]);

impl<const M: usize> Row<M> {
    /// All entries 0.
    pub const ZERO: Self = Row([0.0; M]);

    /// The row with entries `value(p)`, called for p = 0, 1, ..., M - 1.
    #[inline(always)]
    pub fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
        let mut row = Row::ZERO;
        for p in 0..M {
            row.0[p] = value(p);
        }
        row
    }

    /// The vertex of the simplex that represents region p.
    #[inline(always)]
    pub fn one_hot(p: usize) -> Self {
        Row::from_fn(|i| f64::from(i == p))
    }

    /// sum_p a_p b_p, summed in the order of p.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f64 {
        let mut sum = 0.0;
        for p in 0..M {
            sum += self.0[p] * other.0[p];
        }
        sum
    }

    /// sum_p u_p^2.
    #[inline(always)]
    pub fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    /// The smallest entry; NaN if any entry is NaN.
    #[inline(always)]
    pub fn min(self) -> f64 {
        self.0[1..].iter().fold(self.0[0], |a, &b| if b < a || b.is_nan() { b } else { a })
    }

    /// The largest entry; NaN if any entry is NaN.
    #[inline(always)]
    pub fn max(self) -> f64 {
        -(-self).min()
    }

    /// max_p |entry|; NaN if any entry is NaN.
    #[inline(always)]
    pub fn max_abs(self) -> f64 {
        Row::<M>::from_fn(|p| self.0[p].abs()).max()
    }

    /// The region with the largest entry; the first one in case of ties.
    #[inline(always)]
    pub fn argmax(self) -> usize {
        (1..M).fold(0, |best, p| if self.0[p] > self.0[best] { p } else { best })
    }

    /// The region with the smallest entry; the first one in case of ties.
    #[inline(always)]
    pub fn argmin(self) -> usize {
        (-self).argmax()
    }
}

impl<const M: usize> Tangent<M> {
    /// All entries 0.
    pub const ZERO: Self = Tangent([Row::ZERO; 2]);

    /// Frobenius inner product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f64 {
        self.0[0].dot(other.0[0]) + self.0[1].dot(other.0[1])
    }

    /// Squared Frobenius norm.
    #[inline(always)]
    pub fn norm_squared(self) -> f64 {
        // One sum per region: these fit a vector register, the two sums of `dot` do not.
        let Tangent([a, b]) = self;
        Row::<M>::from_fn(|p| a.0[p] * a.0[p] + b.0[p] * b.0[p]).0.iter().sum()
    }

    /// Frobenius norm, the |.| of the total variation.
    #[inline(always)]
    pub fn norm(self) -> f64 {
        self.norm_squared().sqrt()
    }
}

impl<const M: usize> Add for Row<M> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Row::from_fn(|p| self.0[p] + other.0[p])
    }
}

impl<const M: usize> Sub for Row<M> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Row::from_fn(|p| self.0[p] - other.0[p])
    }
}

impl<const M: usize> Mul<f64> for Row<M> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: f64) -> Self {
        Row::from_fn(|p| self.0[p] * scale)
    }
}

impl<const M: usize> Mul<Row<M>> for f64 {
    type Output = Row<M>;
    #[inline(always)]
    fn mul(self, row: Row<M>) -> Row<M> {
        row * self
    }
}

impl<const M: usize> Neg for Row<M> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Row::from_fn(|p| -self.0[p])
    }
}

impl<const M: usize> AddAssign for Row<M> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const M: usize> Add for Tangent<M> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Tangent([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl<const M: usize> Sub for Tangent<M> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Tangent([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl<const M: usize> Mul<f64> for Tangent<M> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: f64) -> Self {
        Tangent([self.0[0] * scale, self.0[1] * scale])
    }
}

impl<const M: usize> Mul<Tangent<M>> for f64 {
    type Output = Tangent<M>;
    #[inline(always)]
    fn mul(self, tangent: Tangent<M>) -> Tangent<M> {
        tangent * self
    }
}
