//! One iteration over one part: the two lines of the method, a lane a vertex and a lane a face.
//!
//! ```text
//! x = Proj_simplex( u - tau (f + K^T q) )         u_bar = 2x - u,   u <- u + rho (x - u)
//! y = Proj_{|.|<=lambda}( q + sigma K u_bar )      q <- q + rho (y - q),   K^T q is summed up anew
//! ```
//!
//! Blocks of vertices and of faces take turns: a face is due as soon as its last vertex has moved, and K^T q of
//! a vertex is summed after it was used. So one pass reads u, f, q and the coefficients once, and what faces
//! share stays in the cache.

use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};

use super::lanes::{Real, width};
use super::layout::Layout;
use super::part::{Part, RowPair, groups};

/// Up to so many regions sorting networks are faster than Michelot's shrinking set.
const SORTED_UP_TO: usize = 16;

pub struct Pass<'a, T, const M: usize> {
    pub part: &'a mut Part<T>,
    pub lambda: f64,
    pub rho: f64,
    pub land: bool,
}

impl<T: Real, const M: usize> WithSimd for Pass<'_, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // So many rows the part has room for, which the gathers rely on.
        assert_eq!(self.part.m, M);
        let width = width::<T, S>();
        let Part { layout: Layout { corners, faces_due, .. }, rows, u, f, tau, weights, q, .. } =
            self.part;
        let u = cast_slice_mut::<T, T::Vector<S>>(u).as_chunks_mut::<M>().0;
        let f = cast_slice::<T, T::Vector<S>>(f).as_chunks::<M>().0;
        let tau = cast_slice::<T, T::Vector<S>>(tau);
        let weights = cast_slice::<T, [T::Vector<S>; 4]>(weights);
        let q = cast_slice_mut::<T, T::Vector<S>>(q).as_chunks_mut::<M>().0.as_chunks_mut::<2>().0;
        let mut change = T::splat(simd, 0.0);
        let step = Step::<T, S> {
            simd,
            zero: T::splat(simd, 0.0),
            one: T::splat(simd, 1.0),
            lambda: T::splat(simd, self.lambda),
            rho: T::splat(simd, self.rho),
            land: self.land,
        };
        let vertex_rows = width * groups(M);
        let mut done = 0;
        for (block, &due) in faces_due.iter().enumerate() {
            let own = &mut rows[block * vertex_rows..][..vertex_rows];
            change = step.vertices::<M>(own, &mut u[block], &f[block], tau[block], change);
            let due = due as usize;
            let faces = corners[3 * width * done..3 * width * due]
                .chunks_exact(3 * width)
                .zip(&weights[done..due])
                .zip(&mut q[done..due]);
            for ((corners, weights), q) in faces {
                step.faces::<M>(rows, corners, weights, q);
            }
            done = due;
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
    rho: T::Vector<S>,
    land: bool,
}

impl<T: Real, S: Simd> Step<T, S> {
    /// u <- u + rho (x - u), or x itself if the step lands.
    #[inline(always)]
    fn relax(&self, u: T::Vector<S>, x: T::Vector<S>) -> T::Vector<S> {
        let simd = self.simd;
        if self.land { x } else { T::add(simd, u, T::mul(simd, T::sub(simd, x, u), self.rho)) }
    }

    /// Returns max |x - u|, or `change` if that is more.
    #[inline(always)]
    fn vertices<const M: usize>(
        &self,
        rows: &mut [RowPair<T>],
        u: &mut [T::Vector<S>; M],
        f: &[T::Vector<S>; M],
        tau: T::Vector<S>,
        mut change: T::Vector<S>,
    ) -> T::Vector<S> {
        let simd = self.simd;
        let mut v = [self.zero; M];
        for g in 0..groups(M) {
            let kq = self.gather(
                #[inline(always)]
                |o| rows[o * groups(M) + g].kq,
            );
            for p in 4 * g..M.min(4 * g + 4) {
                v[p] = T::sub(simd, u[p], T::mul(simd, T::add(simd, f[p], kq[p % 4]), tau));
            }
        }
        let x = self.project_simplex(v);
        for g in 0..groups(M) {
            let mut u_bar = [self.zero; 4];
            for p in 4 * g..M.min(4 * g + 4) {
                if self.land {
                    let (forth, back) = (T::sub(simd, x[p], u[p]), T::sub(simd, u[p], x[p]));
                    change = T::max(simd, T::max(simd, forth, back), change);
                }
                u_bar[p % 4] = T::sub(simd, T::add(simd, x[p], x[p]), u[p]);
                u[p] = self.relax(u[p], x[p]);
            }
            let u_bar = T::interleave(simd, u_bar);
            for (o, &u_bar) in cast_slice::<_, [T; 4]>(&u_bar).iter().enumerate() {
                rows[o * groups(M) + g] = RowPair { u_bar, kq: [T::ZERO; 4] };
            }
        }
        change
    }

