//! What is kept of a run beside its result.

use serde::{Deserialize, Serialize};

use super::machine::{Machine, Program};

/// `manifest.json`: everything about a run but its result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    /// The hash that names the folder of the run, see [`super::Plan`].
    pub id: String,
    /// The stem of the experiment file.
    pub experiment: String,
    /// The label of the instance.
    pub instance: String,
    /// A hash of the keys and the files that the instance is made from.
    pub instance_id: String,
    /// The label of the solver.
    pub solver: String,
    /// Which repetition it is, from 0.
    pub repetition: u64,
    /// The program that made the run.
    pub program: Program,
    /// Where it was made.
    pub machine: Machine,
    /// Threads of the solver.
    pub threads: usize,
    /// The load average of the last minute before the run.
    pub load_average: f64,
    /// Cores that other processes kept busy.
    pub others: f64,
    /// Whether they were too many for the timing to be trusted.
    pub loaded: bool,
    /// The seed of the instance, for noise and k-means.
    pub seed: u64,
    /// The random number generator of that seed.
    pub generator: String,
    /// When the run began, in UTC as of RFC 3339.
    pub start: String,
    /// When it ended, likewise.
    pub end: String,
    /// The share of the vertices whose label is not the one that synthetic data were made of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mislabeled: Option<f64>,
    /// Seconds from the mesh in memory to the last label, the certificates included; `seconds` of the summary is the
    /// steps alone.
    pub wall_seconds: f64,
    /// How it ended, in words; of a solver that failed, why.
    pub exit: String,
}
