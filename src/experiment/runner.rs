//! Makes the missing runs of a plan.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Instant, SystemTime};

use super::external::Attempt;
use super::folders::{Folders, InstanceError};
use super::instance::Instance;
use super::labeled::{self, Made, length_of_cuts};
use super::machine::{LoadWatch, Machine, Program, TOLERATED_LOAD};
use super::manifest::Manifest;
use super::numbers::Numbers;
use super::plan::{Plan, Planned};
use super::reconstructed::reconstructed;
use super::results::Origin;
use super::run_files::{Outcome, keep_surface, write};
use super::scene::{Scene, Truth};
use super::spec::Task;
use super::store::{Claim, Store};
use crate::error::{Error, Result};
use crate::run::{Sample, Status, Stop};
use crate::solve::Solution;

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
        /// Its numbers.
        numbers: &'a Numbers,
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
    /// The problem of solvers and the photographs of reconstructions, as far as they were needed.
    problem: Option<Instance>,
    scene: Option<Scene>,
    /// Whether a built-in solver has run on it.
    is_warm: bool,
}

impl Current<'_> {
    fn problem(&self) -> &Instance {
        self.problem.as_ref().expect("it was made before the run")
    }
}

/// An outcome with the measurements of its run.
struct Timed {
    outcome: Outcome,
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
        if timed.outcome.is_interrupted() {
            return Ok(ControlFlow::Break(()));
        }
        let manifest = self.manifest(run, &timed)?;
        let numbers = timed.outcome.numbers();
        write(claim.folder(), run, &timed.outcome, &numbers, &manifest)?;
        claim.finish()?;
        self.tally.made += 1;
        Ok(observe(Event::Ended { run, numbers: &numbers }))
    }

    fn bring_instance(&mut self, run: &'a Planned<'a>) -> Result<()> {
        if self.current.as_ref().is_none_or(|current| current.id != run.instance_id) {
            // Frees the previous instance before the next one is made.
            self.current = None;
            let id = &run.instance_id;
            self.current = Some(Current { id, problem: None, scene: None, is_warm: false });
        }
        let current = self.current.as_mut().expect("it was just made");
        let located = |missing: InstanceError| {
            self.plan.spec.format_error(self.folders.blame(run.instance), Error::from(missing))
        };
        match run.solver.task {
            Task::Reconstruct(_) if current.scene.is_none() => {
                let scene = self.folders.scene(run.instance).map_err(located)?;
                if let Some(Truth { mesh, regions: Some((labels, colors)) }) = &scene.truth {
                    let color = |k: usize| colors[labels[k]];
                    keep_surface(self.store, run, mesh, color)?;
                }
                current.scene = Some(scene);
            }
            Task::Reconstruct(_) => {}
            _ if current.problem.is_none() => {
                let problem = self.folders.instance(run.instance).map_err(located)?;
                keep_surface(self.store, run, &problem.mesh, |k| problem.looks[k])?;
                current.problem = Some(problem);
            }
            _ => {}
        }
        Ok(())
    }

    fn warm_up(&mut self, run: &Planned<'_>) -> Result<()> {
        let current = self.current.as_mut().expect("its instance is there");
        if !current.is_warm && matches!(run.solver.task, Task::Solve | Task::Segment(_)) {
            let stop = Stop { iterations: Some(WARM_UP_STEPS), ..Stop::default() };
            labeled::attempt(run, current.problem(), stop, &mut |_| ControlFlow::Continue(()))?;
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
        let current = self.current.as_ref().expect("its instance is there");
        let (folder, stop) = (&self.folders.folder, &self.plan.spec.stop);
        let (start, begin, others) = (SystemTime::now(), Instant::now(), self.load.others());
        let load_average = LoadWatch::average();
        let mut step = |sample: Option<&Sample>| observe(Event::Step(sample));
        let iterations = run.solver.max_iterations.or(stop.iterations);
        let stop = &Stop { iterations, ..stop.clone() };
        let outcome = match &run.solver.task {
            Task::Reconstruct(evolution) => {
                let scene = current.scene.as_ref().expect("it was made before the run");
                Outcome::Surface(reconstructed(run, evolution, scene, self.folders, &mut step)?)
            }
            Task::External(external) => {
                let instance = current.problem();
                let attempt = Attempt { run, external, instance, folder, claimed, stop };
                Outcome::Labels(Made::of(attempt.make(&mut step)?))
            }
            _ => {
                Outcome::Labels(labeled::attempt(run, current.problem(), stop.clone(), &mut step)?)
            }
        };
        let wall_seconds = begin.elapsed().as_secs_f64();
        let others = f64::max(others, self.load.others());
        Ok(Timed { outcome, start, wall_seconds, load_average, others })
    }

    fn manifest(&self, run: &Planned<'_>, timed: &Timed) -> Result<Manifest> {
        let Timed { outcome, start, wall_seconds, load_average, others } = timed;
        let blank = Manifest {
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
            mislabeled: None,
            scores: None,
            cut_length: None,
            binary: None,
            parameters: None,
            level_sets: None,
            wall_seconds: *wall_seconds,
            exit: String::new(),
        };
        match outcome {
            Outcome::Surface(found) => Ok(Manifest {
                mislabeled: found.mislabeled,
                parameters: Some(found.colors.iter().map(|color| color.to_vec()).collect()),
                exit: found.summary.status_sentence.clone().into_owned(),
                ..blank
            }),
            Outcome::Labels(Made { solution, parameters, level_sets }) => {
                let instance = self.current.as_ref().expect("its instance is there").problem();
                let scores = labeled::scores(run, instance, solution)?;
                Ok(Manifest {
                    mislabeled: scores.as_ref().map(|scores| scores.mislabeled),
                    scores: scores.map(|scores| scores.others),
                    cut_length: Some(length_of_cuts(instance, solution.labels.view())),
                    binary: Some(binary(solution)),
                    parameters: parameters.clone(),
                    level_sets: level_sets.clone(),
                    exit: match (solution.summary.status, &solution.summary.warnings[..]) {
                        (Status::Failed, [why, ..]) => why.clone(),
                        _ => solution.summary.status_sentence.clone().into_owned(),
                    },
                    ..blank
                })
            }
        }
    }
}

/// The share of vertices or faces whose largest u_kp exceeds 0.99.
fn binary(solution: &Solution) -> f64 {
    let rows = solution.u.outer_iter().filter(|u| u.iter().any(|&u| u > 0.99));
    rows.count() as f64 / solution.u.nrows() as f64
}
