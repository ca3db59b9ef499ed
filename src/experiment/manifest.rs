//! The stored description of a run.

use serde::{Deserialize, Serialize};

use super::machine::{Machine, Program};
use crate::level_sets::LevelSet;

/// The agreement with right labels, see [`crate::agreement`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// The Rand index.
    pub rand_index: f64,
    /// The variation of information, in bits.
    pub variation_of_information: f64,
    /// The covering of the truth.
    pub covering: f64,
    /// F of the boundaries, on a grid.
    pub boundary_f: Option<f64>,
}

/// `manifest.json`: everything about a run except its result.
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
    /// Number of cores that other processes kept busy.
    pub others: f64,
    /// Whether these were too many for the timing to be trusted.
    pub loaded: bool,
    /// The seed of the instance, for noise and k-means.
    pub seed: u64,
    /// The random number generator of that seed.
    pub generator: String,
    /// Time when the run began, UTC in the format of RFC 3339.
    pub start: String,
    /// Time when the run ended, in the same format.
    pub end: String,
    /// The share of the area whose label is not the right one, for estimated parameters and given truths under the best
    /// matching of regions; the mean over several truths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mislabeled: Option<f64>,
    /// Other measures of the agreement with the right labels, means over several truths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scores: Option<Scores>,
    /// The length of the cut between the labels, in units of the mesh as it is solved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut_length: Option<f64>,
    /// The share of vertices whose largest u_kp exceeds 0.99.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub binary: Option<f64>,
    /// The thresholds of two regions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level_sets: Option<Vec<LevelSet>>,
    /// The values of the region parameters, a list per region, if they are not those of the instance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameters: Option<Vec<Vec<f64>>>,
    /// Seconds from the mesh in memory to the labels, including the certificates; `seconds` of the summary counts the
    /// steps only.
    pub wall_seconds: f64,
    /// A sentence that says how the run ended, or why the solver failed.
    pub exit: String,
}
