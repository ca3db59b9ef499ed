//! `meshseg reconstruct`: a surface that evolves until it looks like its photographs.

mod arguments;
mod folder;
mod progress;
mod report;
mod shots;
mod start;

use std::ops::ControlFlow;

use meshseg::evolve::{End, Event, Reconstruction, reconstruct};
use meshseg::{file, sweep};

pub use arguments::Arguments;
use folder::Folder;
use progress::Steps;
use shots::Photographs;

use super::{Failure, Outcome, inputs, note, print, warn};

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.threads.map(usize::from), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    let plan = arguments.plan()?;
    plan.check()?;
    file::check_folder(&arguments.out)?;
    let truth = arguments.truth.as_deref().map(inputs::mesh_with_area).transpose()?;
    let photographs = Photographs::read(arguments)?;
    photographs.notes.iter().for_each(|line| note(line));
    let start = start::mesh(&arguments.start, &photographs)?;
    let folder = Folder { arguments, photographs: &photographs, plan: &plan };
    let mut steps = Steps::new(&plan);
    let found =
        reconstruct(&photographs.shots, &start, truth.as_ref(), &plan, &mut |event| match event {
            Event::Step(step, distance) => Ok(steps.observe(step, distance)),
            Event::Labels => Ok(steps.interrupted()),
            Event::Level(found) => {
                folder.write(found, steps.seconds())?;
                Ok(ControlFlow::Continue(()))
            }
        })
        .map_err(|error| error.of_file(&arguments.views))?;
    steps.finish();
    let warnings = folder.write(&found, steps.seconds())?;
    warn(&photographs.warnings);
    warn(&warnings);
    let printed = print(&report::text(&found, arguments, steps.seconds()));
    if ended(&found) == End::Interrupted {
        return Err(Failure::Interrupted);
    }
    Ok(printed?)
}

/// How the last level ended.
fn ended(found: &Reconstruction) -> End {
    found.levels.last().map_or(End::StepLimit, |level| level.end)
}
