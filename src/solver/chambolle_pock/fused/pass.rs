//! Up to [`DEEPEST`] iterations over one part: the two lines of the method, a lane a vertex and a lane a face.
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )         u_bar = 2x - u,   u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K u_bar )      q <- q + rho (y - q),   K^T q is summed up anew
//! ```
//!
//! Blocks of vertices and of faces take turns: a face is due as soon as its last vertex has moved, and leaves its
//! shares of K^T q in rows of its own; a vertex sums them up as soon as all its faces have. The next iteration follows
//! as closely as the layout allows, and the one after it, so that all read u, f, q and the coefficients from memory
//! once.

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::lanes::{Real, gather, surely_inside, width};
use super::layout::{Layout, ROW};
use super::part::{Numbers, Part, groups, share_rows};
use crate::prox::{SORTED_UP_TO, merge_exchange};

/// The negligible is set to zero before one of so many iterations.
const TIDY_EVERY: usize = 8;

/// So many blocks of vertices an iteration moves before the next has its turn.
const CHUNK: usize = 32;

/// So many iterations at the most are made in one pass.
pub const DEEPEST: usize = 8;

pub struct Pass<'a, T, const M: usize> {
    pub part: &'a mut Part<T>,
    pub layout: &'a Layout,
    pub lambda: f64,
    pub rho: f64,
    /// How many iterations were made before, and are now, up to the depth of the window.
    pub before: usize,
    pub iterations: usize,
    /// Whether the last of them has rho = 1 and ends with a feasible pair.
    pub last: bool,
}

/// How far an iteration has come.
#[derive(Clone, Copy, Default)]
struct Front {
    /// The next block of vertices, and the end.
    block: usize,
    end: usize,
    /// The next block of faces.
    faces: usize,
    /// The next block of vertices whose K^T q is summed up.
    sums: usize,
    tidy: bool,
    /// Whether rho = 1.
    plain: bool,
}

impl<T: Real, const M: usize> WithSimd for Pass<'_, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // So many rows the part has room for, which the gathers rely on.
        assert_eq!(self.part.m, M);
        let width = width::<T, S>();
        let layout = self.layout;
        let (numbers, window, _) = self.part.numbers();
        let Numbers { u_bar, shares, u, kq, f, tau, weights, q } = numbers;
        let (first_block, first_faces) = (window.vertices().start, window.held_faces.start);
        let u = cast_slice_mut::<T, T::Vector<S>>(u).as_chunks_mut::<M>().0;
        let kq = cast_slice_mut::<T, T::Vector<S>>(kq).as_chunks_mut::<M>().0;
        let f = cast_slice::<T, T::Vector<S>>(f).as_chunks::<M>().0;
        let tau = cast_slice::<T, T::Vector<S>>(tau);
        let weights = cast_slice::<T, [T::Vector<S>; 4]>(weights);
        let q = cast_slice_mut::<T, T::Vector<S>>(q).as_chunks_mut::<M>().0.as_chunks_mut::<2>().0;
        let mut change = T::splat(simd, 0.0);
        let mut step = Step::<T, S> {
            simd,
            zero: T::splat(simd, 0.0),
            one: T::splat(simd, 1.0),
            lambda: T::splat(simd, self.lambda),
            surely_inside: T::splat(simd, surely_inside::<T>(self.lambda)),
            rho: T::splat(simd, self.rho),
            negligible: [1.0, self.lambda].map(|scale| T::splat(simd, scale * T::NEGLIGIBLE)),
            tidy: false,
            plain: false,
        };
        let mut fronts = [Front::default(); DEEPEST];
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
            front.tidy = n % TIDY_EVERY == 0;
        }
        let last = self.iterations - 1;
        fronts[last].plain = self.last;
        let vertex_rows = ROW * width * groups(M);
        let group = ROW * share_rows(layout);
        while fronts[last].block < fronts[last].end {
            for n in 0..self.iterations {
                let Front { mut block, end, mut faces, mut sums, tidy, plain } = fronts[n];
                let may_move = if n == 0 { end } else { end.min(fronts[n - 1].sums) };
                let stop = may_move.min(block + CHUNK);
                (step.tidy, step.plain) = (tidy, plain);
                let shares = &mut shares[n * groups(M) * group..][..groups(M) * group];
                while block < stop {
                    let b = block - first_block;
                    let u_bar_rows = &mut u_bar[b * vertex_rows..][..vertex_rows];
                    let (kq_row, u_row) = (&kq[b], &mut u[b]);
                    change = step.vertices::<M>(u_bar_rows, u_row, kq_row, &f[b], tau[b], change);
                    block += 1;
                    let due = layout.due_before(block);
                    for j in faces - first_faces..due - first_faces {
                        let places = &window.places[3 * width * j..][..3 * width];
                        let shares = &mut shares[j % layout.ring * 3 * ROW * width..];
                        step.faces::<M>(u_bar, places, &weights[j], &mut q[j], shares, group);
                    }
                    faces = due;
                    while sums < end && layout.is_done(sums, block) {
                        let rows = window.rows_at.block(sums - first_block);
                        step.sums::<M>(shares, group, rows, &mut kq[sums - first_block]);
                        sums += 1;
                    }
                }
                fronts[n] = Front { block, end, faces, sums, tidy, plain };
            }
        }
        self.part.change = T::largest(simd, change);
    }
}

