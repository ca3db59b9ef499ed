//! `meshseg reconstruct`: a surface that evolves until it looks like its photographs.

mod arguments;
mod folder;
mod progress;
mod report;
mod warnings;

use std::ops::ControlFlow;

use crate::evolve::shots::Photographs;
use crate::evolve::{End, Event, reconstruct};
use crate::{file, sweep};

use super::{Failure, Outcome, inputs, note, print, warn};
pub use arguments::Arguments;
use folder::Folder;
use progress::Steps;

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.threads.map(usize::from), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    let plan = arguments.plan()?;
    plan.check()?;
    file::check_folder(&arguments.out)?;
    let truth = arguments.truth.as_deref().map(inputs::mesh_with_area).transpose()?;
    let Arguments { views, images, background, regions, .. } = arguments;
    let photographs =
        Photographs::read(views, images.as_deref(), *background, None, usize::from(*regions))?;
    photographs.notes.iter().for_each(|line| note(line));
    let start = arguments.start.mesh(&photographs.shots, inputs::mesh_with_area)?;
    warnings::check_start(&start, &photographs.shots)?;
    let folder = Folder { arguments, photographs: &photographs, plan: &plan };
    let mut steps = Steps::new(&plan);
    let found =
        reconstruct(&photographs.shots, &start, truth.as_ref(), &plan, &mut |event| match event {
            Event::Step(step, _) => Ok(steps.observe(step)),
            Event::Distance(distance) => {
                steps.distance = Some(distance);
                Ok(ControlFlow::Continue(()))
            }
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
    if found.end() == End::Interrupted {
        return Err(Failure::Interrupted);
    }
    Ok(printed?)
}
