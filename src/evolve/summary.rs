//! The numbers of a reconstruction.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::at_rest::{Level, Reconstruction};
use super::descent::End;
use super::energy::Terms;
use super::quality::Quality;
use crate::mesh::distance::Distances;
use crate::solve;

/// The numbers of a reconstruction, as in `summary.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    /// How the last level ended.
    pub status: End,
    /// [`End::sentence`].
    pub status_sentence: Cow<'static, str>,
    /// As measured by the caller.
    pub seconds: f64,
    /// V.
    pub vertices: usize,
    /// F.
    pub faces: usize,
    /// m.
    pub regions: usize,
    /// E of the last surface. Nothing bounds it from below.
    pub energy: f64,
    /// Its terms.
    pub energy_terms: Terms,
    /// Area per pixel.
    pub sigma: f64,
    /// lambda for the surface as it is.
    pub lambda: f64,
    /// How well the surface agrees with its images.
    #[serde(flatten)]
    pub quality: Quality,
    /// Distances to the truth, if that is given, in shares of its diagonal.
    pub distances: Option<Distances>,
    /// Steps on all levels.
    pub steps: usize,
    /// The levels.
    pub levels: Vec<Level>,
    /// The certificate of the labels for the last surface and colors; `None` for one region.
    pub labels: Option<solve::Summary>,
}

impl Summary {
    /// The numbers of what was found in the given time.
    pub fn of(found: &Reconstruction, seconds: f64) -> Self {
        let Reconstruction { surface, quality, levels, .. } = found;
        let end = found.end();
        Summary {
            status: end,
            status_sentence: end.sentence().into(),
            seconds,
            vertices: surface.mesh.vertices.len(),
            faces: surface.mesh.faces.len(),
            regions: surface.coloring.regions(),
            energy: found.terms.sum(),
            energy_terms: found.terms,
            sigma: found.sigma,
            lambda: found.lambda,
            quality: quality.clone(),
            distances: found.distances,
            steps: found.trace.len(),
            levels: levels.clone(),
            labels: found.solution.as_ref().map(|solution| solution.summary.clone()),
        }
    }
}
