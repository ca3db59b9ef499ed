//! The set of points in the plane, one per region, that are at most sqrt(2) lambda d(a, b) from each other, and the
//! projection onto it. For the metric d = 1 of Potts it is that of diameter at most sqrt(2) lambda.
//!
//! Dykstra's algorithm: pair after pair is projected, q_a and q_b moving by the same length towards each other, and the
//! last move of a pair is undone before its next one. In each round, the pair that is farthest apart joins those that
//! take part; if only two regions are too far from each other, one move is all. Moves do not change the sum of all q_p.
//! If that sum is zero, each |q_p| of the result is less than sqrt(2) lambda times the largest d(a, b), and padding
//! regions, with q_p = 0, keep it. Where rounds are slow, far outside the set, `multipliers.rs` ends them. What is left
//! after the last round is scaled away, so that the result is feasible. R. L. Dykstra, *An algorithm for restricted
//! least squares regression*, J. Amer. Statist. Assoc. 78, 1983.
//!
//! The projection is exact to 1e-10 up to the size of the set, to twice that size for up to 9 regions, and to a hundred times that
//! size for up to 4. At ten times the size, with 16 regions that are all active, it errs by up to 1e-3; farther outside, by more.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::label_metric::LabelMetric;
use super::multipliers::TOLERANCE;
use super::set::{DualSet, Relaxation, squares};
use super::{diameter, multipliers, transport};
use crate::field::Tangent;

/// The set of [`Relaxation::Envelope`], or, for another metric than that of Potts, of [`Relaxation::Metric`]; smoothed:
/// max_q <q_j, (K U)_j> - (eps_j / 2) |q_j|^2 over the set of lambda = 1.
#[derive(Clone, Copy)]
pub struct Envelope(pub LabelMetric);

/// The largest number of rounds.
const MAX_ROUNDS: usize = 1000;

/// The multipliers are tried after so many rounds, and whenever their number has doubled.
const FIRST_TRIAL: usize = 8;

impl DualSet for Envelope {
    #[inline(always)]
    fn relaxation(self) -> Relaxation {
        if self.0.is_potts() { Relaxation::Envelope } else { Relaxation::Metric(self.0) }
    }

    #[inline(always)]
    fn gauge<const M: usize>(self, q: Tangent<M>) -> f64 {
        let Tangent([x, y]) = q;
        FRAC_1_SQRT_2 * self.0.farthest(&x.0, &y.0).1.sqrt()
    }

    #[inline(always)]
    fn project<const M: usize>(self, q: Tangent<M>, lambda: f64) -> Tangent<M> {
        let limit = SQRT_2 * lambda;
        // Within a circle of this diameter.
        let (largest, smallest) = (squares(q).max(), limit * self.0.smallest());
        if 4.0 * largest <= smallest * smallest { q } else { dykstra(q, limit, self.0) }
    }

    #[inline(always)]
    fn support<const M: usize>(self, ku: Tangent<M>) -> f64 {
        SQRT_2
            * match self.0.is_potts() {
                true => diameter::support(ku),
                false => transport::support(ku, self.0),
            }
    }

    #[inline(always)]
    fn smoothed<const M: usize>(self, ku: Tangent<M>, radius: f64) -> f64 {
        let q = self.smoothed_dual(ku, radius, 1.0);
        q.dot(ku) - 0.5 * radius * q.norm_squared()
    }

    #[inline(always)]
    fn smoothed_dual<const M: usize>(self, ku: Tangent<M>, radius: f64, lambda: f64) -> Tangent<M> {
        self.project(ku * (lambda / radius), lambda)
    }
}

#[inline(never)]
fn dykstra<const M: usize>(q: Tangent<M>, limit: f64, metric: LabelMetric) -> Tangent<M> {
    if limit == 0.0 {
        // All points are equal, and those of a sum of zero are zero.
        return q * 0.0;
    }
    let Tangent([mut x, mut y]) = q;
    let allowed = (limit * (1.0 + TOLERANCE)).powi(2);
    // The pairs that take part, and their last moves.
    let (mut pairs, mut moves) = ([[[0_u8; 2]; M]; M], [[[0.0; 2]; M]; M]);
    let (pairs, moves) = (pairs.as_flattened_mut(), moves.as_flattened_mut());
    let (mut count, mut next_trial) = (0, FIRST_TRIAL);
    for round in 1..=MAX_ROUNDS {
        let ([a, b], square) = metric.farthest(&x.0, &y.0);
        let pair = [a as u8, b as u8];
        if square > allowed && !pairs[..count].contains(&pair) {
            pairs[count] = pair;
            count += 1;
        } else if square <= allowed && count <= 1 {
            break;
        }
        let mut largest = 0.0;
        for (&[a, b], last) in pairs[..count].iter().zip(&mut *moves) {
            let (a, b) = (usize::from(a), usize::from(b));
            // Without the last move, the pair is this far apart.
            let (dx, dy) = (x.0[a] - x.0[b] + 2.0 * last[0], y.0[a] - y.0[b] + 2.0 * last[1]);
            let (distance, most) = ((dx * dx + dy * dy).sqrt(), limit * metric.apart(a, b));
            let share = if distance > most { 0.5 * (distance - most) / distance } else { 0.0 };
            let next = [share * dx, share * dy];
            let step = [next[0] - last[0], next[1] - last[1]];
            x.0[a] -= step[0];
            y.0[a] -= step[1];
            x.0[b] += step[0];
            y.0[b] += step[1];
            *last = next;
            largest = f64::max(largest, f64::max(step[0].abs(), step[1].abs()));
        }
        if square <= allowed && largest <= TOLERANCE * limit * metric.smallest() {
            break;
        }
        if round == next_trial {
            next_trial *= 2;
            let all = pairs[..count].iter().zip(&*moves);
            if let Some(exact) = multipliers::project(q, (limit, metric), all) {
                Tangent([x, y]) = exact;
                break;
            }
        }
    }
    let square = metric.farthest(&x.0, &y.0).1;
    let scale = if square > limit * limit { limit / square.sqrt() } else { 1.0 };
    Tangent([x, y]) * scale
}
