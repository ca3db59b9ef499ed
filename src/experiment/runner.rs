//! Makes the missing runs of a plan.

use std::collections::BTreeMap;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Instant, SystemTime};

use ndarray::Array1;

use super::external::Attempt;
use super::folders::Folders;
use super::instance::Instance;
use super::labeled::{self, Made};
use super::machine::{LoadWatch, Machine, Program, TOLERATED_LOAD};
use super::manifest::Manifest;
use super::plan::{Plan, Planned};
use super::results::Origin;
use super::spec::Task;
use super::store::{Claim, MAX_KEPT_VERTICES, Store};
use crate::contour::cut_length;
use crate::error::{Error, Result};
use crate::mesh::io;
use crate::outcome::write_trace;
use crate::run::{Sample, Status, Stop};
use crate::solve::Solution;
use crate::{file, npy};

/// The progress of a call.
pub enum Event<'a> {
    /// An instance is skipped since it needs the data folder.
    Skipped(&'a str),
    /// Run `index` of `all` begins.
    Begins {
        /// Its index in the plan, from 0.
        index: usize,
        /// Number of runs of the plan.
        all: usize,
        /// The run.
        run: &'a Planned<'a>,
    },
    /// A step was made, perhaps with a sample.
    Step(Option<&'a Sample>),
    /// A run is made and written.
    Ended {
        /// The run.
        run: &'a Planned<'a>,
        /// Its result.
        solution: &'a Solution,
    },
    /// Another process is making the run.
    Elsewhere(&'a Planned<'a>),
}

/// The outcome of a call.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of runs made by this call.
    pub made: usize,
    /// Number of runs that were already done.
    pub there: usize,
    /// Those among them that another machine or program made.
    pub foreign: BTreeMap<Origin, usize>,
    /// Number of runs that another process is making.
    pub elsewhere: usize,
    /// Whether the observer ended the call.
    pub interrupted: bool,
}

/// Steps before the first timed run on each instance.
const WARM_UP_STEPS: u64 = 5;

pub type EventObserver<'a> = &'a mut (dyn FnMut(Event<'_>) -> ControlFlow<()> + Send);

/// Makes the missing runs of a plan, or all if `again`. If `observe` breaks, the current run is lost; finished ones
/// stay.
///
/// # Errors
/// An instance cannot be made, or results cannot be written. Finished runs stay.
pub fn run(
    plan: &Plan<'_>,
    folders: &Folders,
    store: &Store,
    program: &Program,
    again: bool,
    observe: EventObserver<'_>,
) -> Result<Tally> {
    let mut runner = Runner {
        plan,
        folders,
        store,
        program,
        machine: Machine::this(),
        load: LoadWatch::new(),
        current: None,
        tally: Tally::default(),
    };
    let interrupted = runner.make_all(again, observe)?.is_break();
    Ok(Tally { interrupted, ..runner.tally })
}

struct Runner<'a> {
    plan: &'a Plan<'a>,
    folders: &'a Folders,
    store: &'a Store,
    program: &'a Program,
    machine: Machine,
    load: LoadWatch,
    current: Option<Current<'a>>,
    tally: Tally,
}

/// The instance of the current run; only one is in memory.
struct Current<'a> {
    id: &'a str,
    instance: Instance,
    /// Whether a built-in solver has run on it.
    is_warm: bool,
}

/// A solution with the measurements of its run.
struct Timed {
    made: Made,
    start: SystemTime,
    wall_seconds: f64,
    load_average: f64,
    /// Cores that other processes kept busy.
    others: f64,
}

