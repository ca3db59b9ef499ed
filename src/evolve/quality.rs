//! How well a surface agrees with its images, and whether it is one.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::coloring::Coloring;
use super::folds::{self, Folds};
use super::images::{Shot, squared_distance};
use super::silhouette::{Silhouette, overlap};
use super::statistics::Sums;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::sweep;

/// The quality of a surface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Quality {
    /// The pixels in which both the surface and the silhouette are, over those in which either is; over all images.
    pub silhouette_iou: f64,
    /// What the silhouettes are: `truth`, `masks`, or `colors` (pixels nearer to a region than to the background).
    pub silhouettes: Cow<'static, str>,
    /// The share of all pixels of all images that are in these silhouettes.
    #[serde(default)]
    pub filled_share: f64,
    /// The share of the area that is in no image.
    pub unseen_share: f64,
    /// Folds and self-intersections.
    #[serde(flatten)]
    pub folds: Folds,
}

/// The silhouettes that a surface should have: those of the truth, or else the masks, if all shots have one.
pub fn known_silhouettes(shots: &[Shot], truth: Option<&Mesh>) -> Option<Vec<Silhouette>> {
    let masked = shots.iter().all(|shot| shot.picture.has_mask());
    (masked || truth.is_some()).then(|| {
        sweep::results(shots.iter().collect(), |shot: &Shot| match truth {
            Some(truth) => Silhouette::of(truth, &shot.view.camera, shot.size()),
            None => shot.silhouette(|_, _| true),
        })
    })
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
        let known = known_silhouettes(shots, truth);
        let masked = known.is_some();
        let given = known.unwrap_or_else(|| {
            sweep::results(shots.iter().collect(), |shot: &Shot| {
                shot.silhouette(|color, background| {
                    let distance = |mu: &[f64; 3]| squared_distance(color, *mu);
                    let beyond = squared_distance(color, background);
                    coloring.mu.iter().any(|mu| distance(mu) < beyond)
                })
            })
        });
        let inside = given.iter().flat_map(|silhouette| &silhouette.inside);
        let (filled, pixels) = inside
            .fold((0_u64, 0_u64), |(filled, all), &inside| (filled + u64::from(inside), all + 1));
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
            }
            .into(),
            filled_share: filled as f64 / pixels as f64,
            unseen_share: unseen / areas.iter().sum::<f64>(),
            folds: folds::count(mesh),
        }
    }
}
