//! |(K u)_j| of the stencil, one lane per face.
//!
//! ```text
//! |(K u)_jp|^2 = (c1 ua)_p^2 + (c2 ua + c3 ub)_p^2,   ua = u2 - u1, ub = u3 - u1
//! |(K u)_j|    = sqrt( sum_p |(K u)_jp|^2 )   or, of regions taken separately,   sum_p |(K u)_jp| / sqrt(2)
//! ```
//!
//! Bitwise equal to the norm of [`product`] for each face, whatever the vector instructions.

use std::f64::consts::FRAC_1_SQRT_2;

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use crate::field::{Row, Tangent};
use crate::relaxation::{DualSet, Separate};

pub struct Norms<'a, const SEPARATE: bool, const M: usize> {
    /// The three vertices of each face.
    pub corners: &'a [[u32; 3]],
    /// c1, c2, c3 of each face.
    pub weights: &'a [[f64; 3]],
    pub u: &'a [Row<M>],
    pub first: usize,
    /// The norms of the faces from `first` on.
    pub norms: &'a mut [f64],
}

impl<const SEPARATE: bool, const M: usize> WithSimd for Norms<'_, SEPARATE, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Norms { corners: all_corners, weights: all_weights, u, first, norms } = self;
        let faces = first..first + norms.len();
        let lanes = size_of::<S::f64s>() / size_of::<f64>();
        let corners = all_corners[faces.clone()].chunks_exact(lanes);
        let weights = all_weights[faces.clone()].chunks_exact(lanes);
        let mut blocks = norms.chunks_exact_mut(lanes);
        for ((corners, weights), norms) in corners.zip(weights).zip(&mut blocks) {
            let [c1, c2, c3, _] = gather(
                simd,
                #[inline(always)]
                |o| [weights[o][0], weights[o][1], weights[o][2], 0.0],
            );
            let mut sum = simd.splat_f64s(0.0);
            for g in 0..M.div_ceil(4) {
                // Not in a loop over the corners, which would keep the gathered values in memory instead of registers.
                let u1 = gather_u(simd, u, corners, 0, g);
                let u2 = gather_u(simd, u, corners, 1, g);
                let u3 = gather_u(simd, u, corners, 2, g);
                for p in 0..4.min(M - 4 * g) {
                    let ua = simd.sub_f64s(u2[p], u1[p]);
                    let ub = simd.sub_f64s(u3[p], u1[p]);
                    let ku1 = simd.mul_f64s(ua, c1);
                    let ku2 = simd.add_f64s(simd.mul_f64s(ua, c2), simd.mul_f64s(ub, c3));
                    let square = simd.add_f64s(simd.mul_f64s(ku1, ku1), simd.mul_f64s(ku2, ku2));
                    let term = if SEPARATE { simd.sqrt_f64s(square) } else { square };
                    sum = simd.add_f64s(sum, term);
                }
            }
            // Back from lanes to the order of the faces.
            let norm = if SEPARATE {
                simd.mul_f64s(sum, simd.splat_f64s(FRAC_1_SQRT_2))
            } else {
                simd.sqrt_f64s(sum)
            };
            let rows = simd.interleave_shfl_f64s([norm; 4]);
            for (norm, row) in norms.iter_mut().zip(cast_slice::<_, [f64; 4]>(&rows)) {
                *norm = row[0];
            }
        }
        let rest = blocks.into_remainder();
        let last = faces.end - rest.len();
        for (norm, j) in rest.iter_mut().zip(last..) {
            let ku = product(all_corners[j], all_weights[j], u);
            *norm = if SEPARATE { Separate.support(ku) } else { ku.norm() };
        }
    }
}

/// (K u)_j.
#[inline(always)]
pub fn product<const M: usize>(
    corners: [u32; 3],
    [c1, c2, c3]: [f64; 3],
    u: &[Row<M>],
) -> Tangent<M> {
    let [u1, u2, u3] = corners.map(|v| u[v as usize]);
    let (ua, ub) = (u2 - u1, u3 - u1);
    Tangent([ua * c1, ua * c2 + ub * c3])
}

/// Entries 4g to 4g + 3 of u at one corner of each face, with zeros beyond the end of a row.
#[inline(always)]
fn gather_u<S: Simd, const M: usize>(
    simd: S,
    u: &[Row<M>],
    corners: &[[u32; 3]],
    corner: usize,
    g: usize,
) -> [S::f64s; 4] {
    gather(
        simd,
        #[inline(always)]
        |o| {
            let row = &u[corners[o][corner] as usize];
            let mut entries = [0.0; 4];
            for p in 4 * g..M.min(4 * g + 4) {
                entries[p % 4] = row.0[p];
            }
            entries
        },
    )
}

/// Transposes one row of four numbers per lane.
#[inline(always)]
fn gather<S: Simd>(simd: S, row: impl Fn(usize) -> [f64; 4]) -> [S::f64s; 4] {
    let mut rows = [simd.splat_f64s(0.0); 4];
    for (o, entry) in cast_slice_mut::<_, [f64; 4]>(&mut rows).iter_mut().enumerate() {
        *entry = row(o);
    }
    simd.deinterleave_shfl_f64s(rows)
}
