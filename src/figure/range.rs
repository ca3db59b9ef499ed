//! What stretch of an axis is shown.

use super::Scale;

/// Larger numbers, and smaller ones on a logarithmic axis, have no position: their ranges would overflow.
const LARGEST_DRAWN: f64 = 1e300;
/// Numbers that differ by less than this share of their size are drawn as one.
const LEAST_RELATIVE_SPAN: f64 = 1e-9;
/// The part of the data's span that is added at either end, for a line not to run along the frame.
const PADDING: f64 = 0.04;
/// Numbers of which the smallest is at most this share of the largest are shown from zero on.
const NEAR_ZERO: f64 = 0.25;

impl Scale {
    /// Where a number is, in units of the axis: its own, or decades.
    pub(super) fn position(self, value: f64) -> Option<f64> {
        match self {
            Scale::Linear => (value.abs() <= LARGEST_DRAWN)
                .then_some(if value.abs() < 1.0 / LARGEST_DRAWN { 0.0 } else { value }),
            Scale::Log => {
                (1.0 / LARGEST_DRAWN..=LARGEST_DRAWN).contains(&value).then(|| value.log10())
            }
        }
    }
}

/// Both ends in units of the axis.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    pub scale: Scale,
    pub low: f64,
    pub high: f64,
}

impl Range {
    /// A range that holds all of these with room at its ends; a linear one begins at zero if they come near
    /// it. `None` if there is nothing to show.
    pub fn holding(scale: Scale, values: impl Iterator<Item = f64>) -> Option<Self> {
        let positions = values.filter_map(|value| scale.position(value));
        let (low, high) = positions
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), position| {
                (low.min(position), high.max(position))
            });
        if low > high {
            return None;
        }
        let size = low.abs().max(high.abs());
        let alike = high - low <= LEAST_RELATIVE_SPAN * size.max(1.0 / LARGEST_DRAWN);
        let padding = match scale {
            Scale::Log if alike => 0.5,
            Scale::Linear if size == 0.0 => 1.0,
            Scale::Linear if alike => 0.1 * size,
            _ => PADDING * (high - low),
        };
        let from_zero = scale == Scale::Linear && !alike && (0.0..=NEAR_ZERO * high).contains(&low);
        let low = if from_zero { 0.0 } else { low - padding };
        Some(Range { scale, low, high: high + padding })
    }

    /// The part of the range below a position.
    pub fn share(&self, position: f64) -> f64 {
        (position - self.low) / (self.high - self.low)
    }
}
