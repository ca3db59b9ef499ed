//! `meshseg segment --probabilities`, `--property`, `--scores` and `--labels-in`: classes whose probabilities are
//! known.

mod arguments;
mod contrast;
mod input;
mod list;
mod looks;
mod mask;
mod prepared;
mod report;

use crate::classes::{ClassLabels, Labeling, label, lambda, without_evidence};
use crate::contour::{Contours, CutRecord};
use crate::domain::Element;
use crate::mesh::dual::Dual;
use crate::names::Named;
use crate::operator::Mass;
use crate::outcome::{self, Drawn, Labeled};
use crate::relaxation::Relaxation;
use crate::run::Status;
use crate::solve::Request;
use crate::{Error, Result};

use super::arguments::Arguments;
use super::surface::of_mesh;
use crate::cli::listener::{Found, listening};
use crate::cli::output::json;
use crate::cli::progress::Progress;
use crate::cli::solving::exit;
use crate::cli::{Outcome, cut, note, print, warn};
use arguments::EdgeAware;
pub use arguments::{ClassArguments, Given};
use looks::Picture;
use prepared::Prepared;
use report::{ClassSummary, Classes, report};

pub fn run(arguments: &Arguments, given: &Given) -> Outcome {
    let request = request(arguments)?;
    let prepared = Prepared::read(arguments, given)?;
    prepared.input.notes.iter().for_each(|line| note(line));
    let mut found = labeled(&prepared, arguments, request)?;
    let contours = traced(&prepared, &mut found);
    let classes = {
        let Prepared { surface, s, on, list, .. } = &prepared;
        match on {
            Element::Vertices => Classes::of(list, &found.vertices, s, (&surface.scaled).into()),
            Element::Faces => {
                Classes::of(list, &found.faces, s, (&Dual::new(&surface.scaled)).into())
            }
        }
    };
    let found = on_file(&prepared, found);
    write(&prepared, found, &classes, &contours, arguments, given)
}

fn request(arguments: &Arguments) -> Result<Request> {
    let solving = &arguments.solving;
    let request = solving.request(&arguments.mesh, arguments.lambda.unwrap_or(0.0))?;
    request.check()?;
    arguments.views.options(None)?;
    if request.mass != Mass::Barycentric {
        let message = "--mass: costs of classes are always integrated by areas; leave it out";
        return Err(Error::unsuitable(message));
    }
    Ok(request)
}

/// Labels of the welded and scaled mesh of what counts; chooses lambda for the costs if none is given.
fn labeled(prepared: &Prepared, arguments: &Arguments, request: Request) -> Result<ClassLabels> {
    let Prepared { surface, costs, s, on, metric, seeds, contrast, .. } = prepared;
    let relaxation = metric.or(arguments.solving.relaxation);
    let relaxation = relaxation.unwrap_or_else(|| Relaxation::for_labels(s.ncols()));
    let request = Request { relaxation, ..request };
    request.check()?;
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let chosen = match arguments.lambda {
        Some(lambda) => Some(lambda),
        None => {
            let given = (&costs.s, costs.of);
            lambda::of_costs(&surface.scaled, given, *on, &request, &mut observe)?
        }
    };
    let lambda = chosen.unwrap_or(0.0);
    let request = Request { lambda, ..request };
    let cleaning = arguments.classes.cleaning(&surface.scaled, surface.scale);
    let labeling = Labeling { on: *on, contrast: contrast.as_ref(), seeds, cleaning };
    let mut found = label(&surface.scaled, s, &labeling, &request, &mut observe)?;
    progress.finish();
    let warnings = &mut found.solution.summary.warnings;
    if chosen.is_none() {
        warnings.push("the search for lambda was interrupted, so it is 0: each label is the most probable one".into());
    }
    warnings.extend(prepared.input.warnings.iter().cloned());
    warnings.extend(of_mesh(surface, arguments));
    if *on == Element::Faces {
        // Of the whole mesh: vertices that the mask leaves out have faces.
        warnings.extend(without_evidence(&prepared.mask.whole));
    }
    warnings.extend(prepared.one_class_everywhere());
    Ok(found)
}

/// The cut in the units of the file, whose numbers are added to the summary.
fn traced(prepared: &Prepared, found: &mut ClassLabels) -> Contours {
    let welded = prepared.surface.welded();
    match prepared.on {
        Element::Vertices => {
            with_shown_rows(found, |found| cut::traced(welded, &mut found.solution))
        }
        Element::Faces => {
            let contours = Contours::between_faces(welded, found.faces.view());
            let m = prepared.s.ncols();
            let record = CutRecord::of_faces(welded, &contours, found.faces.view(), m);
            found.solution.summary.cut = Some(record);
            contours
        }
    }
}

