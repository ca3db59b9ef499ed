//! What a user should know of a surface that was reconstructed, with what to do next.

use crate::counted::counted;
use crate::empty_regions;
use crate::evolve::Reconstruction;
use crate::evolve::images::Shot;
use crate::mesh::Mesh;
use crate::{Error, Result};

/// A smaller agreement of silhouettes means that the surface is somewhere else.
const MIN_AGREEMENT: f64 = 0.5;

/// Silhouettes that fill a larger share of the images leave no background around the surface.
const MAX_FILLED: f64 = 0.95;

/// A larger share of the area in no image is reported.
const MAX_UNSEEN: f64 = 0.01;

/// The warnings, a sentence each.
pub fn about(found: &Reconstruction, shots: &[Shot]) -> Vec<String> {
    let quality = &found.quality;
    let mut warnings = Vec::new();
    if quality.filled_share > MAX_FILLED {
        warnings.push(format!(
            "the silhouettes (those of {}) fill {:.1} % of the images, so that nothing bounds the surface; check the masks or \
             --background",
            quality.silhouettes,
            100.0 * quality.filled_share
        ));
    }
    if quality.silhouette_iou < MIN_AGREEMENT {
        warnings.push(format!(
            "the silhouettes of the surface agree with those of {} to {:.4} only; give a --start nearer to it, or more --steps",
            quality.silhouettes, quality.silhouette_iou
        ));
    }
    let empty = found.solution.as_ref().map_or(&[][..], |solution| &solution.summary.empty_regions);
    if !empty.is_empty() {
        warnings.push(format!(
            "{}: no pixel is nearest to {}, or --lambda is too large; try fewer --regions, another --seed or a smaller --lambda",
            empty_regions::sentence(empty),
            if empty.len() == 1 { "its color" } else { "their colors" }
        ));
    }
    if quality.unseen_share > MAX_UNSEEN {
        warnings.push(format!(
            "{:.1} % of the area is in no image, at the resolution of the pixels: there labels are those of the neighbors, and \
             nothing but its smoothness shapes the surface; more views help, or fewer --levels if faces are smaller than pixels",
            100.0 * quality.unseen_share
        ));
    }
    let mesh = &found.surface.mesh;
    let behind = shots.iter().filter(|shot| reaches_behind(mesh, shot)).count();
    if behind > 0 {
        warnings.push(format!(
            "faces reach behind {}, which do not see them; give a smaller --start",
            counted(behind, "camera", "cameras")
        ));
    }
    let folds = &quality.folds;
    if folds.folded_edges + folds.intersecting_pairs > 0 {
        warnings.push(format!(
            "the surface is folded at {} and intersects itself in {}; raise --roughness, start from a surface of the right \
             topology (--start hull), or give more views",
            counted(folds.folded_edges, "edge", "edges"),
            counted(folds.intersecting_pairs, "pair of faces", "pairs of faces")
        ));
    }
    warnings
}

/// Fails if a start surface is in front of no camera.
pub fn check_start(start: &Mesh, shots: &[Shot]) -> Result<()> {
    if shots.iter().all(|shot| reaches_behind(start, shot)) {
        return Err(Error::unsuitable(
            "the start surface reaches behind every camera; give a smaller --start that lies in front of them",
        ));
    }
    Ok(())
}

/// Whether a vertex is not in front of the camera.
fn reaches_behind(mesh: &Mesh, shot: &Shot) -> bool {
    mesh.vertices.iter().any(|&x| shot.view.camera.to_camera(x).z <= 0.0)
}
