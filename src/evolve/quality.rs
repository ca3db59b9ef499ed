//! How well a surface agrees with its images, and whether it is one.

use serde::Serialize;

use super::coloring::Coloring;
use super::folds::{self, Folds};
use super::images::{Shot, squared_distance};
use super::silhouette::{Silhouette, overlap};
use super::statistics::Sums;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::sweep;

/// The quality of a surface.
#[derive(Clone, Debug, Serialize)]
pub struct Quality {
    /// The pixels in which both the surface and the silhouette are, over those in which either is; over all images.
    pub silhouette_iou: f64,
    /// What the silhouettes are: `truth`, `masks`, or `colors` (pixels nearer to a region than to the background).
    pub silhouettes: &'static str,
    /// The share of the area that is in no image.
    pub unseen_share: f64,
    /// Folds and self-intersections.
    #[serde(flatten)]
    pub folds: Folds,
}

impl Quality {
    /// That of a surface with these regions and statistics, in front of all pixels of the shots.
    pub fn of(
        mesh: &Mesh,
        coloring: &Coloring,
        sums: &[Sums],
        shots: &[Shot],
        truth: Option<&Mesh>,
    ) -> Self {
        let masked = shots.iter().all(|shot| shot.picture.has_mask());
        let given = sweep::results(shots.iter().collect(), |shot: &Shot| match truth {
            Some(truth) => Silhouette::of(truth, &shot.view.camera, shot.size()),
            None if masked => shot.silhouette(|_, _| true),
            None => shot.silhouette(|color, background| {
                let distance = |mu: &[f64; 3]| squared_distance(color, *mu);
                let beyond = squared_distance(color, background);
                coloring.mu.iter().any(|mu| distance(mu) < beyond)
            }),
        });
        let areas = barycentric_areas(mesh);
        let unseen = areas.iter().zip(sums).filter(|(_, sums)| sums.w == 0.0).map(|(area, _)| area);
        // An empty sum is -0.
        let unseen = unseen.fold(0.0, |sum, area| sum + area);
        Quality {
            silhouette_iou: overlap(mesh, &given).iou(),
            silhouettes: match truth {
                Some(_) => "truth",
                None if masked => "masks",
                None => "colors",
            },
            unseen_share: unseen / areas.iter().sum::<f64>(),
            folds: folds::count(mesh),
        }
    }
}
