//! `trace.csv` of a reconstruction: a row for the surface after every number of steps.

use std::path::Path;

use serde::Serialize;

use crate::error::Result;
use crate::evolve::{Reconstruction, Step, Terms};
use crate::file;

/// How well a surface agrees with the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// The mean distance to the true surface, in shares of its diagonal.
    pub distance: Option<f64>,
    /// The share of the area with a wrong label.
    pub mislabeled: Option<f64>,
    /// Intersection over union of all silhouettes.
    pub silhouette_iou: Option<f64>,
}

/// A row. The terms of the energy have their weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The number of steps so far.
    step: usize,
    /// From 0.
    level: usize,
    /// Of all steps so far.
    seconds: f64,
    energy: f64,
    images: f64,
    cuts: f64,
    area: f64,
    roughness: f64,
    /// The largest motion of a vertex in the next step, in units of the mesh; 0 if its search failed.
    #[serde(rename = "move")]
    motion: Option<f64>,
    /// How often that step was halved.
    halvings: Option<u32>,
    /// The length of the visible contours in all images, in pixels.
    contour_pixels: Option<f64>,
    distance: Option<f64>,
    mislabeled: Option<f64>,
    silhouette_iou: Option<f64>,
}

impl Row {
    /// The surface before a step, with the seconds of the steps before it.
    pub fn of(step: &Step, seconds: f64, measures: Measures) -> Self {
        Row {
            motion: Some(step.motion),
            halvings: Some(step.halvings),
            contour_pixels: Some(step.contour_pixels),
            ..Row::at((step.step, step.level), seconds, &step.terms, measures)
        }
    }

    /// The last surface.
    pub fn last(found: &Reconstruction, seconds: f64, measures: Measures) -> Self {
        let level = found.levels.len().saturating_sub(1);
        Row::at((found.trace.len(), level), seconds, &found.terms, measures)
    }

    fn at((step, level): (usize, usize), seconds: f64, terms: &Terms, measures: Measures) -> Self {
        let Terms { images, cuts, area, roughness } = *terms;
        let Measures { distance, mislabeled, silhouette_iou } = measures;
        Row {
            step,
            level,
            seconds,
            energy: terms.sum(),
            images,
            cuts,
            area,
            roughness,
            motion: None,
            halvings: None,
            contour_pixels: None,
            distance,
            mislabeled,
            silhouette_iou,
        }
    }
}

/// Writes the rows.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<()> {
    file::write(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        for row in rows {
            csv.serialize(row)?;
        }
        csv.flush()
    })
}