/// Calls a function while U agrees with labels of vertices that were cleaned, whose rows become those of the labels.
fn with_shown_rows<T>(found: &mut ClassLabels, call: impl FnOnce(&mut ClassLabels) -> T) -> T {
    let changed = found.cleaned.is_some_and(|cleaned| cleaned.parts > 0);
    if !changed || found.solution.summary.on.is_some() {
        return call(found);
    }
    let mut shown = found.solution.u.clone();
    for (mut row, &label) in shown.outer_iter_mut().zip(&found.solution.labels) {
        let label = label as usize;
        if row.iter().any(|u| *u > row[label]) {
            row.fill(0.0);
            row[label] = 1.0;
        }
    }
    let u = std::mem::replace(&mut found.solution.u, shown);
    let result = call(found);
    found.solution.u = u;
    result
}

/// The labels on the vertices of the file and the faces that count.
fn on_file(prepared: &Prepared, mut found: ClassLabels) -> ClassLabels {
    let Prepared { surface, on, .. } = prepared;
    if let Some(weld) = &surface.weld {
        found.vertices = weld.of.iter().map(|&v| found.vertices[v as usize]).collect();
        if *on == Element::Vertices {
            found.solution = found.solution.spread(&surface.mesh, weld);
        }
    }
    found
}

/// Writes the folder and prints the report.
fn write(
    prepared: &Prepared,
    mut found: ClassLabels,
    classes: &Classes,
    contours: &Contours,
    arguments: &Arguments,
    given: &Given,
) -> Outcome {
    let Prepared { surface, mask, input, on, .. } = prepared;
    let solving = &arguments.solving;
    let (picture, looks, of_cut) = with_shown_rows(&mut found, |found| -> Result<_> {
        let draw = || Picture::new(prepared, found, &found.solution.u, classes);
        let picture = solving.draws().then(draw);
        let looks = looks::looks(classes, picture.as_ref(), input.costs.of, solving);
        let of_cut = match on {
            Element::Vertices => {
                cut::report(&surface.mesh, &found.solution, contours, &looks, solving)?
            }
            Element::Faces => {
                cut::report_of_faces(&surface.mesh, &found.faces, contours, &looks, solving)?
            }
        };
        Ok((picture, looks, of_cut))
    })?;
    found.vertices = mask.all_vertices(found.vertices);
    found.faces = mask.all_faces(&found.faces);
    let solution = &mut found.solution;
    solution.u = mask.all_rows(std::mem::take(&mut solution.u), *on);
    solution.summary.vertices = mask.whole.vertices.len();
    solution.summary.faces = mask.whole.faces.len();
    let summary = ClassSummary {
        summary: &found.solution.summary,
        data: &input.name,
        model: "classes",
        data_on: input.costs.of.nouns()[1],
        floor: given.floor(&arguments.classes),
        confidence: given.confidence(&arguments.classes),
        unknown_rows: input.unknown,
        left_out_faces: mask.left_out(),
        edge_aware: arguments.classes.edge_aware().map(EdgeAware::name),
        cleaned: found.cleaned.as_ref(),
        welded_vertices: surface.weld.as_ref().map_or(0, |weld| weld.merged),
        lambda_chosen: arguments.lambda.is_none()
            && found.solution.summary.status != Status::Interrupted,
        seeds: prepared.seeds.count(),
        normalize: arguments.normalize.name(),
        scale: surface.scale,
        relabeled_share: classes.relabeled_share,
        region_parameters: &classes.all,
    };
    let drawn = picture.as_ref().map(|picture| Drawn { mesh: picture.mesh(), u: picture.u() });
    let labeled = Labeled {
        solution: &found.solution,
        vertices: &found.vertices,
        faces: Some(&found.faces),
        drawn,
        source: arguments.memory.file(&arguments.mesh),
    };
    if let Some(out) = &solving.out {
        let written = cut::requested(contours, solving);
        outcome::write(out, &summary, labeled, &mask.whole, &looks, written, &solving.also)?;
    }
    surface.report(arguments);
    if mask.left_out() > 0 {
        note(&format!(
            "{} of {} faces are left out by the mask",
            mask.left_out(),
            mask.whole.faces.len()
        ));
    }
    warn(&found.solution.summary.warnings);
    let printed = print(&report(&found, classes, input, *on, of_cut, arguments));
    let (status, summary) = (found.solution.summary.status, json(&summary));
    listening(|listener| {
        let ClassLabels { solution, vertices, faces, .. } = found;
        listener.found = Some(Found { summary, solution, vertices, faces: Some(faces) });
    });
    exit(status, printed)
}
