//! What must hold between instances, solvers and figures of a file.

use super::super::document::{SpanError, SpanResult};
use super::super::figures::{FigureKind, FigureSpec};
use super::super::grid::Exclusion;
use super::instance::InstanceCell;
use super::solver::{SolverCell, Task};
use crate::data::ModelName;
use crate::domain::Element;
use crate::names::Named;
use crate::render::panels::Shown;
use crate::run::Stop;

/// Runs need an end, except reconstructions, which have their own.
pub fn check_stop(stop: &Stop, solvers: &[SolverCell]) -> SpanResult<()> {
    let has_end = stop.relative_gap.is_some() || stop.iterations.is_some() || stop.time.is_some();
    if has_end || solvers.iter().all(|solver| solver.task.evolution().is_some()) {
        return Ok(());
    }
    Err(SpanError::at(
        &(0..0),
        "runs have no end: give at least one of stop = { gap = ..., max-iterations = ..., time-limit = ... }",
    ))
}

/// Refuses reconstructions on instances that they cannot do, and other solvers on instances that are for reconstructions.
pub fn check_reconstructions(
    instances: &[InstanceCell],
    solvers: &[SolverCell],
    exclusions: &[Exclusion],
) -> SpanResult<()> {
    for instance in instances {
        let included =
            |solver: &&SolverCell| !exclusions.iter().any(|one| covers(one, instance, solver));
        for solver in solvers.iter().filter(included) {
            let problem = match solver.task.evolution() {
                Some(_) => instance.hinders_reconstruction(),
                None => instance.is_for_reconstruction(),
            };
            if let Some((span, message)) = problem {
                let message = format!("{message}; exclude {:?} there", solver.label);
                return Err(SpanError::at(&span, message));
            }
        }
    }
    Ok(())
}

/// Refuses solvers that estimate parameters on instances that are costs.
pub fn check_parameters(
    instances: &[InstanceCell],
    solvers: &[SolverCell],
    exclusions: &[Exclusion],
) -> SpanResult<()> {
    for instance in instances.iter().filter(|cell| cell.data.is_costs()) {
        let own = |solver: &&SolverCell| {
            let excluded = exclusions.iter().any(|one| covers(one, instance, solver));
            let estimates = !solver.task.has_fixed_costs() && solver.task.evolution().is_none();
            estimates && !excluded
        };
        if let Some(solver) = solvers.iter().find(own) {
            let message = format!(
                "{} have no parameters that {:?} could estimate; exclude one of the two, or give data",
                instance.data.noun(),
                solver.label
            );
            return Err(SpanError::at(&instance.data_span, message));
        }
    }
    Ok(())
}

/// Refuses baselines beside other models than theirs, whose energies are not comparable.
pub fn check_baselines(
    instances: &[InstanceCell],
    solvers: &[SolverCell],
    exclusions: &[Exclusion],
) -> SpanResult<()> {
    for instance in instances.iter().filter(|cell| cell.model != ModelName::Constant) {
        let included = |solver: &&SolverCell| {
            let excluded = exclusions.iter().any(|one| covers(one, instance, solver));
            matches!(solver.task, Task::Baseline(_)) && !excluded
        };
        if let Some(solver) = solvers.iter().find(included) {
            let message = format!(
                "{:?} is scored by the model constant, not by {}; exclude it there, or give it an instance of its own",
                solver.label,
                instance.model.name()
            );
            return Err(SpanError::at(&instance.data_span, message));
        }
    }
    Ok(())
}

/// Refuses columns of U in figures of surfaces that runs do not keep: they have labels and their certainty, which give U
/// for two regions only.
pub fn check_columns(figure: &FigureSpec, instances: &[InstanceCell]) -> SpanResult<()> {
    let FigureKind::Surface(surface) = &figure.kind else { return Ok(()) };
    let needs_u = |shown: &&Shown| matches!(shown, Shown::Column(_) | Shown::Uncertainty);
    let on_faces = |cell: &&InstanceCell| {
        cell.on == Element::Faces && figure.selection.has_instance(&cell.label)
    };
    if let (Some(shown), Some(cell)) =
        (surface.show.iter().find(needs_u), instances.iter().find(on_faces))
    {
        let message = format!(
            "{shown} of {:?} cannot be shown: runs on faces keep their labels, not U",
            cell.label
        );
        return Err(SpanError::at(&figure.shown, message));
    }
    let columns = surface.show.iter().filter_map(|shown| match shown {
        Shown::Column(p) => Some(*p),
        _ => None,
    });
    let Some(p) = columns.max() else { return Ok(()) };
    let selected = |cell: &&InstanceCell| figure.selection.has_instance(&cell.label);
    match instances.iter().filter(selected).find(|cell| cell.regions != 2 || p > 1) {
        None => Ok(()),
        Some(cell) => Err(SpanError::at(
            &figure.shown,
            format!(
                "u:{p} of {:?} cannot be shown: runs keep U for two regions only, as u:0 and u:1",
                cell.label
            ),
        )),
    }
}

/// Refuses solvers on faces that need vertices.
pub fn check_faces(
    instances: &[InstanceCell],
    solvers: &[SolverCell],
    exclusions: &[Exclusion],
) -> SpanResult<()> {
    for instance in instances.iter().filter(|cell| cell.on == Element::Faces) {
        for solver in solvers {
            let what = match solver {
                _ if exclusions.iter().any(|one| covers(one, instance, solver)) => continue,
                SolverCell { coarse_to_fine: true, .. } => "goes from coarse to fine",
                SolverCell { thresholds: Some(_), .. } => "has thresholds",
                _ => continue,
            };
            let message = format!(
                "{:?} {what}, which is for labels of vertices only; exclude it here",
                solver.label
            );
            return Err(SpanError::at(&instance.data_span, message));
        }
    }
    Ok(())
}

/// Refuses thresholds of more than two regions.
pub fn check_thresholds(
    instances: &[InstanceCell],
    solvers: &[SolverCell],
    exclusions: &[Exclusion],
) -> SpanResult<()> {
    for instance in instances.iter().filter(|cell| cell.regions > 2) {
        let included = |solver: &&SolverCell| {
            solver.thresholds.is_some()
                && !exclusions.iter().any(|one| covers(one, instance, solver))
        };
        if let Some(solver) = solvers.iter().find(included) {
            let message =
                format!("{:?} has thresholds, which divide two regions only", solver.label);
            return Err(SpanError::at(&instance.data_span, message));
        }
    }
    Ok(())
}

/// Whether an exclusion covers a solver on an instance.
pub fn covers(exclusion: &Exclusion, instance: &InstanceCell, solver: &SolverCell) -> bool {
    exclusion.covers(|key| {
        let own = instance.keys.iter().chain(&solver.keys).find(|(name, _)| name == key);
        own.map(|(_, value)| value.clone())
    })
}
