//! The dual bound D(q), part by part, in double precision:
//!
//! ```text
//! D(q) = sum_k min_p ( f_k + (K^T q)_k )_p,   |q_j| <= lambda
//! ```
//!
//! If the state is in single precision, q is made feasible and K^T q is summed anew, as in `pass`: faces store their
//! shares, and a vertex sums them up as soon as its last face is done.

use std::slice;

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::lanes::{MAX_LANES, Real, gather, surely_inside, width};
use super::layout::{BlockLayout, GROUP, NO_FACE};
use super::part::{Part, Units, groups, share_slots};
use super::pass::Ball;
use crate::field::Row;
use crate::operator::Stencil;
use crate::problem::Problem;

/// Computes min_p ( f_k + (K^T q)_k )_p at the own vertices of a part in double precision, from the stored K^T q.
pub struct KnownBounds<'a, T> {
    pub part: &'a Part<T>,
    pub bounds: &'a mut [f64],
}

/// The same for a part in single precision. A vertex sums its faces in one order, whichever part it is in.
pub struct Bounds<'a, T, const M: usize> {
    pub part: &'a Part<T>,
    pub layout: &'a BlockLayout,
    pub problem: &'a Problem<Stencil, M>,
    pub units: Units,
    /// The lane order of vectors of double precision.
    pub order: &'a [usize],
    /// Room for the shares of K^T q in double precision, stored as those of one iteration in a part.
    pub shares: &'a mut [f64],
    pub bounds: &'a mut [f64],
}

type V<S> = <f64 as Real>::Vector<S>;

impl<T: Real> WithSimd for KnownBounds<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let KnownBounds { part, bounds } = self;
        let (width, m) = (width::<T, S>(), part.m);
        let own = part.vertex_slots(&part.window.own);
        let kq = part.kq()[own.start * m..].chunks_exact(m * width);
        let f = part.f()[own.start * m..].chunks_exact(m * width);
        for ((bounds, kq), f) in bounds.chunks_mut(width).zip(kq).zip(f) {
            let mut smallest = [f64::INFINITY; MAX_LANES];
            for (kq, f) in kq.chunks_exact(width).zip(f.chunks_exact(width)) {
                for ((smallest, kq), f) in smallest[..width].iter_mut().zip(kq).zip(f) {
                    *smallest = min_or_nan(*smallest, f.to_f64() + kq.to_f64());
                }
            }
            for (bound, &lane) in bounds.iter_mut().zip(&part.lanes.order) {
                *bound = smallest[lane];
            }
        }
    }
}

/// The minimum of a and b; NaN if one of them is.
#[inline(always)]
fn min_or_nan(a: f64, b: f64) -> f64 {
    if b < a || b.is_nan() { b } else { a }
}

impl<T: Real, const M: usize> WithSimd for Bounds<'_, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Bounds { part, layout, problem, units, order, shares, bounds } = self;
        let (width, window) = (width::<T, S>(), &part.window);
        let (own, first_faces) = (&window.own, window.held_faces.start);
        let share_slots = share_slots(layout);
        let shares = shares.as_chunks_mut::<4>().0;
        let ball = Ball::new(problem.relaxation, problem.lambda);
        let kernel = BoundKernel {
            simd,
            one: simd.splat_f64s(1.0),
            radius: simd.splat_f64s(ball.radius),
            is_separate: ball.is_separate,
            surely_inside: simd.splat_f64s(surely_inside::<f64>(ball.radius)),
            unit: simd.splat_f64s(1.0 / units.q),
            weights: problem.k.weights(),
            order,
            positions: positions_of_halves::<T, S>(&layout.lanes.order, order),
            share_slots,
        };
        let mut vertices = bounds.chunks_mut(width).zip(problem.f[part.own()].chunks(width));
        let (mut due, mut sums) = (layout.due_before(own.start), own.start);
        for block in own.start..window.reach[1].end {
            let next = layout.due_before(block + 1);
            for j in due - first_faces..next - first_faces {
                let (faces, q) = (&window.faces[width * j..], &part.q()[2 * M * width * j..]);
                let shares = &mut shares[j % layout.ring_length * 3 * width..];
                kernel.faces::<T, M>(&faces[..width], &q[..2 * M * width], shares);
            }
            due = next;
            while sums < own.end && layout.is_done(sums, block + 1) {
                let offsets = window.share_offsets.block(sums - window.held_vertices().start);
                let (bounds, f) = vertices.next().expect("one for each own block");
                kernel.vertices::<T, M>(shares, offsets, f, bounds);
                sums += 1;
            }
        }
    }
}

