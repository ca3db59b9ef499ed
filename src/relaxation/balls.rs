//! The two sets that consist of balls: one for all regions together, and one for each of them.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::set::{DualSet, Relaxation, squares};
use crate::field::{Row, Tangent};
use crate::prox::project_ball;

/// The set of [`Relaxation::Frobenius`]; smoothed: sqrt( |(K U)_j|^2 + eps_j^2 ).
#[derive(Clone, Copy)]
pub struct Frobenius;

impl DualSet for Frobenius {
    #[inline(always)]
    fn relaxation(self) -> Relaxation {
        Relaxation::Frobenius
    }

    #[inline(always)]
    fn gauge<const M: usize>(self, q: Tangent<M>) -> f64 {
        q.norm()
    }

    #[inline(always)]
    fn project<const M: usize>(self, q: Tangent<M>, lambda: f64) -> Tangent<M> {
        project_ball(q, lambda)
    }

    #[inline(always)]
    fn support<const M: usize>(self, ku: Tangent<M>) -> f64 {
        ku.norm()
    }

    #[inline(always)]
    fn smoothed<const M: usize>(self, ku: Tangent<M>, radius: f64) -> f64 {
        (ku.norm_squared() + radius.powi(2)).sqrt()
    }

    #[inline(always)]
    fn smoothed_dual<const M: usize>(self, ku: Tangent<M>, radius: f64, lambda: f64) -> Tangent<M> {
        ku * (lambda / self.smoothed(ku, radius))
    }
}

/// The set of [`Relaxation::Separate`]; smoothed: eps_j + 1/2 sum_p ( sqrt( 2 |(K U)_jp|^2 + eps_j^2 ) - eps_j ), which is that
/// of `Frobenius` where only two regions change. It has the same curvature at most, 1 / eps_j.
#[derive(Clone, Copy)]
pub struct Separate;

impl DualSet for Separate {
    #[inline(always)]
    fn relaxation(self) -> Relaxation {
        Relaxation::Separate
    }

    #[inline(always)]
    fn gauge<const M: usize>(self, q: Tangent<M>) -> f64 {
        SQRT_2 * squares(q).max().sqrt()
    }

    #[inline(always)]
    fn project<const M: usize>(self, q: Tangent<M>, lambda: f64) -> Tangent<M> {
        let radius = FRAC_1_SQRT_2 * lambda;
        let scale = squares(q).0.map(
            #[inline(always)]
            |square| {
                let norm = square.sqrt();
                let outside = norm > radius;
                (if outside { radius } else { 1.0 }) / (if outside { norm } else { 1.0 })
            },
        );
        scaled(q, Row(scale))
    }

    #[inline(always)]
    fn support<const M: usize>(self, ku: Tangent<M>) -> f64 {
        let mut sum = 0.0;
        for square in squares(ku).0 {
            sum += square.sqrt();
        }
        FRAC_1_SQRT_2 * sum
    }

    #[inline(always)]
    fn smoothed<const M: usize>(self, ku: Tangent<M>, radius: f64) -> f64 {
        // sqrt(x + y) - sqrt(y) without cancellation.
        let square = radius.powi(2);
        let excess = |x: f64| 2.0 * x / ((2.0 * x + square).sqrt() + radius);
        radius + 0.5 * squares(ku).0.map(excess).iter().sum::<f64>()
    }

    #[inline(always)]
    fn smoothed_dual<const M: usize>(self, ku: Tangent<M>, radius: f64, lambda: f64) -> Tangent<M> {
        let square = radius.powi(2);
        scaled(ku, Row(squares(ku).0.map(|x| lambda / (2.0 * x + square).sqrt())))
    }
}

/// Each region by its own factor.
#[inline(always)]
fn scaled<const M: usize>(Tangent(rows): Tangent<M>, scale: Row<M>) -> Tangent<M> {
    Tangent(rows.map(|row| Row::from_fn(|p| row.0[p] * scale.0[p])))
}
