//! The discrete gradient K, accessed by rows.
//!
//! ```text
//! (K U)_j = A_j grad_j U  in R^{2 x m},  in an orthonormal frame of face j
//! ```
//!
//! Every method consists of a sweep over faces that uses (K u)_j and a sweep over vertices that uses (K^T q)_v, so an
//! operator and its adjoint provide just these rows: a line of the paper becomes one fused loop, and K u is never
//! stored. [`Stencil`] is the fast implementation; [`Matrix`], assembled from another formula, is the reference.

pub mod bounds;
mod cholesky;
pub mod export;
mod gauss_seidel;
pub mod mass;
mod matrix;
mod normal;
mod norms;
#[cfg(feature = "experiments")]
pub mod npz;
mod stencil;

#[cfg(test)]
mod tests;

pub(crate) use cholesky::Cholesky;
pub(crate) use gauss_seidel::GaussSeidel;
pub use mass::{Mass, Quadrature};
pub use matrix::Matrix;
pub(crate) use normal::normal_matrix;
pub use stencil::Stencil;

use crate::field::{Row, Tangent};
use crate::relaxation::DualSet;

/// One face of K: its vertices, and the column K_jk in R^2 of each.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// k = 1, 2, 3: the vertices of the face, each below V.
    pub corners: [usize; 3],
    /// K_j1, K_j2, K_j3 in the frame of the face, in units of length; they sum to zero.
    pub columns: [[f64; 2]; 3],
}

/// K for F faces and V vertices, by its rows. All faces have positive area.
pub trait Operator: Sync {
    /// K^T, ready for sweeps over the vertices.
    type Adjoint<'a>: Adjoint
    where
        Self: 'a;

    /// F.
    fn faces(&self) -> usize;

    /// V, including unreferenced vertices.
    fn vertices(&self) -> usize;

    /// A_j, in squared units of length.
    fn area(&self, j: usize) -> f64;

    /// The corners and columns of face j.
    fn face(&self, j: usize) -> Face;

    /// K^T. The first call may assemble it with all threads, so call it before a sweep, not inside.
    fn adjoint(&self) -> Self::Adjoint<'_>;

    /// (K u)_j; u has one row per vertex.
    fn at<const M: usize>(&self, u: &[Row<M>], j: usize) -> Tangent<M>;

    /// |(K u)_j| of the faces from `first` on, in the norm of a relaxation, one for each entry of `norms`.
    #[inline(always)]
    fn norms<const M: usize>(
        &self,
        set: impl DualSet,
        u: &[Row<M>],
        first: usize,
        norms: &mut [f64],
    ) {
        for (norm, j) in norms.iter_mut().zip(first..) {
            *norm = set.support(self.at(u, j));
        }
    }
}

/// K^T by its rows.
pub trait Adjoint: Copy + Sync {
    /// (K^T q)_v; q has one tangent per face.
    fn at<const M: usize>(self, q: &[Tangent<M>], v: usize) -> Row<M>;
}
