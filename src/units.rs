//! Units of cost in which no square under- or overflows.
//!
//! ```text
//! s, lambda, q = unit s', unit lambda', unit q'          E(U; s, lambda) = unit E(U; s', lambda')
//! ```
//!
//! Solvers square costs, lambda and entries of q, which fails near 1e-160 and 1e160. A unit is a power of two, so that
//! nothing is rounded; it is 1 unless costs and lambda are far from 1.

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::problem::FORBIDDEN_COST;

/// Costs and lambda of this size, up or down, leave room for any power that is computed.
const ORDINARY: std::ops::RangeInclusive<f64> = 1e-60..=1e60;

/// Beyond this ratio, the smaller one leaves the range of double precision where the larger one is ordinary.
const LARGEST_RATIO: f64 = 1e200;

/// A unit of cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit(f64);

impl Unit {
    /// That of finite costs and a lambda per length, which weigh as much as costs on an area if length^2 is the area.
    /// `None` if it is 1, and if one of the two is so much larger that no unit suits both.
    pub fn of(costs: &Array2<f64>, lambda: f64, length: f64) -> Option<Self> {
        let finite = costs.iter().map(|cost| cost.abs()).filter(|&cost| cost < FORBIDDEN_COST);
        let (costs, lambda) = (finite.fold(0.0, f64::max), lambda / length);
        let fits = |small: f64, large: f64| small == 0.0 || small >= LARGEST_RATIO.recip() * large;
        match fits(costs, lambda) && fits(lambda, costs) {
            true => Self::of_size(f64::max(costs, lambda)),
            false => None,
        }
    }

    /// That of costs up to this one.
    pub fn of_size(largest: f64) -> Option<Self> {
        let is_ordinary = largest == 0.0 || ORDINARY.contains(&largest) || !largest.is_finite();
        // A normal number, whose inverse is one, too.
        (!is_ordinary).then(|| Unit(largest.log2().floor().clamp(-1000.0, 1000.0).exp2()))
    }

    /// A number in this unit.
    pub fn of_number(self, x: f64) -> f64 {
        x / self.0
    }

    /// Numbers in this unit; infinite ones stay.
    pub fn of_array(self, array: &Array2<f64>) -> Array2<f64> {
        array.mapv(|x| self.of_number(x))
    }

    /// A number in this unit as it was given.
    pub fn given(self, x: f64) -> f64 {
        x * self.0
    }

    /// Fails if an energy overflows as it was given.
    pub fn check(self, energies: &[f64]) -> Result<()> {
        match energies.iter().all(|energy| energy.is_finite()) {
            true => Ok(()),
            false => Err(Error::unsuitable(
                "the costs times the areas leave the range of double precision; scale the costs or the mesh down",
            )),
        }
    }
}
