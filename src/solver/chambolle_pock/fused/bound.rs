//! D(q) of a part in double precision, where the state is in single: q is made feasible, K^T q summed anew.
//!
//! ```text
//! D(q) = sum_k min_p ( f_k + (K^T q)_k )_p,   |q_j| <= lambda
//! ```

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::lanes::{Real, WIDEST, width};
use super::layout::{Layout, NO_FACE};
use super::part::{Part, Units, groups};
use crate::field::Row;
use crate::operator::Stencil;
use crate::problem::Problem;

/// K^T q in double precision by place, four regions beside each other: all zeros, or empty, from one look to the next.
pub type Scratch = Vec<[f64; 4]>;

/// min_p ( f_k + (K^T q)_k )_p of the own vertices of a part. A vertex sums its faces in the order of all parts.
pub struct Bounds<'a, K, T, const M: usize> {
    pub part: &'a Part<T>,
    pub layout: &'a Layout,
    pub problem: &'a Problem<K, M>,
    pub stencil: &'a Stencil,
    pub units: Units,
    /// The lane of each row in a vector of double precision.
    pub order: &'a [usize],
    pub scratch: &'a mut Scratch,
    pub bounds: &'a mut [f64],
}

type V<S> = <f64 as Real>::Vector<S>;

/// A block of single precision has as many lanes as two vectors of double precision, at most.
type Pair<S> = [V<S>; 2];

impl<K, T: Real, const M: usize> WithSimd for Bounds<'_, K, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Bounds { part, layout, problem, stencil, units, order, scratch: kq, bounds } = self;
        let (wide, narrow) = (width::<T, S>(), width::<f64, S>());
        let halves = wide.div_ceil(narrow);
        // Vectors of double precision take the lanes of a block as they come. To each row its place behind them.
        let lanes = &layout.lanes.order;
        let mut place_of_lane = [0; WIDEST];
        for (o, &lane) in order.iter().enumerate() {
            place_of_lane[lane] = o;
        }
        let mut place = [0; WIDEST];
        for (place, lane) in place.iter_mut().zip(lanes) {
            *place = lane / narrow * narrow + place_of_lane[lane % narrow];
        }
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let (lambda, unit) = (simd.splat_f64s(problem.lambda), simd.splat_f64s(1.0 / units.q));
        kq.resize(part.tau.len() * groups(M), [0.0; 4]);
        // Those at own vertices, and at some others.
        let held = part.face_places(&layout.faces_at(&part.window.own));
        let faces = part.window.faces[held.clone()].chunks_exact(wide);
        let corners = part.window.places[3 * held.start..3 * held.end].chunks_exact(3 * wide);
        let q = part.q[2 * M * held.start..2 * M * held.end].chunks_exact(2 * M * wide);
        for ((faces, q), corners) in faces.zip(q).zip(corners) {
            let mut y: [[Pair<S>; M]; 2] = [[[zero; 2]; M]; 2];
            for (y, q) in y.as_flattened_mut().iter_mut().zip(q.chunks_exact(wide)) {
                for (y, q) in cast_slice_mut::<_, f64>(y).iter_mut().zip(q) {
                    *y = q.to_f64();
                }
            }
            // Faces that only fill up the block keep weights of zero.
            let mut c: [Pair<S>; 3] = [[zero; 2]; 3];
            for (&j, &lane) in faces.iter().zip(lanes) {
                if j == NO_FACE {
                    continue;
                }
                for (c, weight) in c.iter_mut().zip(stencil.weights()[j as usize]) {
                    cast_slice_mut::<_, f64>(c)[lane] = weight;
                }
            }
            for half in 0..halves {
                let mut squares = zero;
                for y in y.as_flattened_mut() {
                    y[half] = simd.mul_f64s(y[half], unit);
                    squares = simd.add_f64s(squares, simd.mul_f64s(y[half], y[half]));
                }
                // y = Proj_{|.|<=lambda}( y )
                let norm = simd.sqrt_f64s(squares);
                let outside = simd.less_than_f64s(lambda, norm);
                let scale = simd.div_f64s(
                    simd.select_f64s(outside, lambda, one),
                    simd.select_f64s(outside, norm, one),
                );
                for c in &mut c {
                    c[half] = simd.mul_f64s(c[half], scale);
                }
            }
            for g in 0..groups(M) {
                let mut sums = [[[zero; 4]; 2]; 3];
                for half in 0..halves {
                    for p in 4 * g..M.min(4 * g + 4) {
                        let [y1, y2] = [y[0][p][half], y[1][p][half]];
                        let second = simd
                            .add_f64s(simd.mul_f64s(y1, c[0][half]), simd.mul_f64s(y2, c[1][half]));
                        let third = simd.mul_f64s(y2, c[2][half]);
                        sums[0][half][p % 4] = simd.sub_f64s(zero, simd.add_f64s(second, third));
                        sums[1][half][p % 4] = second;
                        sums[2][half][p % 4] = third;
                    }
                    for sums in &mut sums {
                        sums[half] = simd.interleave_shfl_f64s(sums[half]);
                    }
                }
                let sums: [&[[f64; 4]]; 3] =
                    [cast_slice(&sums[0]), cast_slice(&sums[1]), cast_slice(&sums[2])];
                for (o, &place) in place[..wide].iter().enumerate() {
                    for i in 0..3 {
                        let row = &mut kq[corners[i * wide + o] as usize * groups(M) + g];
                        *row = f64::add_rows(*row, sums[i][place]);
                    }
                }
            }
        }
        let own = part.places(&part.window.own).start * groups(M);
        let f = &problem.f[part.own()];
        let kq_rows = kq[own..].chunks_exact(groups(M));
        for ((bound, kq), &f) in bounds.iter_mut().zip(kq_rows).zip(f) {
            *bound = (f + Row::from_fn(|p| kq[p / 4][p % 4])).min();
        }
        kq.fill([0.0; 4]);
    }
}