    #[inline(always)]
    fn faces<const M: usize>(
        &self,
        rows: &mut [RowPair<T>],
        corners: &[u32],
        &[c1, c2, c3, sigma]: &[T::Vector<S>; 4],
        q: &mut [[T::Vector<S>; M]; 2],
    ) {
        let simd = self.simd;
        let (corner1, rest) = corners.split_at(width::<T, S>());
        let (corner2, corner3) = rest.split_at(width::<T, S>());
        let corner = [corner1, corner2, corner3];
        // y = q + sigma K u_bar,   (K u)_j = ( c1 ua, c2 ua + c3 ub )
        let mut y = [[self.zero; M]; 2];
        let mut squares = [self.zero; 2];
        for g in 0..groups(M) {
            // Not in a loop over the corners, which would keep in memory what it gathers.
            let u = [
                self.gather_u_bar::<M>(rows, corner1, g),
                self.gather_u_bar::<M>(rows, corner2, g),
                self.gather_u_bar::<M>(rows, corner3, g),
            ];
            for p in 4 * g..M.min(4 * g + 4) {
                let ua = T::sub(simd, u[1][p % 4], u[0][p % 4]);
                let ub = T::sub(simd, u[2][p % 4], u[0][p % 4]);
                let ku = [
                    T::mul(simd, ua, c1),
                    T::add(simd, T::mul(simd, ua, c2), T::mul(simd, ub, c3)),
                ];
                for i in 0..2 {
                    y[i][p] = T::add(simd, q[i][p], T::mul(simd, ku[i], sigma));
                    squares[i] = T::add(simd, squares[i], T::mul(simd, y[i][p], y[i][p]));
                }
            }
        }
        // y = Proj_{|.|<=lambda}( y ),   q <- q + rho (y - q)
        let norm = T::sqrt(simd, T::add(simd, squares[0], squares[1]));
        let scale = T::div(
            simd,
            T::if_less(simd, self.lambda, norm, self.lambda, self.one),
            T::if_less(simd, self.lambda, norm, norm, self.one),
        );
        // (K^T q): -(c1 q1 + (c2 + c3) q2), c1 q1 + c2 q2, c3 q2 at the three corners.
        for g in 0..groups(M) {
            let mut kq = [[self.zero; 4]; 3];
            for p in 4 * g..M.min(4 * g + 4) {
                for i in 0..2 {
                    q[i][p] = self.relax(q[i][p], T::mul(simd, y[i][p], scale));
                }
                let second = T::add(simd, T::mul(simd, q[0][p], c1), T::mul(simd, q[1][p], c2));
                let third = T::mul(simd, q[1][p], c3);
                kq[0][p % 4] = T::sub(simd, self.zero, T::add(simd, second, third));
                kq[1][p % 4] = second;
                kq[2][p % 4] = third;
            }
            let kq = [
                T::interleave(simd, kq[0]),
                T::interleave(simd, kq[1]),
                T::interleave(simd, kq[2]),
            ];
            let kq: [&[[T; 4]]; 3] = [cast_slice(&kq[0]), cast_slice(&kq[1]), cast_slice(&kq[2])];
            // Face by face in their order, wherever a block begins: a vertex sums in the same order in any part.
            for o in 0..width::<T, S>() {
                for i in 0..3 {
                    let place = corner[i][o] as usize * groups(M) + g;
                    // SAFETY: as in `gather_u_bar`.
                    let row = unsafe { rows.get_unchecked_mut(place) };
                    row.kq = T::add_rows(row.kq, kq[i][o]);
                }
            }
        }
    }

    /// The g-th four entries of u_bar at a corner of each face.
    #[inline(always)]
    fn gather_u_bar<const M: usize>(
        &self,
        rows: &[RowPair<T>],
        corner: &[u32],
        g: usize,
    ) -> [T::Vector<S>; 4] {
        self.gather(
            #[inline(always)]
            |o| {
                let place = corner[o] as usize * groups(M) + g;
                // SAFETY: `Part::new` checked that every corner has its place in `rows`, and `with_simd` that a
                // place has as many rows as are looked at here.
                unsafe { rows.get_unchecked(place) }.u_bar
            },
        )
    }

    /// Four entries of a row for each lane.
    #[inline(always)]
    fn gather(&self, row: impl Fn(usize) -> [T; 4]) -> [T::Vector<S>; 4] {
        let mut rows = [self.zero; 4];
        for (o, place) in cast_slice_mut::<_, [T; 4]>(&mut rows).iter_mut().enumerate() {
            *place = row(o);
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
    ///
    /// K. E. Batcher's merge exchange for any number of entries: D. Knuth, *The Art of Computer Programming* 3,
    /// algorithm 5.2.2 M.
    #[inline(always)]
    fn threshold_by_sorting<const M: usize>(
        &self,
        v: [T::Vector<S>; M],
    ) -> (T::Vector<S>, T::Vector<S>) {
        let simd = self.simd;
        let mut s = v;
        let top = M.next_power_of_two() / 2;
        let mut p = top;
        while p > 0 {
            let (mut q, mut r, mut d) = (top, 0, p);
            loop {
                for i in 0..M - d {
                    if i & p == r {
                        (s[i], s[i + d]) =
                            (T::max(simd, s[i], s[i + d]), T::min(simd, s[i], s[i + d]));
                    }
                }
                if q == p {
                    break;
                }
                (d, q, r) = (q - p, q / 2, p);
            }
            p /= 2;
        }
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
        // No entry below -1 stays positive; cut off there, closed regions overflow no sum.
        let mut entries = v;
        for entry in &mut entries {
            *entry = T::max(simd, T::sub(simd, *entry, largest), minus_one);
        }
        let mut theta = T::splat(simd, -2.0);
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
