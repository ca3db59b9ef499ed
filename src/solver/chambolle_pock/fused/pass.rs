//! Up to [`MAX_DEPTH`] iterations over one part, with one vertex or face per lane:
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )         u_bar = 2x - u,   u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K u_bar )      q <- q + rho (y - q),   K^T q is summed anew
//! ```
//!
//! |.| is the norm of all regions together, or of each of them separately with lambda / sqrt(2).
//!
//! Blocks of vertices and of faces take turns. A face is due as soon as its last vertex has moved, and stores its
//! shares of K^T q separately from those of other faces; a vertex sums them up as soon as all its faces are done. The
//! iterations follow each other as closely as the layout allows, so that u, f, q and the coefficients are read from
//! memory once.

use std::f64::consts::FRAC_1_SQRT_2;

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::lanes::{Real, gather, surely_inside, width};
use super::layout::{BlockLayout, GROUP};
use super::part::{Arrays, Part, groups, share_slots};
use crate::prox::{SORTED_UP_TO, merge_exchange};
use crate::relaxation::Relaxation;

/// Negligible numbers are set to zero before every so many iterations.
const FLUSH_EVERY: usize = 8;

/// The largest number of blocks of vertices that an iteration moves before it is the next one's turn.
const CHUNK_BLOCKS: usize = 32;

/// The largest number of iterations in one pass.
pub const MAX_DEPTH: usize = 8;

/// The set in which the vectors of a face live.
#[derive(Clone, Copy)]
pub struct Ball {
    pub radius: f64,
    /// Whether each region has a ball of its own.
    pub is_separate: bool,
}

impl Ball {
    /// The balls of a relaxation.
    ///
    /// # Panics
    /// If its set does not consist of balls.
    pub fn new(relaxation: Relaxation, lambda: f64) -> Self {
        match relaxation {
            Relaxation::Frobenius => Ball { radius: lambda, is_separate: false },
            Relaxation::Separate => Ball { radius: FRAC_1_SQRT_2 * lambda, is_separate: true },
            Relaxation::Envelope | Relaxation::Metric(_) => {
                unreachable!("`engine.rs` builds other solvers for it")
            }
        }
    }
}

pub struct Pass<'a, T, const M: usize> {
    pub part: &'a mut Part<T>,
    pub layout: &'a BlockLayout,
    pub ball: Ball,
    pub rho: f64,
    /// The number of iterations before this pass.
    pub before: usize,
    /// The number of iterations of this pass, at most the depth of the window.
    pub iterations: usize,
    /// Whether the last of them has rho = 1 and ends with a feasible pair.
    pub last: bool,
}

/// How far an iteration of the pass has come.
#[derive(Clone, Copy, Default)]
struct Front {
    /// The next block of vertices, and the end.
    block: usize,
    end: usize,
    /// The next block of faces.
    faces: usize,
    /// The next block of vertices whose K^T q is summed up.
    sums: usize,
    /// Whether negligible numbers are set to zero.
    flush: bool,
    /// Whether rho = 1.
    unrelaxed: bool,
}

