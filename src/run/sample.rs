//! What is known of a run at one of its iterations: a row of its trace, and what certifies it.

use serde::{Deserialize, Serialize};

/// One row of a trace.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sample {
    /// Steps made until then; 0 for the start.
    pub iteration: u64,
    /// Wall time in steps, in seconds; evaluations do not count.
    pub seconds: f64,
    /// The least E seen so far for the current costs.
    pub energy: f64,
    /// The greatest D seen so far for the current costs.
    pub dual_bound: f64,
    /// Their difference.
    pub gap: f64,
    /// gap / (E - B).
    pub relative_gap: f64,
    /// max |u^n - u^{n-1}|; none before the first step.
    pub change: Option<f64>,
    /// E_eps of this iterate, for solvers that minimize it.
    pub smoothed_energy: Option<f64>,
    /// What the bound of this iterate comes from, for a solver outside the program; `dual_bound` may be an
    /// earlier one.
    pub certificate: Option<Certificate>,
}

/// The dual field that certifies a foreign iterate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Certificate {
    /// The solver's own q, cut off at lambda.
    Offered,
    /// q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 ), the gradient of the energy that it minimizes.
    Smoothed,
    /// What a number of our own steps from its U reach.
    Steps,
}

impl Certificate {
    /// `offered`, `smoothed` or `steps`.
    pub fn name(self) -> &'static str {
        match self {
            Certificate::Offered => "offered",
            Certificate::Smoothed => "smoothed",
            Certificate::Steps => "steps",
        }
    }
}