impl<'a> Runner<'a> {
    fn make_all(&mut self, again: bool, observe: EventObserver<'_>) -> Result<ControlFlow<()>> {
        let Runner { plan, store, .. } = *self;
        for label in &plan.skipped {
            if observe(Event::Skipped(label)).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        for (index, run) in plan.runs.iter().enumerate() {
            if store.has(&run.id) && !again {
                self.count_present(run)?;
                continue;
            }
            let flow = match store.claim(&run.id, again)? {
                Some(claim) => self.make(index, run, claim, observe)?,
                None if store.has(&run.id) => {
                    self.tally.there += 1;
                    ControlFlow::Continue(())
                }
                None => {
                    self.tally.elsewhere += 1;
                    observe(Event::Elsewhere(run))
                }
            };
            if flow.is_break() {
                return Ok(flow);
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn count_present(&mut self, run: &Planned<'_>) -> Result<()> {
        self.tally.there += 1;
        let origin = Origin::of(&self.store.run(&run.id))?;
        if !origin.is_here(self.program, &self.machine) {
            *self.tally.foreign.entry(origin).or_default() += 1;
        }
        Ok(())
    }

    /// Makes one run and writes its files.
    fn make(
        &mut self,
        index: usize,
        run: &'a Planned<'a>,
        claim: Claim,
        observe: EventObserver<'_>,
    ) -> Result<ControlFlow<()>> {
        self.bring_instance(run)?;
        let begins = observe(Event::Begins { index, all: self.plan.runs.len(), run });
        if begins.is_break() {
            return Ok(begins);
        }
        self.warm_up(run)?;
        let timed = self.timed(run, claim.folder(), observe)?;
        if timed.made.solution.summary.status == Status::Interrupted {
            return Ok(ControlFlow::Break(()));
        }
        let manifest = self.manifest(run, &timed)?;
        write(claim.folder(), run, &timed.made.solution, &manifest)?;
        claim.finish()?;
        self.tally.made += 1;
        Ok(observe(Event::Ended { run, solution: &timed.made.solution }))
    }

    fn bring_instance(&mut self, run: &'a Planned<'a>) -> Result<()> {
        if self.current.as_ref().is_some_and(|current| current.id == run.instance_id) {
            return Ok(());
        }
        // Frees the previous instance before the next one is made.
        self.current = None;
        let instance = self.folders.instance(run.instance).map_err(|missing| {
            self.plan.spec.format_error(self.folders.blame(run.instance), Error::from(missing))
        })?;
        keep_surface(self.store, run, &instance)?;
        self.current = Some(Current { id: &run.instance_id, instance, is_warm: false });
        Ok(())
    }

    fn warm_up(&mut self, run: &Planned<'_>) -> Result<()> {
        let current = self.current.as_mut().expect("its instance is there");
        if !current.is_warm && matches!(run.solver.task, Task::Solve | Task::Segment(_)) {
            let stop = Stop { iterations: Some(WARM_UP_STEPS), ..Stop::default() };
            labeled::attempt(run, &current.instance, stop, &mut |_| ControlFlow::Continue(()))?;
            current.is_warm = true;
        }
        Ok(())
    }

    /// `claimed` is the folder in which the run is made.
    fn timed(
        &mut self,
        run: &Planned<'_>,
        claimed: &Path,
        observe: EventObserver<'_>,
    ) -> Result<Timed> {
        let instance = &self.current.as_ref().expect("its instance is there").instance;
        let (folder, stop) = (&self.folders.folder, &self.plan.spec.stop);
        let (start, begin, others) = (SystemTime::now(), Instant::now(), self.load.others());
        let load_average = LoadWatch::average();
        let mut step = |sample: Option<&Sample>| observe(Event::Step(sample));
        let iterations = run.solver.max_iterations.or(stop.iterations);
        let stop = &Stop { iterations, ..stop.clone() };
        let made = match run.solver.task.external() {
            None => labeled::attempt(run, instance, stop.clone(), &mut step)?,
            Some(external) => {
                let attempt = Attempt { run, external, instance, folder, claimed, stop };
                Made::of(attempt.make(&mut step)?)
            }
        };
        let wall_seconds = begin.elapsed().as_secs_f64();
        let others = f64::max(others, self.load.others());
        Ok(Timed { made, start, wall_seconds, load_average, others })
    }

    fn manifest(&self, run: &Planned<'_>, timed: &Timed) -> Result<Manifest> {
        let Timed { made, start, wall_seconds, load_average, others } = timed;
        let instance = &self.current.as_ref().expect("its instance is there").instance;
        let Made { solution, parameters, level_sets } = made;
        let scores = labeled::scores(run, instance, solution)?;
        Ok(Manifest {
            id: run.id.clone(),
            experiment: self.plan.spec.name.clone(),
            instance: run.instance.label.clone(),
            instance_id: run.instance_id.clone(),
            solver: run.solver.label.clone(),
            repetition: run.repetition,
            program: self.program.clone(),
            machine: self.machine.clone(),
            threads: run.solver.threads.unwrap_or(self.machine.cores),
            load_average: *load_average,
            others: *others,
            loaded: *others > TOLERATED_LOAD,
            seed: run.instance.seed,
            generator: "rand_pcg::Pcg64".into(),
            start: humantime::format_rfc3339_millis(*start).to_string(),
            end: humantime::format_rfc3339_millis(SystemTime::now()).to_string(),
            mislabeled: scores.as_ref().map(|scores| scores.mislabeled),
            scores: scores.map(|scores| scores.others),
            cut_length: Some(cut_length(&instance.mesh, solution.labels.view())),
            binary: Some(binary(solution)),
            parameters: parameters.clone(),
            level_sets: level_sets.clone(),
            wall_seconds: *wall_seconds,
            exit: match (solution.summary.status, &solution.summary.warnings[..]) {
                (Status::Failed, [why, ..]) => why.clone(),
                _ => solution.summary.status_sentence.clone().into_owned(),
            },
        })
    }
}

/// The share of vertices whose largest u_kp exceeds 0.99.
fn binary(solution: &Solution) -> f64 {
    let rows = solution.u.outer_iter().filter(|u| u.iter().any(|&u| u > 0.99));
    rows.count() as f64 / solution.u.nrows() as f64
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
    if run.repetition == 0 && solution.labels.len() <= MAX_KEPT_VERTICES {
        let labels: Array1<u8> = solution.labels.iter().map(|&label| label as u8).collect();
        let certainty: Array1<u8> = (solution.u.outer_iter())
            .map(|u| (255.0 * u.iter().fold(0.0, |a: f64, &b| a.max(b))).round() as u8)
            .collect();
        npy::write(&folder.join("labels.npy"), &labels)?;
        npy::write(&folder.join("certainty.npy"), &certainty)?;
    }
    json("manifest.json", &|out| serde_json::to_writer_pretty(out, manifest))
}

/// Writes the surface and its data for the page, once per instance.
fn keep_surface(store: &Store, run: &Planned<'_>, instance: &Instance) -> Result<()> {
    let folder = store.folder.join("instances");
    let path = folder.join(format!("{}.ply", run.instance_id));
    if instance.mesh.vertices.len() > MAX_KEPT_VERTICES || path.exists() {
        return Ok(());
    }
    fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, error))?;
    let crate::Mesh { vertices, faces, .. } = instance.mesh.clone();
    // Unknown colors become gray.
    let known = |color: &[f64; 3]| color.map(|c| if c.is_nan() { 0.5 } else { c });
    let colors = Some(instance.looks.iter().map(known).collect());
    let mesh = crate::Mesh { vertices, faces, colors, ..crate::Mesh::default() };
    io::write(&path, &mesh)
}