impl<T: Real, const M: usize> WithSimd for Pass<'_, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // The part has room for the groups of M regions, which the gathers rely on.
        assert_eq!(self.part.m, M);
        let width = width::<T, S>();
        let layout = self.layout;
        let (arrays, window, _) = self.part.arrays();
        let Arrays { u_bar, shares, u, kq, f, tau, weights, q } = arrays;
        let (first_block, first_faces) = (window.held_vertices().start, window.held_faces.start);
        let u = cast_slice_mut::<T, T::Vector<S>>(u).as_chunks_mut::<M>().0;
        let kq = cast_slice_mut::<T, T::Vector<S>>(kq).as_chunks_mut::<M>().0;
        let f = cast_slice::<T, T::Vector<S>>(f).as_chunks::<M>().0;
        let tau = cast_slice::<T, T::Vector<S>>(tau);
        let weights = cast_slice::<T, [T::Vector<S>; 4]>(weights);
        let q = cast_slice_mut::<T, T::Vector<S>>(q).as_chunks_mut::<M>().0.as_chunks_mut::<2>().0;
        let mut change = T::splat(simd, 0.0);
        let mut kernel = PassKernel::<T, S> {
            simd,
            zero: T::splat(simd, 0.0),
            one: T::splat(simd, 1.0),
            radius: T::splat(simd, self.ball.radius),
            surely_inside: T::splat(simd, surely_inside::<T>(self.ball.radius)),
            rho: T::splat(simd, self.rho),
            negligible: [1.0, self.ball.radius].map(|scale| T::splat(simd, scale * T::NEGLIGIBLE)),
            flush: false,
            unrelaxed: false,
        };
        let mut fronts = [Front::default(); MAX_DEPTH];
        let fronts = &mut fronts[..self.iterations];
        for (front, reach) in fronts.iter_mut().rev().zip(&window.reach[1..]) {
            *front = Front {
                block: reach.start,
                end: reach.end,
                faces: layout.due_before(reach.start),
                sums: reach.start,
                ..Front::default()
            };
        }
        for (n, front) in (self.before..).zip(&mut *fronts) {
            front.flush = n % FLUSH_EVERY == 0;
        }
        let last = self.iterations - 1;
        fronts[last].unrelaxed = self.last;
        let u_bar_stride = GROUP * width * groups(M);
        let group_stride = GROUP * share_slots(layout);
        while fronts[last].block < fronts[last].end {
            for n in 0..self.iterations {
                let Front { mut block, end, mut faces, mut sums, flush, unrelaxed } = fronts[n];
                let may_move = if n == 0 { end } else { end.min(fronts[n - 1].sums) };
                let stop = may_move.min(block + CHUNK_BLOCKS);
                (kernel.flush, kernel.unrelaxed) = (flush, unrelaxed);
                let shares =
                    &mut shares[n * groups(M) * group_stride..][..groups(M) * group_stride];
                while block < stop {
                    let b = block - first_block;
                    let u_bar_block = &mut u_bar[b * u_bar_stride..][..u_bar_stride];
                    let (kq_block, u_block) = (&kq[b], &mut u[b]);
                    change =
                        kernel.vertices::<M>(u_bar_block, u_block, kq_block, &f[b], tau[b], change);
                    block += 1;
                    let due = layout.due_before(block);
                    for j in faces - first_faces..due - first_faces {
                        let corner_offsets = &window.corner_offsets[3 * width * j..][..3 * width];
                        let shares = &mut shares[j % layout.ring_length * 3 * GROUP * width..];
                        // Compiled separately: the branch inside would cost a twentieth of a step.
                        if self.ball.is_separate {
                            kernel.faces::<true, M>(
                                u_bar,
                                corner_offsets,
                                &weights[j],
                                &mut q[j],
                                shares,
                                group_stride,
                            );
                        } else {
                            kernel.faces::<false, M>(
                                u_bar,
                                corner_offsets,
                                &weights[j],
                                &mut q[j],
                                shares,
                                group_stride,
                            );
                        }
                    }
                    faces = due;
                    while sums < end && layout.is_done(sums, block) {
                        let offsets = window.share_offsets.block(sums - first_block);
                        kernel.sums::<M>(
                            shares,
                            group_stride,
                            offsets,
                            &mut kq[sums - first_block],
                        );
                        sums += 1;
                    }
                }
                fronts[n] = Front { block, end, faces, sums, flush, unrelaxed };
            }
        }
        self.part.change = T::largest(simd, change);
    }
}

/// The instruction set and the constants of all blocks.
struct PassKernel<T: Real, S: Simd> {
    simd: S,
    zero: T::Vector<S>,
    one: T::Vector<S>,
    radius: T::Vector<S>,
    surely_inside: T::Vector<S>,
    rho: T::Vector<S>,
    /// For u and for q: smaller absolute values are negligible.
    negligible: [T::Vector<S>; 2],
    flush: bool,
    /// Whether rho = 1.
    unrelaxed: bool,
}

impl<T: Real, S: Simd> PassKernel<T, S> {
    /// u + rho (x - u), or x itself for rho = 1.
    #[inline(always)]
    fn relax(&self, u: T::Vector<S>, x: T::Vector<S>) -> T::Vector<S> {
        let simd = self.simd;
        if self.unrelaxed { x } else { T::mul_add(simd, T::sub(simd, x, u), self.rho, u) }
    }

