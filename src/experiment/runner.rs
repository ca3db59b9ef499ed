//! Makes the runs that are missing.

use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Instant, SystemTime};

use ndarray::Array1;

use super::data::{Instance, Places};
use super::external::Attempt;
use super::machine::{LOADED, LoadWatch, Machine, Program};
use super::manifest::Manifest;
use super::plan::{Plan, Planned};
use super::results::Origin;
use super::store::Store;
use crate::error::{Error, Result};
use crate::mesh::io;
use crate::outcome::write_trace;
use crate::run::{Sample, Status, Stop};
use crate::solve::{Request, Solution, solve};
use crate::solver::Method;
use crate::start::Start;
use crate::{file, npy, sweep};

/// What happens on the way.
pub enum Event<'a> {
    /// An instance needs the folder of data.
    Skipped(&'a str),
    /// Run `index` of `all` begins.
    Begins {
        /// Its index in the plan, from 0.
        index: usize,
        /// How many runs the plan has.
        all: usize,
        /// The run.
        run: &'a Planned<'a>,
    },
    /// A step was made, with a sample where one was taken.
    Step(Option<&'a Sample>),
    /// A run is made and written.
    Ended {
        /// The run.
        run: &'a Planned<'a>,
        /// Its result.
        solution: &'a Solution,
    },
    /// Another process is at it.
    Elsewhere(&'a Planned<'a>),
}

/// How a call ended.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Runs made by this call.
    pub made: usize,
    /// Runs that were there before.
    pub there: usize,
    /// Of those that were there, the ones that another machine or program made.
    pub foreign: BTreeMap<Origin, usize>,
    /// Runs that another process is making.
    pub elsewhere: usize,
    /// Whether the observer ended the call.
    pub interrupted: bool,
}

/// Up to so many vertices labels and surfaces are kept for the page.
pub const SHOWN: usize = 60_000;

/// Steps before the clock starts, once for each instance.
const WARM_UP: u64 = 5;

