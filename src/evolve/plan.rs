//! What a reconstruction is asked for.

use super::energy::Sampling;
use super::lit::Light;
use super::metric;
use crate::error::{Error, Result};

/// beta on the first level, on which vertices move far, in units of that of later ones.
pub const FIRST_BETA: f64 = 2.0;

const MAX_BETA: f64 = metric::MAX_BETA / FIRST_BETA;

/// The request to [`reconstruct`](super::reconstruct).
#[derive(Clone, Debug)]
pub struct Plan {
    /// m; 1 for silhouettes.
    pub regions: usize,
    /// Levels of mesh and images, at least 1.
    pub levels: usize,
    /// The largest number of steps on each level.
    pub steps: usize,
    /// lambda, for a surface of area 1, as for segmentations.
    pub lambda: f64,
    /// beta of the metric, twice as much on the first level.
    pub beta: f64,
    /// Between levels the edges longer than this many times the median are divided and edges flipped, if it is given; else
    /// every face is divided into four.
    pub split: Option<f64>,
    /// The light, if the regions have albedos.
    pub light: Option<Light>,
    /// Of the clusters of colors.
    pub seed: u64,
    /// How finely images are sampled.
    pub sampling: Sampling,
    /// kappa, the weight of the area, relative to the costs of squared colors.
    pub kappa: f64,
    /// eta, the weight of the roughness: larger for smoother surfaces, smaller for thin parts and sharp edges.
    pub eta: f64,
    /// The part of the tangential differences that smooths the mesh after each step.
    pub smoothing: f64,
    /// Whether pixels that do not show the surface count, by |I - b|^2. Without them an empty surface has the least energy.
    pub background: bool,
    /// Whether the gradient of the images has the parts of the interior and of the light. Without them only contours move
    /// the surface.
    pub interior: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Plan {
            regions: 2,
            levels: 3,
            steps: 60,
            lambda: 0.0005,
            beta: 5.0,
            split: None,
            light: None,
            seed: 0,
            sampling: Sampling::default(),
            kappa: 0.0,
            eta: 2.0,
            smoothing: 0.1,
            background: true,
            interior: true,
        }
    }
}

impl Plan {
    /// Fails if a number is out of its range.
    pub fn check(&self) -> Result<()> {
        let fail = |message: String| Err(Error::unsuitable(message));
        if !(1..=64).contains(&self.regions) {
            return fail(format!("{} regions: must be from 1 to 64", self.regions));
        }
        if self.levels == 0 || self.steps == 0 {
            return fail("a reconstruction needs a level and a step".into());
        }
        for (name, value) in [
            ("lambda", self.lambda),
            ("the metric", self.beta),
            ("kappa", self.kappa),
            ("the roughness", self.eta),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return fail(format!("{name} is {value:?}: must be a finite number, 0 or more"));
            }
        }
        if self.beta > MAX_BETA {
            return fail(format!("the metric is {:?}: must be at most {MAX_BETA:e}", self.beta));
        }
        match self.split {
            Some(split) if !(split >= 1.0 && split.is_finite()) => {
                fail(format!("the split is {split:?}: must be a finite number, 1 or more"))
            }
            _ => Ok(()),
        }
    }
}