    /// The factor by which vectors outside the ball move to its boundary, given their squared norms.
    #[inline(always)]
    fn inwards(&self, squares: T::Vector<S>) -> T::Vector<S> {
        let simd = self.simd;
        let norm = T::sqrt(simd, squares);
        T::div(
            simd,
            T::if_less(simd, self.radius, norm, self.radius, self.one),
            T::if_less(simd, self.radius, norm, norm, self.one),
        )
    }

    /// Sets negligible numbers to zero. Numbers that shrink by a fixed ratio become subnormal, and an instruction then
    /// takes a hundred times as long.
    #[inline(always)]
    fn flush(&self, numbers: &mut [T::Vector<S>], negligible: T::Vector<S>) {
        let simd = self.simd;
        for x in numbers {
            let size = T::max(simd, *x, T::sub(simd, self.zero, *x));
            *x = T::if_less(simd, size, negligible, self.zero, *x);
        }
    }

    /// The primal step on a block of vertices. Returns `change`, or max |x - u| if rho = 1 and that is larger.
    #[inline(always)]
    fn vertices<const M: usize>(
        &self,
        u_bar_block: &mut [T],
        u: &mut [T::Vector<S>; M],
        kq: &[T::Vector<S>; M],
        f: &[T::Vector<S>; M],
        tau: T::Vector<S>,
        mut change: T::Vector<S>,
    ) -> T::Vector<S> {
        let simd = self.simd;
        if self.flush {
            self.flush(u, self.negligible[0]);
        }
        let minus_tau = T::neg(simd, tau);
        let mut v = [self.zero; M];
        for p in 0..M {
            v[p] = T::mul_add(simd, T::add(simd, f[p], kq[p]), minus_tau, u[p]);
        }
        let x = self.project_simplex(v);
        for g in 0..groups(M) {
            let mut u_bar = [self.zero; 4];
            for p in 4 * g..M.min(4 * g + 4) {
                if self.unrelaxed {
                    let (forth, back) = (T::sub(simd, x[p], u[p]), T::sub(simd, u[p], x[p]));
                    change = T::max(simd, T::max(simd, forth, back), change);
                }
                u_bar[p % 4] = T::sub(simd, T::add(simd, x[p], x[p]), u[p]);
                u[p] = self.relax(u[p], x[p]);
            }
            let u_bar = T::interleave(simd, u_bar);
            let u_bar_groups = u_bar_block.as_chunks_mut::<GROUP>().0;
            for (position, &u_bar) in cast_slice::<_, [T; GROUP]>(&u_bar).iter().enumerate() {
                u_bar_groups[position * groups(M) + g] = u_bar;
            }
        }
        change
    }

