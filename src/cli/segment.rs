//! `meshseg segment`: segments the data on a mesh into regions.

mod arguments;
mod classes;
mod found;
mod report;
mod summary;
mod surface;

use std::path::Path;

use crate::data::input::InputData;
use crate::data::{LitSurface, ModelName, Observed};
use crate::labeling::{Labeler, Labeling, count_regions, label};
use crate::mesh::geometry::barycentric_areas;
use crate::operator::Mass;
use crate::outcome::{self, Labeled};
use crate::relaxation::Relaxation;
use crate::seeds::Seeds;
use crate::segment::Alternation;
use crate::segment::count::{self, Count};
use crate::solve::Request;
use crate::{Error, Result};

use super::listener::{self, listening, with_threads};
use super::output::json;
use super::progress::Progress;
use super::solving::exit;
use super::views::ViewSummary;
use super::{Outcome, cut, note, one_line, print, views, warn};
pub use arguments::Arguments;
use arguments::Regions;
use found::{Found, describe_regions};
use report::{looks, report};
use summary::{SegmentSummary, summary};
use surface::{Surface, warnings};

pub fn run(arguments: &Arguments) -> Outcome {
    with_threads(arguments.solving.threads(), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    if let Some(given) = arguments.classes.given(&arguments.mesh) {
        return classes::run(arguments, &given);
    }
    arguments.classes.check_unused()?;
    let solving = &arguments.solving;
    if solving.pairs.is_some() {
        return Err(Error::unsuitable(
            "--pairs weights classes that are known before: supply --probabilities, --property, --scores or --labels-in",
        )
        .into());
    }
    let request = solving.request(&arguments.mesh, arguments.lambda.unwrap_or(0.0))?;
    request.check()?;
    let labeler = arguments.labeler()?;
    let illumination = arguments.lighting.illumination(&labeler)?;
    views::check(arguments.data.as_ref(), &request)?;
    let surface = Surface::read(arguments)?;
    let input = surface.input(arguments)?;
    input.notes.iter().for_each(|line| note(&one_line(line)));
    views::note_means(&input, &labeler);
    let (normals, turned) = surface.normals(&labeler);
    let lit = Some(LitSurface { normals: &normals, illumination });
    let observed = Observed { lit, ..input.observed() };

    let (regions, counts) = region_count(arguments, &labeler, &surface, observed, request.mass)?;
    let relaxation = solving.relaxation.unwrap_or_else(|| Relaxation::for_labels(regions));
    let request = Request { relaxation, ..request };
    request.check()?;
    let seeds = surface.seeds(arguments, regions)?;
    let seed_vertices = seeds.count();
    let labeling = labeled(&surface, observed, &labeler, regions, seeds, arguments, &request)
        .map_err(|error| error.of_file(Path::new(&input.name)))?;
    let regions = describe_regions(&labeling, &input, &barycentric_areas(&surface.scaled));
    let Labeling { solution, value_name, estimates, .. } = labeling;
    let mut found = Found { solution, regions, value_name, estimates, seed_vertices, counts };
    let lambda = found.solution.summary.lambda;
    found.solution.summary.warnings.extend(warnings(&surface, &input, arguments));
    found.solution.summary.warnings.extend(mapped_data(&input, &labeler));
    found.solution.summary.warnings.extend(turned.into_iter().chain(found.barely_lit()));
    let views = ViewSummary::of(&found.solution, &input, &surface.scaled, &arguments.views);
    let contours = cut::traced(surface.welded(), &mut found.solution);
    if let Some(weld) = &surface.weld {
        found.solution = found.solution.spread(&surface.mesh, weld);
    }
    let summary =
        SegmentSummary { views, ..summary(&found, &surface, &input, &labeler, arguments) };
    let looks = looks(&found, &surface, &input, arguments);
    if let Some(out) = &solving.out {
        let written = cut::requested(&contours, solving);
        let source = arguments.memory.file(&arguments.mesh);
        let labeled = Labeled { source, ..(&found.solution).into() };
        outcome::write(out, &summary, labeled, &surface.mesh, &looks, written, &solving.also)?;
    }
    let of_cut = cut::report(&surface.mesh, &found.solution, &contours, &looks, solving)?;

    surface.report(arguments);
    warn(&found.solution.summary.warnings);
    let printed = print(&report(&found, &input, lambda, &labeler, of_cut, arguments));
    let (status, summary) = (found.solution.summary.status, json(&summary));
    listening(|listener| {
        let vertices = found.solution.labels.clone();
        let solution = found.solution;
        listener.found = Some(listener::Found { summary, solution, vertices, faces: None });
    });
    exit(status, printed)
}

/// m, and what was tried for it.
fn region_count(
    arguments: &Arguments,
    labeler: &Labeler,
    surface: &Surface,
    observed: Observed<'_>,
    mass: Mass,
) -> Result<(usize, Vec<Count>)> {
    let numbers = match (labeler, &arguments.regions) {
        (Labeler::Given(_, parameters), _) => return Ok((parameters.len(), Vec::new())),
        (_, None) => return Ok((arguments.thresholds.len() + 1, Vec::new())),
        (_, Some(Regions::Number(m))) => return Ok((*m, Vec::new())),
        (_, Some(Regions::Auto(numbers))) => numbers.clone(),
    };
    if let Some(path) = &arguments.seeds {
        let message = "seeds name regions by numbers, so --regions must be a number";
        return Err(Error::unsuitable(message).of_file(path));
    }
    let model = match labeler {
        Labeler::Estimated(model) | Labeler::Given(model, _) => *model,
        Labeler::Baseline(_) => ModelName::Constant,
    };
    let counts = count_regions(&surface.scaled, observed, model, numbers, mass, arguments.seed)?;
    Ok((count::best(&counts), counts))
}

/// Labels the data by the method that the arguments name; chooses lambda for them if none is given.
fn labeled(
    surface: &Surface,
    observed: Observed<'_>,
    labeler: &Labeler,
    regions: usize,
    seeds: Seeds,
    arguments: &Arguments,
    request: &Request,
) -> Result<Labeling> {
    let alternation = Alternation {
        regions,
        initial: arguments.init,
        seed: arguments.seed,
        every: arguments.every,
        labels: None,
        seeds,
    };
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let (mesh, lambda) = (&surface.scaled, arguments.lambda);
    let labeling = label(mesh, observed, labeler, &alternation, lambda, request, &mut observe)?;
    progress.finish();
    Ok(labeling)
}

/// Given parameters are in the units of the data as they are segmented, which may depend on the mesh.
fn mapped_data(input: &InputData, labeler: &Labeler) -> Option<String> {
    let (Labeler::Given(..), Some(range)) = (labeler, &input.unit_range) else { return None };
    let [low, high] = range.ends;
    Some(format!(
        "the given means refer to data from 0 to 1, to which {low:.3e} and {high:.3e} are mapped on this mesh; means of \
         another mesh have other units"
    ))
}