/// The instruction set and what all lanes share.
struct Step<T: Real, S: Simd> {
    simd: S,
    zero: T::Vector<S>,
    one: T::Vector<S>,
    lambda: T::Vector<S>,
    surely_inside: T::Vector<S>,
    rho: T::Vector<S>,
    /// Of u and q.
    negligible: [T::Vector<S>; 2],
    tidy: bool,
    /// Whether rho = 1.
    plain: bool,
}

impl<T: Real, S: Simd> Step<T, S> {
    /// u <- u + rho (x - u), or x itself for rho = 1.
    #[inline(always)]
    fn relax(&self, u: T::Vector<S>, x: T::Vector<S>) -> T::Vector<S> {
        let simd = self.simd;
        if self.plain { x } else { T::mul_add(simd, T::sub(simd, x, u), self.rho, u) }
    }

    /// Steps of a fixed ratio lead to numbers too small to be normal, which cost a hundred times as much.
    #[inline(always)]
    fn tidy(&self, numbers: &mut [T::Vector<S>], negligible: T::Vector<S>) {
        let simd = self.simd;
        for x in numbers {
            let size = T::max(simd, *x, T::sub(simd, self.zero, *x));
            *x = T::if_less(simd, size, negligible, self.zero, *x);
        }
    }

    /// Returns max |x - u|, or `change` if that is more.
    #[inline(always)]
    fn vertices<const M: usize>(
        &self,
        u_bar_rows: &mut [T],
        u: &mut [T::Vector<S>; M],
        kq: &[T::Vector<S>; M],
        f: &[T::Vector<S>; M],
        tau: T::Vector<S>,
        mut change: T::Vector<S>,
    ) -> T::Vector<S> {
        let simd = self.simd;
        if self.tidy {
            self.tidy(u, self.negligible[0]);
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
                if self.plain {
                    let (forth, back) = (T::sub(simd, x[p], u[p]), T::sub(simd, u[p], x[p]));
                    change = T::max(simd, T::max(simd, forth, back), change);
                }
                u_bar[p % 4] = T::sub(simd, T::add(simd, x[p], x[p]), u[p]);
                u[p] = self.relax(u[p], x[p]);
            }
            let u_bar = T::interleave(simd, u_bar);
            let u_bar_rows = u_bar_rows.as_chunks_mut::<ROW>().0;
            for (o, &u_bar) in cast_slice::<_, [T; ROW]>(&u_bar).iter().enumerate() {
                u_bar_rows[o * groups(M) + g] = u_bar;
            }
        }
        change
    }

    #[inline(always)]
    fn faces<const M: usize>(
        &self,
        u_bar: &[T],
        corners: &[u32],
        &[c1, c2, c3, sigma]: &[T::Vector<S>; 4],
        q: &mut [[T::Vector<S>; M]; 2],
        shares: &mut [T],
        group: usize,
    ) {
        let simd = self.simd;
        if self.tidy {
            self.tidy(q.as_flattened_mut(), self.negligible[1]);
        }
        let (corner1, rest) = corners.split_at(width::<T, S>());
        let (corner2, corner3) = rest.split_at(width::<T, S>());
        // y = q + sigma K u_bar,   (K u)_j = ( c1 ua, c2 ua + c3 ub )
        let [s1, s2, s3] = [c1, c2, c3].map(|c| T::mul(simd, c, sigma));
        let mut y = [[self.zero; M]; 2];
        let mut squares = [self.zero; 2];
        for g in 0..groups(M) {
            // Not in a loop over the corners, which would keep in memory what it gathers.
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
        // Most blocks have no face at lambda: then they need no root and no quotient.
        let scale = if T::any_less(simd, self.surely_inside, squares) {
            let norm = T::sqrt(simd, squares);
            T::div(
                simd,
                T::if_less(simd, self.lambda, norm, self.lambda, self.one),
                T::if_less(simd, self.lambda, norm, norm, self.one),
            )
        } else {
            self.one
        };
        // (K^T q): -(c1 q1 + (c2 + c3) q2), c1 q1 + c2 q2, c3 q2 at the three corners.
        for g in 0..groups(M) {
            let (mut second, mut third) = ([self.zero; 4], [self.zero; 4]);
            for p in 4 * g..M.min(4 * g + 4) {
                for i in 0..2 {
                    q[i][p] = if self.plain {
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
            let shares = &mut shares[g * group..][..3 * ROW * width::<T, S>()];
            for (shares, kq) in
                shares.chunks_exact_mut(ROW * width::<T, S>()).zip([first, second, third])
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
        group: usize,
        rows: &[u32],
        kq: &mut [T::Vector<S>; M],
    ) {
        for g in 0..groups(M) {
            let mut sums = [self.zero; 4];
            for rows in rows.chunks_exact(width::<T, S>()) {
                let shares = gather::<T, S>(
                    self.simd,
                    #[inline(always)]
                    |o| {
                        // SAFETY: `Part::new` checked that each of these rows is among the `share_rows` of a group,
                        // and `with_simd` that there are as many groups as are looked at here.
                        unsafe { row(shares, g * group + rows[o] as usize) }
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

    /// The g-th four entries of u_bar at a corner of each face, row by row.
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
            |o| {
                // SAFETY: `Part::new` checked that every corner has its place in `u_bar`, and `with_simd` that a
                // place has as many rows as are looked at here.
                unsafe { row(u_bar, corner[o] as usize * groups(M) + ROW * g) }
            },
        )
    }

    /// Of rows: a vector for each entry, with a lane for each row.
    #[inline(always)]
    fn differences(&self, a: [T::Vector<S>; 4], b: [T::Vector<S>; 4]) -> [T::Vector<S>; 4] {
        let mut rows = [self.zero; 4];
        for i in 0..4 {
            rows[i] = T::sub(self.simd, a[i], b[i]);
        }
        T::deinterleave(self.simd, rows)
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

    /// The largest entry, and theta = max_k (S_k - 1) / k over the entries less that one.
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

    /// The same by Michelot's iteration on all lanes until it stands still in each: the mean of the entries
    /// still above theta.
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
        // No entry at -1 or below stays positive; without closed regions no sum overflows.
        let mut theta = minus_one;
        let mut count = T::splat(simd, (M + 1) as f64);
        loop {
            let (mut sum, mut above) = (minus_one, self.zero);
            for &entry in &entries {
                sum = T::add(simd, sum, T::if_less(simd, theta, entry, entry, self.zero));
                above = T::add(simd, above, T::if_less(simd, theta, entry, self.one, self.zero));
            }
            // Rounding must not make the set grow again, for ever.
            let shrunk = T::if_less(simd, above, count, self.one, self.zero);
            if T::largest(simd, shrunk) <= 0.0 {
                return (largest, theta);
            }
            theta = T::if_less(simd, above, count, T::div(simd, sum, above), theta);
            count = T::min(simd, above, count);
        }
    }
}

/// The row that begins there.
///
/// # Safety
/// It lies within the numbers.
#[inline(always)]
unsafe fn row<T: Copy>(numbers: &[T], begin: usize) -> [T; ROW] {
    // SAFETY: says the caller; an array is aligned as its entries are.
    unsafe { *numbers.as_ptr().add(begin).cast() }
}
