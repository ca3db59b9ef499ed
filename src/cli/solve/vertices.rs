//! Labels of vertices for given costs.

use super::given::Given;
use crate::cli::listener::{Found, listening};
use crate::cli::progress::Progress;
use crate::cli::solving::Solving;
use crate::cli::{cut, output, preview, welding};
use crate::error::Result;
use crate::outcome::{self, Labeled};
use crate::request::Request;
use crate::solve::{Summary, solve_seeded};
use crate::start::Start;

/// Solves, writes the folder, and returns the summary with the lines about the cut.
pub fn solve(
    Given { mesh, source, costs, seeds, start, weld }: Given<'_>,
    request: &Request,
    warnings: Vec<String>,
    solving: &Solving,
) -> Result<(Summary, Vec<(&'static str, String)>)> {
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let mut solution = match weld {
        Some(weld) => {
            let weights = request.mass.weights(mesh);
            let start = match start {
                Start::Given(u) => Start::Given(welding::means(weld, &u, &weights)),
                other => other,
            };
            let welded = welding::costs(weld, costs, &weights)?;
            let seeds = seeds.welded(weld)?;
            solve_seeded(&weld.mesh, &welded, &seeds, &start, request, &mut observe)?
        }
        None => solve_seeded(mesh, costs, seeds, &start, request, &mut observe)?,
    };
    progress.finish();
    let contours = cut::traced(weld.map_or(mesh, |weld| &weld.mesh), &mut solution);
    if let Some(weld) = weld {
        solution = solution.spread(mesh, weld);
    }
    solution.summary.warnings.extend(warnings);

    let looks = preview::of_costs(mesh, costs, &solution.labels, solving.view, solving.draws());
    if let Some(out) = &solving.out {
        let written = cut::requested(&contours, solving);
        let labeled = Labeled { source, ..(&solution).into() };
        outcome::write(out, &solution.summary, labeled, mesh, &looks, written, &solving.also)?;
    }
    let of_cut = cut::report(mesh, &solution, &contours, &looks, solving)?;
    let summary = solution.summary.clone();
    listening(|listener| {
        let vertices = solution.labels.clone();
        let summary = output::json(&summary);
        listener.found = Some(Found { summary, vertices, faces: None, solution });
    });
    Ok((summary, of_cut))
}
