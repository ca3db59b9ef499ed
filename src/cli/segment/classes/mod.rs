//! `meshseg segment --probabilities`, `--scores` and `--labels-in`: classes whose probabilities are known.

mod arguments;
mod contrast;
mod input;
mod list;
mod looks;
mod report;

use meshseg::classes::{ClassCosts, ClassLabels, Labeling, label, lambda, most_probable};
use meshseg::contour::{Contours, CutRecord};
use meshseg::domain::Element;
use meshseg::mesh::dual::Dual;
use meshseg::names::Named;
use meshseg::operator::Mass;
use meshseg::relaxation::Relaxation;
use meshseg::solve::Request;
use meshseg::{Error, Result, outcome};
use ndarray::Array2;

use arguments::EdgeAware;
pub use arguments::{ClassArguments, Given};
use input::Input;
use report::{ClassSummary, Classes, report};

use super::arguments::Arguments;
use super::surface::{Surface, of_mesh};
use crate::cli::progress::Progress;
use crate::cli::solving::exit;
use crate::cli::{Outcome, cut, note, print, warn, welding};

pub fn run(arguments: &Arguments, given: &Given) -> Outcome {
    let solving = &arguments.solving;
    let request = solving.request(&arguments.mesh, arguments.lambda.unwrap_or(0.0))?;
    request.check()?;
    if request.mass != Mass::Barycentric {
        let message = "--mass: costs of classes are always integrated by areas; leave it out";
        return Err(Error::unsuitable(message).into());
    }
    let surface = Surface::read(arguments)?;
    let input = Input::read(&surface.mesh, given, &arguments.classes)?;
    input.notes.iter().for_each(|line| note(line));
    let m = input.costs.s.ncols();
    let classes = list::read(arguments.classes.list(), m)?;
    let on = arguments.classes.on().unwrap_or(input.costs.of);
    let relaxation = solving.relaxation.unwrap_or_else(|| Relaxation::for_labels(m));
    let request = Request { relaxation, ..request };
    request.check()?;
    let seeds = surface.seeds(arguments, m, on)?;

    let contrast = arguments.classes.edge_aware();
    let contrast = contrast.map(|choice| contrast::read(choice, &surface)).transpose()?;
    let cleaning = arguments.classes.cleaning(&surface.scaled, surface.scale);

    let costs = welded(&surface, &input)?;
    let s = costs.on(on, &surface.scaled);
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let lambda = match arguments.lambda {
        Some(lambda) => lambda,
        None => {
            let given = (&costs.s, costs.of);
            lambda::of_costs(&surface.scaled, given, &request, &mut observe)?
        }
    };
    let request = Request { lambda, ..request };
    let labeling = Labeling { on, contrast: contrast.as_ref(), seeds: &seeds, cleaning };
    let found = label(&surface.scaled, &s, &labeling, &request, &mut observe)?;
    progress.finish();

    let ClassLabels { mut solution, vertices, faces, cleaned } = found;
    let welded_mesh = surface.welded();
    let contours = match on {
        Element::Vertices => cut::traced(welded_mesh, &mut solution),
        Element::Faces => {
            let contours = Contours::between_faces(welded_mesh, faces.view());
            let record = CutRecord::of_faces(welded_mesh, &contours, faces.view(), m);
            solution.summary.cut = Some(record);
            contours
        }
    };
    let warnings = &mut solution.summary.warnings;
    warnings.extend(input.warnings.iter().cloned());
    warnings.extend(of_mesh(&surface, arguments));
    warnings.extend(one_class_everywhere(&s));
    let classes = match on {
        Element::Vertices => Classes::of(classes, &vertices, &s, (&surface.scaled).into()),
        Element::Faces => Classes::of(classes, &faces, &s, (&Dual::new(&surface.scaled)).into()),
    };
    let mut found = ClassLabels { solution, vertices, faces, cleaned };
    if let Some(weld) = &surface.weld {
        found.vertices = weld.of.iter().map(|&v| found.vertices[v as usize]).collect();
        found.solution = match on {
            Element::Vertices => found.solution.spread(&surface.mesh, weld),
            Element::Faces => found.solution,
        };
        found.solution.summary.vertices = surface.mesh.vertices.len();
    }
    let split = (on == Element::Faces).then(|| {
        let labels: Vec<u8> = found.faces.iter().map(|&p| p as u8).collect();
        surface.mesh.split(&labels)
    });
    let looks = looks::looks(&classes, &input.costs, &surface, split.as_ref(), solving);
    let summary = ClassSummary {
        summary: &found.solution.summary,
        data: &input.name,
        model: "classes",
        data_on: input.costs.of.nouns()[1],
        floor: given.floor(&arguments.classes),
        confidence: given.confidence(&arguments.classes),
        unknown_rows: input.unknown,
        edge_aware: arguments.classes.edge_aware().map(EdgeAware::name),
        cleaned: found.cleaned.as_ref(),
        welded_vertices: surface.weld.as_ref().map_or(0, |weld| weld.merged),
        lambda_chosen: arguments.lambda.is_none(),
        seeds: seeds.count(),
        normalize: arguments.normalize.name(),
        scale: surface.scale,
        relabeled_share: classes.relabeled_share,
        region_parameters: &classes.all,
    };
    let labeled = outcome::Labeled {
        solution: &found.solution,
        vertices: &found.vertices,
        faces: Some(&found.faces),
        drawn: split.as_ref(),
    };
    let written = cut::requested(&contours, solving);
    outcome::write(&solving.out, &summary, labeled, &surface.mesh, &looks, written)?;
    let of_cut = match on {
        Element::Vertices => {
            cut::report(&surface.mesh, &found.solution, &contours, &looks, solving)?
        }
        Element::Faces => {
            cut::report_of_faces(&surface.mesh, &found.faces, &contours, &looks, solving)?
        }
    };
    surface.report(arguments);
    warn(&found.solution.summary.warnings);
    let printed = print(&report(&found, &classes, &input, on, of_cut, arguments));
    exit(found.solution.summary.status, printed)
}

/// The costs on the welded mesh.
fn welded(surface: &Surface, input: &Input) -> Result<ClassCosts> {
    let ClassCosts { s, of } = &input.costs;
    let s = match (&surface.weld, of) {
        (Some(weld), Element::Vertices) => {
            let weights = Mass::Barycentric.weights(&surface.mesh);
            welding::costs(weld, s, &weights)?
        }
        _ => s.clone(),
    };
    Ok(ClassCosts { s, of: *of })
}

/// A warning if the costs leave nothing to decide.
fn one_class_everywhere(s: &Array2<f64>) -> Option<String> {
    let mut known = s.outer_iter().filter(|row| !row[0].is_nan()).map(most_probable);
    let first = known.next()?;
    known.all(|p| p == first).then(|| {
        format!("class {first} is the most probable one everywhere, so there is nothing to cut; check the columns")
    })
}