    /// The dual step on a block of faces, with a ball for all regions or for each. Stores their shares of K^T q.
    #[inline(always)]
    fn faces<const SEPARATE: bool, const M: usize>(
        &self,
        u_bar: &[T],
        corner_offsets: &[u32],
        &[c1, c2, c3, sigma]: &[T::Vector<S>; 4],
        q: &mut [[T::Vector<S>; M]; 2],
        shares: &mut [T],
        group_stride: usize,
    ) {
        let simd = self.simd;
        if self.flush {
            self.flush(q.as_flattened_mut(), self.negligible[1]);
        }
        let (corner1, rest) = corner_offsets.split_at(width::<T, S>());
        let (corner2, corner3) = rest.split_at(width::<T, S>());
        // y = q + sigma K u_bar,   (K u)_j = ( c1 ua, c2 ua + c3 ub )
        let [s1, s2, s3] = [c1, c2, c3].map(|c| T::mul(simd, c, sigma));
        let mut y = [[self.zero; M]; 2];
        let mut squares = [self.zero; 2];
        for g in 0..groups(M) {
            // A loop over the corners would keep the gathered vectors in memory.
            let u1 = self.gather_u_bar::<M>(u_bar, corner1, g);
            let ua = self.differences(self.gather_u_bar::<M>(u_bar, corner2, g), u1);
            let ub = self.differences(self.gather_u_bar::<M>(u_bar, corner3, g), u1);
            for p in 4 * g..M.min(4 * g + 4) {
                let (ua, ub) = (ua[p % 4], ub[p % 4]);
                y[0][p] = T::mul_add(simd, ua, s1, q[0][p]);
                y[1][p] = T::mul_add(simd, ua, s2, T::mul_add(simd, ub, s3, q[1][p]));
                for i in 0..2 {
                    squares[i] = T::mul_add(simd, y[i][p], y[i][p], squares[i]);
                }
            }
        }
        // y = Proj_{|.|<=lambda}( y ),   q <- q + rho (y - q)
        let squares = T::add(simd, squares[0], squares[1]);
        // In most blocks no face reaches the radius, and neither root nor quotient is needed.
        let scale = if !T::any_less(simd, self.surely_inside, squares) {
            self.one
        } else if SEPARATE {
            let [first, second] = &mut y;
            for (a, b) in first.iter_mut().zip(second) {
                let square = T::mul_add(simd, *a, *a, T::mul(simd, *b, *b));
                if T::any_less(simd, self.surely_inside, square) {
                    let scale = self.inwards(square);
                    *a = T::mul(simd, *a, scale);
                    *b = T::mul(simd, *b, scale);
                }
            }
            self.one
        } else {
            self.inwards(squares)
        };
        // K^T q is -(c1 q1 + (c2 + c3) q2), c1 q1 + c2 q2, c3 q2 at the three corners.
        for g in 0..groups(M) {
            let (mut second, mut third) = ([self.zero; 4], [self.zero; 4]);
            for p in 4 * g..M.min(4 * g + 4) {
                for i in 0..2 {
                    q[i][p] = if self.unrelaxed {
                        T::mul(simd, y[i][p], scale)
                    } else {
                        let moves = T::mul_add(simd, y[i][p], scale, T::neg(simd, q[i][p]));
                        T::mul_add(simd, moves, self.rho, q[i][p])
                    };
                }
                second[p % 4] = T::mul_add(simd, q[0][p], c1, T::mul(simd, q[1][p], c2));
                third[p % 4] = T::mul(simd, q[1][p], c3);
            }
            let (second, third) = (T::interleave(simd, second), T::interleave(simd, third));
            let mut first = [self.zero; 4];
            for i in 0..4 {
                first[i] = T::sub(simd, self.zero, T::add(simd, second[i], third[i]));
            }
            let shares = &mut shares[g * group_stride..][..3 * GROUP * width::<T, S>()];
            for (shares, kq) in
                shares.chunks_exact_mut(GROUP * width::<T, S>()).zip([first, second, third])
            {
                shares.copy_from_slice(cast_slice(&kq));
            }
        }
    }

    /// K^T q of a block of vertices.
    #[inline(always)]
    fn sums<const M: usize>(
        &self,
        shares: &[T],
        group_stride: usize,
        offsets: &[u32],
        kq: &mut [T::Vector<S>; M],
    ) {
        for g in 0..groups(M) {
            let mut sums = [self.zero; 4];
            for offsets in offsets.chunks_exact(width::<T, S>()) {
                let shares = gather::<T, S>(
                    self.simd,
                    #[inline(always)]
                    |position| {
                        // SAFETY: `Part::new` checked that these offsets lie within the `share_slots` of a group, and
                        // `with_simd` that there are as many groups as are read here.
                        unsafe { load_group(shares, g * group_stride + offsets[position] as usize) }
                    },
                );
                for i in 0..4 {
                    sums[i] = T::add(self.simd, sums[i], shares[i]);
                }
            }
            let sums = T::deinterleave(self.simd, sums);
            for p in 4 * g..M.min(4 * g + 4) {
                kq[p] = sums[p % 4];
            }
        }
    }

    /// The g-th group of u_bar at one corner of each face, one group after another.
    #[inline(always)]
    fn gather_u_bar<const M: usize>(
        &self,
        u_bar: &[T],
        corner: &[u32],
        g: usize,
    ) -> [T::Vector<S>; 4] {
        gather::<T, S>(
            self.simd,
            #[inline(always)]
            |position| {
                // SAFETY: `Part::new` checked that every corner has a slot in `u_bar`, and `with_simd` that a slot has
                // as many groups as are read here.
                unsafe { load_group(u_bar, corner[position] as usize * groups(M) + GROUP * g) }
            },
        )
    }