/// Each vector of double precision takes the next lanes of a block: for each position of the first one, then of the
/// second one, ..., the position in the block.
fn positions_of_halves<T: Real, S: Simd>(lanes: &[usize], order: &[usize]) -> [usize; MAX_LANES] {
    let narrow = width::<f64, S>();
    let mut position_of_lane = [0; MAX_LANES];
    for (position, &lane) in lanes.iter().enumerate() {
        position_of_lane[lane] = position;
    }
    let mut positions = [0; MAX_LANES];
    for (i, position) in positions[..lanes.len()].iter_mut().enumerate() {
        *position = position_of_lane[i / narrow * narrow + order[i % narrow]];
    }
    positions
}

/// The instruction set and the constants of all blocks.
struct BoundKernel<'a, S: Simd> {
    simd: S,
    one: V<S>,
    radius: V<S>,
    /// Whether the radius is that of each region.
    is_separate: bool,
    surely_inside: V<S>,
    unit: V<S>,
    weights: &'a [[f64; 3]],
    order: &'a [usize],
    positions: [usize; MAX_LANES],
    share_slots: usize,
}

impl<S: Simd> BoundKernel<'_, S> {
    /// The factor by which vectors outside the ball move to its boundary, given their squared norms.
    #[inline(always)]
    fn inwards(&self, squares: V<S>) -> V<S> {
        let simd = self.simd;
        let norm = simd.sqrt_f64s(squares);
        let outside = simd.less_than_f64s(self.radius, norm);
        simd.div_f64s(
            simd.select_f64s(outside, self.radius, self.one),
            simd.select_f64s(outside, norm, self.one),
        )
    }

    /// The shares of a block of faces, from its q.
    #[inline(always)]
    fn faces<T: Real, const M: usize>(&self, faces: &[u32], q: &[T], shares: &mut [[f64; 4]]) {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        let (wide, narrow) = (width::<T, S>(), width::<f64, S>());
        for (half, positions) in self.positions[..wide].chunks_exact(narrow).enumerate() {
            let mut y = [[zero; M]; 2];
            let mut squares = zero;
            for (y, q) in y.as_flattened_mut().iter_mut().zip(q.chunks_exact(wide)) {
                let q = &q[half * narrow..][..narrow];
                for (y, q) in cast_slice_mut::<_, f64>(slice::from_mut(y)).iter_mut().zip(q) {
                    *y = q.to_f64();
                }
                *y = simd.mul_f64s(*y, self.unit);
                squares = simd.mul_add_e_f64s(*y, *y, squares);
            }
            // y = Proj_{|.|<=lambda}( y )
            // In most blocks no face reaches the radius, and neither root nor quotient is needed.
            let scale = if !f64::any_less(simd, self.surely_inside, squares) {
                self.one
            } else if self.is_separate {
                let [first, second] = &mut y;
                for (a, b) in first.iter_mut().zip(second) {
                    let square = simd.mul_add_e_f64s(*a, *a, simd.mul_f64s(*b, *b));
                    let scale = self.inwards(square);
                    *a = simd.mul_f64s(*a, scale);
                    *b = simd.mul_f64s(*b, scale);
                }
                self.one
            } else {
                self.inwards(squares)
            };
            let weights = gather::<f64, S>(
                simd,
                #[inline(always)]
                |i| {
                    // The shares of padding are never read: any weights will do.
                    let j = faces[positions[i]];
                    let [c1, c2, c3] = self.weights[if j == NO_FACE { 0 } else { j as usize }];
                    [c1, c2, c3, 0.0]
                },
            );
            let [c1, c2, c3, _] = simd.deinterleave_shfl_f64s(weights);
            let [c1, c2, c3] = [c1, c2, c3].map(|c| simd.mul_f64s(c, scale));
            for g in 0..groups(M) {
                let mut kq = [[zero; 4]; 3];
                for p in 4 * g..M.min(4 * g + 4) {
                    let second = simd.mul_add_e_f64s(y[0][p], c1, simd.mul_f64s(y[1][p], c2));
                    let third = simd.mul_f64s(y[1][p], c3);
                    kq[0][p % 4] = simd.sub_f64s(zero, simd.add_f64s(second, third));
                    kq[1][p % 4] = second;
                    kq[2][p % 4] = third;
                }
                let shares = &mut shares[g * self.share_slots..][..3 * wide];
                for (shares, kq) in shares.chunks_exact_mut(wide).zip(kq) {
                    let kq = simd.interleave_shfl_f64s(kq);
                    for (share, &position) in cast_slice::<_, [f64; 4]>(&kq).iter().zip(positions) {
                        shares[position] = *share;
                    }
                }
            }
        }
    }

    /// min_p ( f_k + (K^T q)_k )_p of a block of vertices.
    #[inline(always)]
    fn vertices<T: Real, const M: usize>(
        &self,
        shares: &[[f64; 4]],
        offsets: &[u32],
        f: &[Row<M>],
        bounds: &mut [f64],
    ) {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        let (wide, narrow) = (width::<T, S>(), width::<f64, S>());
        for (half, bounds) in bounds.chunks_mut(narrow).enumerate() {
            let mut padded = [Row::ZERO; MAX_LANES];
            let f = match &f[half * narrow..] {
                f if f.len() < narrow => {
                    padded[..f.len()].copy_from_slice(f);
                    &padded
                }
                f => f,
            };
            let (mut smallest, mut defect) = (simd.splat_f64s(f64::INFINITY), zero);
            for g in 0..groups(M) {
                let shares = &shares[g * self.share_slots..][..self.share_slots];
                let mut kq = [zero; 4];
                for offsets in offsets.chunks_exact(wide) {
                    let offsets = &offsets[half * narrow..][..narrow];
                    let shares = gather::<f64, S>(
                        simd,
                        #[inline(always)]
                        |position| shares[offsets[position] as usize / GROUP],
                    );
                    for i in 0..4 {
                        kq[i] = simd.add_f64s(kq[i], shares[i]);
                    }
                }
                let f = gather::<f64, S>(
                    simd,
                    #[inline(always)]
                    |position| {
                        let Row(f) = f[..narrow][position];
                        [0, 1, 2, 3].map(|i| f[(4 * g + i).min(M - 1)])
                    },
                );
                let sums = [0, 1, 2, 3].map(|i| simd.add_f64s(f[i], kq[i]));
                let sums = simd.deinterleave_shfl_f64s(sums);
                for &sum in &sums[..4.min(M - 4 * g)] {
                    smallest = simd.min_f64s(sum, smallest);
                    defect = simd.add_f64s(defect, simd.sub_f64s(sum, sum));
                }
            }
            // If a sum is not finite the defect is NaN, and so becomes the minimum.
            let smallest = simd.add_f64s(smallest, defect);
            let smallest = cast_slice::<_, f64>(slice::from_ref(&smallest));
            for (bound, &lane) in bounds.iter_mut().zip(self.order) {
                *bound = smallest[lane];
            }
        }
    }
}
