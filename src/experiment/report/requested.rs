//! The figures and tables that a report has.

use super::super::figures::{
    Clock, FigureKind, FigureSpec, Measure, Selection, TableKind, TableSpec, Target,
};
use super::super::spec::Spec;
use super::super::variable::{Quantity, Variable};

/// Those of the file. By default decay over both clocks, and the times to gaps; of surfaces, which have no gaps, the energy
/// over both clocks, and the main numbers.
pub fn requested(spec: &Spec) -> (Vec<FigureSpec>, Vec<TableSpec>) {
    let of_surfaces = spec.solvers.iter().all(|solver| solver.task.evolution().is_some());
    let y = if of_surfaces { Measure::Energy } else { Measure::Suboptimality };
    let counter = if of_surfaces { Clock::Steps } else { Clock::Iterations };
    let decay = |x: Clock| FigureSpec {
        name: format!("decay-{}", x.label()),
        title: None,
        kind: FigureKind::Decay { x, y },
        page: true,
        columns: 2,
        selection: Selection::default(),
        caption: None,
        shown: 0..0,
    };
    let figures = match &spec.figures[..] {
        [] => vec![decay(counter), decay(Clock::Seconds)],
        figures => figures.to_vec(),
    };
    let table = |name: &str, kind: TableKind| TableSpec {
        name: name.into(),
        title: None,
        kind,
        selection: Selection::default(),
        without: Vec::new(),
    };
    let tables = match &spec.tables[..] {
        [] if of_surfaces => {
            let columns = [
                Quantity::Steps,
                Quantity::Seconds,
                Quantity::Energy,
                Quantity::SilhouetteIou,
                Quantity::Distance,
                Quantity::Mislabeled,
            ];
            let columns = columns.into_iter().map(Variable::Quantity).collect();
            vec![table("surfaces", TableKind::Cells { columns })]
        }
        [] => {
            let gaps = vec![1e-2, 1e-3, 1e-4];
            vec![table(
                "time-to-gap",
                TableKind::TimeToGap {
                    gaps,
                    to: Target::Certificate,
                    clocks: vec![Clock::Iterations, Clock::Seconds],
                },
            )]
        }
        tables => tables.to_vec(),
    };
    (figures, tables)
}