/// Makes what is missing of a plan, or everything if `again`. `observe` may break it off: the run under way is lost,
/// the others stay.
///
/// # Errors
/// Instances that cannot be made, results that cannot be written. Runs that are made stay.
pub fn run(
    plan: &Plan<'_>,
    places: &Places,
    store: &Store,
    program: &Program,
    again: bool,
    observe: &mut (dyn FnMut(Event<'_>) -> ControlFlow<()> + Send),
) -> Result<Tally> {
    let machine = Machine::this();
    let mut load = LoadWatch::new();
    let mut tally = Tally::default();
    for label in &plan.skipped {
        if observe(Event::Skipped(label)).is_break() {
            return Ok(Tally { interrupted: true, ..tally });
        }
    }
    let mut present: Option<(&str, Instance)> = None;
    let mut cold = true;
    for (index, run) in plan.runs.iter().enumerate() {
        if store.has(&run.id) && !again {
            tally.there += 1;
            let origin = Origin::of(&store.run(&run.id))?;
            if !origin.is_here(program, &machine) {
                *tally.foreign.entry(origin).or_default() += 1;
            }
            continue;
        }
        let Some(claim) = store.claim(&run.id, again)? else {
            tally.elsewhere += usize::from(!store.has(&run.id));
            tally.there += usize::from(store.has(&run.id));
            if !store.has(&run.id) && observe(Event::Elsewhere(run)).is_break() {
                return Ok(Tally { interrupted: true, ..tally });
            }
            continue;
        };
        let fresh = present.as_ref().is_none_or(|(id, _)| *id != run.instance_id);
        if fresh {
            // The last one goes before the next one comes.
            drop(present.take());
            let instance = places.instance(run.instance).map_err(|missing| {
                plan.spec.format_error(places.blame(run.instance), Error::from(missing))
            })?;
            show(store, run, &instance)?;
            present = Some((&run.instance_id, instance));
        }
        let (_, instance) = present.as_ref().expect("it was just made");
        if observe(Event::Begins { index, all: plan.runs.len(), run }).is_break() {
            return Ok(Tally { interrupted: true, ..tally });
        }
        cold |= fresh;
        if cold && run.solver.external.is_none() {
            let warm = Stop { iterations: Some(WARM_UP), ..Stop::default() };
            attempt(run, instance, warm, &mut |_| ControlFlow::Continue(()))?;
            cold = false;
        }
        let (start, begin, others) = (SystemTime::now(), Instant::now(), load.others());
        let average = LoadWatch::average();
        let mut step = |sample: Option<&Sample>| observe(Event::Step(sample));
        let stop = &plan.spec.stop;
        let solution = match &run.solver.external {
            None => attempt(run, instance, stop.clone(), &mut step)?,
            Some(external) => {
                let (folder, claimed) = (&places.folder, claim.folder());
                Attempt { run, external, instance, folder, claimed, stop }.make(&mut step)?
            }
        };
        let wall_seconds = begin.elapsed().as_secs_f64();
        if solution.summary.status == Status::Interrupted {
            return Ok(Tally { interrupted: true, ..tally });
        }
        let others = f64::max(others, load.others());
        let manifest = Manifest {
            id: run.id.clone(),
            experiment: plan.spec.name.clone(),
            instance: run.instance.label.clone(),
            instance_id: run.instance_id.clone(),
            solver: run.solver.label.clone(),
            repetition: run.repetition,
            program: program.clone(),
            machine: machine.clone(),
            threads: run.solver.threads.unwrap_or(machine.cores),
            load_average: average,
            others,
            loaded: others > LOADED,
            seed: run.instance.seed,
            generator: "rand_pcg::Pcg64".into(),
            start: humantime::format_rfc3339_millis(start).to_string(),
            end: humantime::format_rfc3339_millis(SystemTime::now()).to_string(),
            mislabeled: instance.truth.as_ref().map(|truth| mislabeled(&solution, truth)),
            wall_seconds,
            exit: match (solution.summary.status, &solution.summary.warnings[..]) {
                (Status::Failed, [why, ..]) => why.clone(),
                _ => solution.summary.status_sentence.into(),
            },
        };
        write(claim.folder(), run, &solution, &manifest)?;
        claim.finish()?;
        tally.made += 1;
        if observe(Event::Ended { run, solution: &solution }).is_break() {
            return Ok(Tally { interrupted: true, ..tally });
        }
    }
    Ok(tally)
}

fn mislabeled(solution: &Solution, truth: &[usize]) -> f64 {
    let labels = solution.labels.iter().zip(truth);
    labels.filter(|(label, truth)| **label as usize != **truth).count() as f64 / truth.len() as f64
}

fn attempt(
    run: &Planned<'_>,
    instance: &Instance,
    stop: Stop,
    observe: &mut (dyn FnMut(Option<&Sample>) -> ControlFlow<()> + Send),
) -> Result<Solution> {
    let request = Request {
        lambda: instance.lambda,
        mass: run.instance.mass,
        method: Method::parse(&run.solver.name, &run.solver.options)?,
        stop,
        coarse_to_fine: run.solver.coarse_to_fine,
        keep_dual: false,
    };
    let solve = || solve(&instance.mesh, &instance.costs, &Start::Argmin, &request, observe);
    sweep::with_threads(run.solver.threads, solve)?
        .map_err(|error| Error::unsuitable(format!("{}: {error}", run.solver.label)))
}

fn write(folder: &Path, run: &Planned<'_>, solution: &Solution, manifest: &Manifest) -> Result<()> {
    let json = |name: &str, value: &dyn Fn(&mut dyn std::io::Write) -> serde_json::Result<()>| {
        file::write(&folder.join(name), |out| {
            value(out)?;
            out.write_all(b"\n")
        })
    };
    file::write(&folder.join("spec.toml"), |out| out.write_all(run.toml.as_bytes()))?;
    write_trace(&folder.join("trace.csv"), &solution.trace)?;
    json("summary.json", &|out| serde_json::to_writer_pretty(out, &solution.summary))?;
    if run.repetition == 0 && solution.labels.len() <= SHOWN {
        let labels: Array1<u8> = solution.labels.iter().map(|&label| label as u8).collect();
        let certainty: Array1<u8> = (solution.u.outer_iter())
            .map(|u| (255.0 * u.iter().fold(0.0, |a: f64, &b| a.max(b))).round() as u8)
            .collect();
        npy::write(&folder.join("labels.npy"), &labels)?;
        npy::write(&folder.join("certainty.npy"), &certainty)?;
    }
    json("manifest.json", &|out| serde_json::to_writer_pretty(out, manifest))
}

/// The surface and its data, once.
fn show(store: &Store, run: &Planned<'_>, instance: &Instance) -> Result<()> {
    let folder = store.folder.join("instances");
    let path = folder.join(format!("{}.ply", run.instance_id));
    if instance.mesh.vertices.len() > SHOWN || path.exists() {
        return Ok(());
    }
    fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, error))?;
    let crate::Mesh { vertices, faces, .. } = instance.mesh.clone();
    // Colors that are not known are gray.
    let known = |color: &[f64; 3]| color.map(|c| if c.is_nan() { 0.5 } else { c });
    let colors = Some(instance.looks.iter().map(known).collect());
    let mesh = crate::Mesh { vertices, faces, colors, ..crate::Mesh::default() };
    io::write(&path, &mesh)
}
