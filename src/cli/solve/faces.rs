//! Labels of faces for given costs.

use super::given::Given;
use crate::classes::carry::labels_of_vertices;
use crate::classes::without_evidence;
use crate::cli::listener::{Found, listening};
use crate::cli::output::json;
use crate::cli::progress::Progress;
use crate::cli::solving::Solving;
use crate::cli::{cut, preview};
use crate::contour::{Contours, CutRecord};
use crate::error::Result;
use crate::outcome::{self, Drawn, Labeled};
use crate::request::Request;
use crate::solve::{Summary, solve_on_faces};

/// Solves, writes the folder, and returns the summary with the lines about the cut.
pub fn solve(
    Given { mesh, source, costs, seeds, start, weld }: &Given<'_>,
    request: &Request,
    warnings: Vec<String>,
    solving: &Solving,
) -> Result<(Summary, Vec<(&'static str, String)>)> {
    let welded = weld.map_or(*mesh, |weld| &weld.mesh);
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let mut solution = solve_on_faces(welded, None, costs, seeds, start, request, &mut observe)?;
    progress.finish();
    let m = costs.ncols();
    let contours = Contours::between_faces(welded, solution.labels.view());
    let record = CutRecord::of_faces(welded, &contours, solution.labels.view(), m);
    let summary = &mut solution.summary;
    summary.cut = Some(record);
    summary.vertices = mesh.vertices.len();
    summary.warnings.extend(warnings);
    summary.warnings.extend(without_evidence(mesh));

    let faces = &solution.labels;
    let vertices = labels_of_vertices(mesh, faces, m);
    let (looks, picture) =
        preview::of_costs_of_faces(mesh, costs, faces, solving.view, solving.draws());
    if let Some(out) = &solving.out {
        let drawn = picture.as_ref().map(|(mesh, u)| Drawn { mesh, u });
        let labeled = Labeled {
            solution: &solution,
            vertices: &vertices,
            faces: Some(faces),
            drawn,
            source: *source,
        };
        let written = cut::requested(&contours, solving);
        outcome::write(out, &solution.summary, labeled, mesh, &looks, written, &solving.also)?;
    }
    let of_cut = cut::report_of_faces(mesh, faces, &contours, &looks, solving)?;
    let summary = solution.summary.clone();
    listening(|listener| {
        let faces = Some(solution.labels.clone());
        listener.found = Some(Found { summary: json(&summary), vertices, faces, solution });
    });
    Ok((summary, of_cut))
}
