//! The range of an axis.

use super::Scale;

/// Larger numbers, and smaller ones on a logarithmic axis, have no position: their ranges would overflow.
const LARGEST_DRAWN: f64 = 1e300;
/// Numbers whose relative difference is smaller are drawn as one.
const MIN_RELATIVE_SPAN: f64 = 1e-9;
/// Share of the span that is added at both ends, so that lines do not touch the frame.
const PADDING: f64 = 0.04;
/// If the smallest number is at most this share of the largest, a linear axis starts at zero.
const NEAR_ZERO: f64 = 0.25;

impl Scale {
    /// The position of a number in units of the axis: the number itself, or its decimal logarithm.
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

/// The range of an axis, in its units.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    pub scale: Scale,
    pub low: f64,
    pub high: f64,
}

impl Range {
    /// A range that contains all values with padding at its ends; a linear one starts at zero if the values come near
    /// it. `None` if there are no values to show.
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
        let alike = high - low <= MIN_RELATIVE_SPAN * size.max(1.0 / LARGEST_DRAWN);
        let padding = match scale {
            Scale::Log if alike => 0.5,
            Scale::Linear if size == 0.0 => 1.0,
            Scale::Linear if alike => 0.1 * size,
            _ => PADDING * (high - low),
        };
        // A line at zero itself would lie on the frame.
        let from_zero = scale == Scale::Linear && !alike && low > 0.0 && low <= NEAR_ZERO * high;
        let low = if from_zero { 0.0 } else { low - padding };
        Some(Range { scale, low, high: high + padding })
    }

    /// The smallest range that contains both.
    pub fn union(self, other: Range) -> Range {
        Range { low: self.low.min(other.low), high: self.high.max(other.high), ..self }
    }

    /// The share of the range below a position.
    pub fn share(&self, position: f64) -> f64 {
        (position - self.low) / (self.high - self.low)
    }
}
