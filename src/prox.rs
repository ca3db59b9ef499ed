//! The two projections of the method, onto the simplex and onto the ball, one row at a time.
//!
//! Simplex: Proj(v) = max(v - theta, 0) with theta = max_k (S_k - 1) / k, S_k the sum of the k largest
//! entries. C. Michelot, *A finite algorithm for finding the projection of a point onto the canonical
//! simplex of R^n*, J. Optim. Theory Appl. 50, 1986; the form with sorted sums is Held, Wolfe and
//! Crowder's (1974), the sorting K. E. Batcher's. NaN in gives NaN out.

use crate::field::{Row, Tangent};

/// Up to this number of regions, branch-free sorting of all entries is faster than Michelot's shrinking set.
pub const SORTED_UP_TO: usize = 16;

/// Number of partial sums: with a single one, each addition would wait for the previous one.
const PARTS: usize = 4;

/// The nearest point of { u : u_p >= 0, sum_p u_p = 1 }.
#[inline(always)]
pub fn project_simplex<const M: usize>(v: Row<M>) -> Row<M> {
    // The projection does not change when a constant is added to v. After subtracting the largest entry, the entries
    // that stay positive lie in [-1, 0], so the row sums to 1 however large v is.
    let (largest, theta) =
        if M <= SORTED_UP_TO { threshold_by_sorting(v) } else { threshold_by_shrinking(v) };
    Row::from_fn(|p| {
        let u = (v.0[p] - largest) - theta;
        if u < 0.0 { 0.0 } else { u }
    })
}

/// The largest entry, and theta = max_k (S_k - 1) / k of the entries minus the largest, sorted in descending order.
#[inline(always)]
fn threshold_by_sorting<const M: usize>(v: Row<M>) -> (f64, f64) {
    let mut s = v.0;
    merge_exchange(
        M,
        #[inline(always)]
        |i, k| {
            let (a, b) = (s[i], s[k]);
            (s[i], s[k]) = if a < b { (b, a) } else { (a, b) };
        },
    );
    let mut sum = -1.0;
    let mut theta = -1.0;
    for k in 1..M {
        sum += s[k] - s[0];
        let candidate = sum * (1.0 / (k + 1) as f64);
        theta = if candidate > theta { candidate } else { theta };
    }
    (s[0], theta)
}

/// A sorting network: calls `exchange` for each pair of n entries that must be put in order, one after the other.
///
/// Batcher's merge exchange for any n: D. Knuth, *The Art of Computer Programming* 3, algorithm 5.2.2 M.
#[inline(always)]
pub fn merge_exchange(n: usize, mut exchange: impl FnMut(usize, usize)) {
    let top = n.next_power_of_two() / 2;
    let mut p = top;
    while p > 0 {
        let (mut q, mut r, mut d) = (top, 0, p);
        loop {
            for i in 0..n - d {
                if i & p == r {
                    exchange(i, i + d);
                }
            }
            if q == p {
                break;
            }
            (d, q, r) = (q - p, q / 2, p);
        }
        p /= 2;
    }
}

/// The same by Michelot's iteration: theta follows from the entries above the previous theta, until their set is
/// stable.
#[inline(always)]
fn threshold_by_shrinking<const M: usize>(v: Row<M>) -> (f64, f64) {
    let mut parts = [f64::NEG_INFINITY; PARTS];
    in_parts(
        &v.0,
        #[inline(always)]
        |i, entry| parts[i] = if entry > parts[i] { entry } else { parts[i] },
    );
    let largest = Row(parts).max();
    let entries = v.0.map(|entry| entry - largest);
    // No entry at -1 or below stays positive; without padding regions at -1e300 no sum overflows.
    let mut theta = -1.0;
    let mut count = (M + 1) as f64;
    loop {
        let (mut sum, mut above) = ([0.0; PARTS], [0.0; PARTS]);
        in_parts(
            &entries,
            #[inline(always)]
            |i, entry| {
                let stays = entry > theta;
                sum[i] += if stays { entry } else { 0.0 };
                above[i] += if stays { 1.0 } else { 0.0 };
            },
        );
        let (sum, above) = (sum.iter().sum::<f64>(), above.iter().sum::<f64>());
        // In exact arithmetic the set only shrinks; rounding must not make it grow and the loop run forever.
        if above >= count || above == 0.0 {
            return (largest, theta);
        }
        count = above;
        theta = (sum - 1.0) / above;
    }
}

/// Calls `take` with the partial sum of each entry and the entry.
#[inline(always)]
fn in_parts(entries: &[f64], mut take: impl FnMut(usize, f64)) {
    let (chunks, rest) = entries.as_chunks::<PARTS>();
    for chunk in chunks {
        for (i, &entry) in chunk.iter().enumerate() {
            take(i, entry);
        }
    }
    for (i, &entry) in rest.iter().enumerate() {
        take(i, entry);
    }
}

