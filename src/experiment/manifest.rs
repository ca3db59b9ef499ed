//! What is kept of a run beside its result.

use serde::{Deserialize, Serialize};

use super::machine::{Machine, Program};

/// `manifest.json`: everything about a run but its result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    pub id: String,
    pub experiment: String,
    pub instance: String,
    pub instance_id: String,
    pub solver: String,
    pub repetition: u64,
    pub program: Program,
    pub machine: Machine,
    pub threads: usize,
    /// Of the last minute, before the run.
    pub load_average: f64,
    /// Cores that other processes kept busy.
    pub others: f64,
    /// Whether they were too many for the timing to be trusted.
    pub loaded: bool,
    pub seed: u64,
    /// What the seed was for.
    pub generator: String,
    /// UTC.
    pub start: String,
    pub end: String,
    /// The share of the vertices whose label is not the one that synthetic data were made of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mislabeled: Option<f64>,
    /// From the mesh in memory to the last label, the certificates included; `seconds` of the summary is the steps
    /// alone.
    pub wall_seconds: f64,
    pub exit: String,
}