    /// The differences a - b of groups, as a vector for each region with a lane for each group.
    #[inline(always)]
    fn differences(&self, a: [T::Vector<S>; 4], b: [T::Vector<S>; 4]) -> [T::Vector<S>; 4] {
        let mut groups = [self.zero; 4];
        for i in 0..4 {
            groups[i] = T::sub(self.simd, a[i], b[i]);
        }
        T::deinterleave(self.simd, groups)
    }

    /// As `prox::project_simplex`, in every lane.
    #[inline(always)]
    fn project_simplex<const M: usize>(&self, v: [T::Vector<S>; M]) -> [T::Vector<S>; M] {
        let simd = self.simd;
        let (largest, theta) = if M <= SORTED_UP_TO {
            self.threshold_by_sorting(v)
        } else {
            self.threshold_by_shrinking(v)
        };
        let mut u = [self.zero; M];
        for p in 0..M {
            let x = T::sub(simd, T::sub(simd, v[p], largest), theta);
            u[p] = T::if_less(simd, x, self.zero, self.zero, x);
        }
        u
    }

    /// The largest entry, and theta = max_k (S_k - 1) / k for the entries minus the largest one.
    #[inline(always)]
    fn threshold_by_sorting<const M: usize>(
        &self,
        v: [T::Vector<S>; M],
    ) -> (T::Vector<S>, T::Vector<S>) {
        let simd = self.simd;
        let mut s = v;
        merge_exchange(
            M,
            #[inline(always)]
            |i, k| (s[i], s[k]) = (T::max(simd, s[i], s[k]), T::min(simd, s[i], s[k])),
        );
        let minus_one = T::splat(simd, -1.0);
        let (mut sum, mut theta) = (minus_one, minus_one);
        for k in 1..M {
            sum = T::add(simd, sum, T::sub(simd, s[k], s[0]));
            let candidate = T::mul(simd, sum, T::splat(simd, 1.0 / (k + 1) as f64));
            theta = T::max(simd, candidate, theta);
        }
        (s[0], theta)
    }

    /// The same by Michelot's iteration, on all lanes until it is stationary in each: theta becomes the sum of the
    /// entries above it, minus one, over their number.
    #[inline(always)]
    fn threshold_by_shrinking<const M: usize>(
        &self,
        v: [T::Vector<S>; M],
    ) -> (T::Vector<S>, T::Vector<S>) {
        let simd = self.simd;
        let mut largest = v[0];
        for &entry in &v[1..] {
            largest = T::max(simd, entry, largest);
        }
        let minus_one = T::splat(simd, -1.0);
        let mut entries = v;
        for entry in &mut entries {
            *entry = T::sub(simd, *entry, largest);
        }
        // No entry at or below -1 stays positive. This also leaves out padding regions, so that no sum overflows.
        let mut theta = minus_one;
        let mut count = T::splat(simd, (M + 1) as f64);
        loop {
            let (mut sum, mut above) = (minus_one, self.zero);
            for &entry in &entries {
                sum = T::add(simd, sum, T::if_less(simd, theta, entry, entry, self.zero));
                above = T::add(simd, above, T::if_less(simd, theta, entry, self.one, self.zero));
            }
            // Because of rounding the set might grow again, and the loop never end.
            let shrunk = T::if_less(simd, above, count, self.one, self.zero);
            if T::largest(simd, shrunk) <= 0.0 {
                return (largest, theta);
            }
            theta = T::if_less(simd, above, count, T::div(simd, sum, above), theta);
            count = T::min(simd, above, count);
        }
    }
}

/// The group at an offset.
///
/// # Safety
/// The group lies within `numbers`.
#[inline(always)]
unsafe fn load_group<T: Copy>(numbers: &[T], offset: usize) -> [T; GROUP] {
    // SAFETY: the caller ensures that the group lies within `numbers`; an array is aligned as its entries are.
    unsafe { *numbers.as_ptr().add(offset).cast() }
}
