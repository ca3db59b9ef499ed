//! `summary.json` of a run: of labels, or of a surface.

use serde::Serialize;

use crate::evolve;
use crate::solve::Summary;

/// The numbers of a run.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// Those of labels.
    Labels(Box<Summary>),
    /// Those of a surface. Its labels are certified, but nothing bounds its energy from below.
    Surface(Box<evolve::Summary>),
}

impl Numbers {
    /// Reads the numbers of a run whose solver has this name.
    ///
    /// # Errors
    /// The text is not JSON of the expected form.
    pub fn parse(json: &[u8], solver: &str) -> serde_json::Result<Self> {
        match solver {
            super::spec::RECONSTRUCT => serde_json::from_slice(json).map(Numbers::Surface),
            _ => serde_json::from_slice(json).map(Numbers::Labels),
        }
    }

    /// Those of labels.
    pub fn labels(&self) -> Option<&Summary> {
        match self {
            Numbers::Labels(summary) => Some(summary),
            Numbers::Surface(_) => None,
        }
    }

    /// Those of a surface.
    pub fn surface(&self) -> Option<&evolve::Summary> {
        match self {
            Numbers::Labels(_) => None,
            Numbers::Surface(summary) => Some(summary),
        }
    }

    /// V, of the last surface.
    pub fn vertices(&self) -> usize {
        match self {
            Numbers::Labels(summary) => summary.vertices,
            Numbers::Surface(summary) => summary.vertices,
        }
    }

    /// F, of the last surface.
    pub fn faces(&self) -> usize {
        match self {
            Numbers::Labels(summary) => summary.faces,
            Numbers::Surface(summary) => summary.faces,
        }
    }

    /// m.
    pub fn regions(&self) -> usize {
        match self {
            Numbers::Labels(summary) => summary.regions,
            Numbers::Surface(summary) => summary.regions,
        }
    }

    /// Iterations of the solver, or steps of the surface.
    pub fn iterations(&self) -> u64 {
        match self {
            Numbers::Labels(summary) => summary.iterations,
            Numbers::Surface(summary) => summary.steps as u64,
        }
    }

    /// Time of these, in seconds.
    pub fn seconds(&self) -> f64 {
        match self {
            Numbers::Labels(summary) => summary.seconds,
            Numbers::Surface(summary) => summary.seconds,
        }
    }

    /// E.
    pub fn energy(&self) -> f64 {
        match self {
            Numbers::Labels(summary) => summary.energy,
            Numbers::Surface(summary) => summary.energy,
        }
    }

    /// The status, as in `summary.json`.
    pub fn status(&self) -> String {
        let name = match self {
            Numbers::Labels(summary) => serde_json::to_value(summary.status),
            Numbers::Surface(summary) => serde_json::to_value(summary.status),
        };
        name.expect("a plain name").as_str().expect("a plain name").to_owned()
    }

    /// The main numbers on a line.
    pub fn line(&self) -> String {
        match self {
            Numbers::Labels(it) => {
                let Summary { iterations, seconds, relative_gap, .. } = &**it;
                format!("{iterations} iterations, {seconds:.3} s, gap {relative_gap:.1e}")
            }
            Numbers::Surface(it) => {
                let evolve::Summary { steps, seconds, distances, quality, .. } = &**it;
                let agreement = match distances {
                    Some(distances) => format!("distance {:.3} %", 100.0 * distances.mean),
                    None => format!("silhouettes agree to {:.3}", quality.silhouette_iou),
                };
                format!("{steps} steps, {seconds:.3} s, {agreement}")
            }
        }
    }
}
