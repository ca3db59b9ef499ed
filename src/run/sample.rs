//! The state of a run at one of its iterations: a row of the trace, and the origin of its bound.

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::units::Unit;

/// One row of a trace.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sample {
    /// Number of steps so far; 0 for the start.
    pub iteration: u64,
    /// Wall time of the steps, in seconds; evaluations do not count.
    pub seconds: f64,
    /// The smallest E so far for the current costs.
    pub energy: f64,
    /// The largest D so far for the current costs.
    pub dual_bound: f64,
    /// E - D.
    pub gap: f64,
    /// gap / (E - B).
    pub relative_gap: f64,
    /// max |u^n - u^{n-1}|; `None` before the first step.
    pub change: Option<f64>,
    /// E_eps of this iterate, for solvers that minimize it.
    pub smoothed_energy: Option<f64>,
    /// The origin of the bound of this iterate, for an external solver; `dual_bound` may be an earlier one.
    pub certificate: Option<Certificate>,
}

impl Sample {
    /// A sample of a run in a unit of cost, as it was given.
    pub(crate) fn given(self, unit: Unit) -> Self {
        Sample {
            energy: unit.given(self.energy),
            dual_bound: unit.given(self.dual_bound),
            gap: unit.given(self.gap),
            smoothed_energy: self.smoothed_energy.map(|energy| unit.given(energy)),
            ..self
        }
    }
}

/// The dual field that certifies an iterate of an external solver or a given U.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    EnumString,
    IntoStaticStr,
    VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Certificate {
    /// The given q, projected onto |q_j| <= lambda.
    Offered,
    /// q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 ), the gradient of the smoothed total variation.
    Smoothed,
    /// The best field after a number of steps of the default solver from U.
    Steps,
}