/// The nearest point of { q : |q| <= radius }, |.| the Frobenius norm.
#[inline(always)]
pub fn project_ball<const M: usize>(q: Tangent<M>, radius: f64) -> Tangent<M> {
    let norm = q.norm();
    // Two selections and an unconditional division: half of the faces are outside, in no order that a branch predictor
    // could learn.
    let outside = norm > radius;
    q * (if outside { radius } else { 1.0 } / if outside { norm } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The textbook projection: bisect theta in sum_p max(v_p - theta, 0) = 1.
    fn project_by_bisection<const M: usize>(v: Row<M>) -> Row<M> {
        let (mut low, mut high) = (v.max() - 1.0, v.max());
        for _ in 0..200 {
            let theta = 0.5 * (low + high);
            let sum: f64 = v.0.iter().map(|&x| f64::max(x - theta, 0.0)).sum();
            if sum > 1.0 { low = theta } else { high = theta }
        }
        Row::from_fn(|p| f64::max(v.0[p] - 0.5 * (low + high), 0.0))
    }

    fn check<const M: usize>(v: Row<M>) {
        let u = project_simplex(v);
        let scale = 1.0 + v.max().abs();
        assert!((u.0.iter().sum::<f64>() - 1.0).abs() <= 1e-14, "{v:?} {u:?}");
        assert!(u.min() >= 0.0);
        // <v - u, w - u> <= 0 for every w in the simplex; it suffices to check its vertices.
        for p in 0..M {
            assert!((v - u).dot(Row::one_hot(p) - u) <= 1e-13 * scale, "{v:?} {u:?}");
        }
        let expected = project_by_bisection(v);
        assert!((u - expected).norm_squared().sqrt() <= 1e-13 * scale, "{v:?}: {u:?} {expected:?}");
    }

    fn entries<const M: usize>() -> impl Strategy<Value = [f64; M]> {
        let entry = prop_oneof![-2.0..2.0f64, -1e4..1e4f64, Just(0.0), Just(0.5)];
        prop::collection::vec(entry, M).prop_map(|v| v.try_into().unwrap())
    }

    proptest! {
        #[test]
        fn simplex_projection_is_optimal(a in entries::<2>(), b in entries::<3>(), c in entries::<4>(),
                                         d in entries::<7>(), e in entries::<12>(), f in entries::<16>(),
                                         g in entries::<32>(), h in entries::<63>()) {
            check(Row(a)); check(Row(b)); check(Row(c)); check(Row(d)); check(Row(e)); check(Row(f)); check(Row(g)); check(Row(h));
        }

        #[test]
        fn ball_projection_is_optimal(a in entries::<3>(), b in entries::<3>(), radius in 0.0..3.0f64) {
            let v = Tangent([Row(a), Row(b)]);
            let q = project_ball(v, radius);
            prop_assert!(q.norm() <= radius * (1.0 + 1e-14));
            // v - q is a non-negative multiple of q, and zero if v is inside.
            let normal = v - q;
            prop_assert!(normal.dot(q) >= -1e-12);
            prop_assert!((normal.dot(q) - normal.norm() * q.norm()).abs() <= 1e-9 * (1.0 + v.norm_squared()));
            prop_assert!(v.norm() > radius || q == v);
        }
    }

    #[test]
    fn projections_of_huge_rows_sum_to_one() {
        for scale in [1e8, 1e150, 1e300] {
            let u = project_simplex(Row([scale, -scale, 0.3 * scale, scale]));
            assert_eq!(u, Row([0.5, 0.0, 0.0, 0.5]));
        }
    }

    /// Padding regions cost 1e300, times any step size: sums of such entries must not overflow.
    #[test]
    fn hugely_negative_entries_are_ignored() {
        fn check<const M: usize>(far: f64) {
            let mut v = [far; M];
            (v[1], v[M - 1]) = (0.25, 0.75);
            let u = project_simplex(Row(v));
            assert_eq!(u, Row::one_hot(1) * 0.25 + Row::one_hot(M - 1) * 0.75, "{M}, {far:e}");
        }
        for far in [-1e300, -1e308, -1.7e308, f64::NEG_INFINITY] {
            // By sorting, and by shrinking with and without a rest.
            check::<5>(far);
            check::<12>(far);
            check::<19>(far);
            check::<64>(far);
        }
    }

    #[test]
    fn nan_in_gives_nan_out() {
        let u4 = project_simplex(Row([0.1, f64::NAN, 0.3, 0.2]));
        assert!(u4.0.iter().any(|x| x.is_nan()));
        fn check<const M: usize>() {
            for p in 0..M {
                let mut v = [0.1; M];
                v[p] = f64::NAN;
                assert!(project_simplex(Row(v)).0.iter().any(|x| x.is_nan()), "{p} of {M}");
            }
            assert!(project_simplex(Row([f64::NAN; M])).0.iter().all(|x| x.is_nan()));
        }
        check::<12>();
        check::<19>();
        check::<64>();
        let q = project_ball(Tangent([Row([f64::NAN, 0.0]), Row([0.0, 0.0])]), 1.0);
        assert!(q.norm().is_nan());
    }
}
