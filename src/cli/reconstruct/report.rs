//! What `meshseg reconstruct` prints at the end.

use crate::evolve::{Level, Reconstruction};

use super::arguments::Arguments;
use crate::cli::table;

/// The text that is printed at the end.
pub fn text(found: &Reconstruction, arguments: &Arguments, seconds: f64) -> String {
    let Reconstruction { surface, quality, solution, levels, .. } = found;
    let mut lines = vec![
        ("status", found.end().sentence().to_owned()),
        ("energy", table::number(found.terms.sum())),
        (
            "surface",
            format!(
                "{} vertices, {} faces; folds {}, self-intersections {}",
                surface.mesh.vertices.len(),
                surface.mesh.faces.len(),
                quality.folds.folded_edges,
                quality.folds.intersecting_pairs
            ),
        ),
        (
            "silhouettes",
            format!("agree to {:.4} (those of {})", quality.silhouette_iou, quality.silhouettes),
        ),
        ("unseen", format!("{:.2} % of the area", 100.0 * quality.unseen_share)),
    ];
    if let Some(solution) = solution {
        let summary = &solution.summary;
        lines.push((
            "labels",
            format!("certified gap {:.1e} for this surface", summary.relative_gap),
        ));
    }
    if let Some(distances) = &found.distances {
        let [mean, back, most_of, largest] =
            [distances.mean, distances.back, distances.percentile_95, distances.largest]
                .map(|share| 100.0 * share);
        lines.push((
            "distance",
            format!(
                "{mean:.3} % of the diagonal on average, back {back:.3}, 95 % within {most_of:.3}, largest {largest:.2}"
            ),
        ));
    }
    let of_level = |level: &Level| format!("{} on {} vertices", level.steps, level.vertices);
    lines.push(("steps", levels.iter().map(of_level).collect::<Vec<_>>().join(", ")));
    if let Some(Level { shrunk, .. }) = levels.last().filter(|level| level.shrunk > 1) {
        lines.push((
            "images",
            format!(
                "at 1/{shrunk} of their resolution, which suits this mesh; more --levels use more"
            ),
        ));
    }
    lines.push(("time", format!("{seconds:.1} s")));
    lines.push(("written to", arguments.out.display().to_string()));
    let picture = if arguments.no_preview { "mesh.ply" } else { "views.png" };
    format!("{}\nsee {}\n", table::pairs(&lines), arguments.out.join(picture).display())
}
