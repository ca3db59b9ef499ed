//! `meshseg experiment`: run, list and report reproducible experiments.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use meshseg::Result;
use meshseg::experiment::{self, Done, Event, Places, Plan, Planned, Program, Spec, Store};
use sha2::{Digest, Sha256};

use super::progress::Progress;
use super::{Failure, Outcome, note, print, table};

/// Reproducible runs of solvers on instances, with figures, tables and a page.
///
/// An experiment is a TOML file that asks one question; its runs are stored one by one, and made only once.
#[derive(clap::Subcommand)]
#[command(after_help = EXAMPLES)]
pub enum Verb {
    /// Make the runs that are missing
    Run(Run),
    /// Show the runs: what is done, what is missing, how long that may take
    List(Selection),
}

const EXAMPLES: &str = "\
Examples:
  meshseg experiment run experiments/quickstart.toml
  meshseg experiment list experiments/profile.toml
  meshseg experiment run experiments/profile.toml --shard 1/4";

#[derive(clap::Args)]
pub struct Selection {
    /// Experiment file
    file: PathBuf,

    /// Folder of all results; those of FILE go to a folder of its name
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,

    /// Folder that `data:` stands for in the names of files [default: the environment's MESHSEG_DATA]
    #[arg(long, value_name = "DIR")]
    data_dir: Option<PathBuf>,

    /// Every N-th run only, from the I-th on
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
}

#[derive(clap::Args)]
pub struct Run {
    #[command(flatten)]
    selection: Selection,

    /// Make the runs again that are there already
    #[arg(long)]
    force: bool,
}

fn shard(text: &str) -> std::result::Result<(usize, usize), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parsed {
        Some((i, n)) if (1..=n).contains(&i) => Ok((i, n)),
        _ => Err("must read I/N with 1 <= I <= N".into()),
    }
}

pub fn run(verb: &Verb) -> Outcome {
    match verb {
        Verb::Run(arguments) => make(arguments),
        Verb::List(selection) => list(selection),
    }
}

/// The program as it was built.
fn program() -> Program {
    let lock = Sha256::digest(include_bytes!("../../Cargo.lock"));
    Program {
        version: env!("CARGO_PKG_VERSION").into(),
        commit: env!("MESHSEG_COMMIT").into(),
        dirty: env!("MESHSEG_DIRTY") == "true",
        lock: lock.iter().map(|byte| format!("{byte:02x}")).collect(),
        rustc: env!("MESHSEG_RUSTC").into(),
        target: env!("MESHSEG_TARGET").into(),
        target_features: env!("MESHSEG_TARGET_FEATURES").into(),
    }
}

impl Selection {
    fn spec(&self) -> Result<Spec> {
        Spec::open(&self.file)
    }

    fn places(&self) -> Places {
        let parent = self.file.parent().unwrap_or(Path::new(""));
        Places {
            folder: parent.to_owned(),
            data: self
                .data_dir
                .clone()
                .or_else(|| std::env::var_os("MESHSEG_DATA").map(Into::into)),
        }
    }

    fn plan<'a>(&self, spec: &'a Spec) -> Result<Plan<'a>> {
        let mut plan = Plan::of(spec, &self.places(), env!("CARGO_PKG_VERSION"))?;
        if let Some(shard) = self.shard {
            plan.shard(shard);
        }
        Ok(plan)
    }

    fn store(&self, spec: &Spec) -> PathBuf {
        self.results.join(&spec.name)
    }
}

fn make(Run { selection, force }: &Run) -> Outcome {
    let spec = selection.spec()?;
    let plan = selection.plan(&spec)?;
    let folder = selection.store(&spec);
    meshseg::file::check_folder(&folder)?;
    let store = Store::open(folder)?;
    store.keep(&spec)?;
    let mut progress = Progress::new(spec.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |event: Event<'_>| match event {
        Event::Skipped(label) => {
            note(&format!("skipped: {label}: needs --data-dir or MESHSEG_DATA"));
            ControlFlow::Continue(())
        }
        Event::Begins { index, all, run } => {
            progress.title(format!("{}/{all} {}", index + 1, describe(run)));
            progress.observe(None)
        }
        Event::Step(sample) => progress.observe(sample),
        Event::Ended { run, solution } => {
            let summary = &solution.summary;
            note(&format!(
                "{} {}: {} iterations, {:.3} s, gap {:.1e}",
                run.id,
                describe(run),
                summary.iterations,
                summary.seconds,
                summary.relative_gap
            ));
            progress.observe(None)
        }
        Event::Elsewhere(run) => {
            note(&format!("{}: another process is at it", describe(run)));
            progress.observe(None)
        }
    };
    let tally =
        experiment::run(&plan, &selection.places(), &store, &program(), *force, &mut observe)?;
    progress.finish();
    let mut lines = vec![
        ("made", tally.made.to_string()),
        ("there before", tally.there.to_string()),
        ("in", store.folder.display().to_string()),
    ];
    if tally.elsewhere > 0 {
        lines.push(("under way elsewhere", tally.elsewhere.to_string()));
    }
    if tally.interrupted {
        note("interrupted: the same command goes on where this one ended");
        return Err(Failure::Interrupted);
    }
    Ok(print(&table::pairs(&lines))?)
}

fn describe(run: &Planned<'_>) -> String {
    let again = match run.repetition {
        0 => String::new(),
        n => format!(", repetition {}", n + 1),
    };
    format!("{} on {}{again}", run.solver.label, run.instance.label)
}

fn list(selection: &Selection) -> Outcome {
    let spec = selection.spec()?;
    let plan = selection.plan(&spec)?;
    let store = selection.store(&spec);
    let done =
        if store.join("runs").is_dir() { Done::all(&Store::open(store)?)? } else { Vec::new() };
    let by_id: BTreeMap<&str, &Done> =
        done.iter().map(|done| (done.manifest.id.as_str(), done)).collect();
    let mut rows =
        vec![["run", "instance", "solver", "repetition", "state"].map(String::from).to_vec()];
    let mut left = Left::default();
    for run in &plan.runs {
        let state = match by_id.get(run.id.as_str()) {
            Some(done) => format!(
                "{} iterations, {:.3} s, gap {:.1e}",
                done.summary.iterations, done.summary.seconds, done.summary.relative_gap
            ),
            None => {
                left.add(run, &done, &spec);
                "missing".into()
            }
        };
        rows.push(vec![
            run.id.clone(),
            run.instance.label.clone(),
            run.solver.label.clone(),
            (run.repetition + 1).to_string(),
            state,
        ]);
    }
    let mut lines = vec![("question", spec.question.clone())];
    lines.push(("runs", format!("{}, {} missing", plan.runs.len(), left.runs)));
    if left.runs > 0 {
        lines.push(("time", left.sentence()));
    }
    for label in &plan.skipped {
        lines.push(("skipped", format!("{label}: needs --data-dir or MESHSEG_DATA")));
    }
    Ok(print(&(table::columns(&rows) + "\n" + &table::pairs(&lines)))?)
}

/// How long the missing runs may take, judged by those that are done.
#[derive(Default)]
struct Left {
    runs: usize,
    seconds: f64,
    at_most: f64,
    unknown: usize,
}

impl Left {
    /// Like another repetition; else like what the same solver takes in the mean; else no one knows.
    fn add(&mut self, run: &Planned<'_>, done: &[Done], spec: &Spec) {
        self.runs += 1;
        let mean = |same: &dyn Fn(&Done) -> bool| {
            let times: Vec<f64> = done
                .iter()
                .filter(|done| same(done))
                .map(|done| done.manifest.wall_seconds)
                .collect();
            (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
        };
        let solver = |done: &Done| done.manifest.solver == run.solver.label;
        let both = |done: &Done| solver(done) && done.manifest.instance == run.instance.label;
        match mean(&both).or_else(|| mean(&solver)) {
            Some(seconds) => self.seconds += seconds,
            None => {
                self.unknown += 1;
                self.at_most += spec.stop.time.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
            }
        }
    }

    fn sentence(&self) -> String {
        let known = format!("about {:.0} s", self.seconds.ceil());
        match (self.unknown, self.at_most.is_finite()) {
            (0, _) => known,
            (n, true) => {
                format!("{known}, and at most {:.0} s for {n} of unknown length", self.at_most)
            }
            (n, false) => format!("{known}, and {n} of unknown length"),
        }
    }
}

/// What is wrong with an experiment file, drawn beside its lines, for people.
pub fn draw(misfit: &experiment::Misfit) {
    if !std::io::stderr().is_terminal() {
        return;
    }
    let place = misfit.place.start..misfit.place.end.max(misfit.place.start + 1);
    let label = miette::LabeledSpan::underline(place);
    let source = miette::NamedSource::new(misfit.path.display().to_string(), misfit.text.clone());
    let report =
        miette::miette!(labels = vec![label], "{}", misfit.message).with_source_code(source);
    note(&format!("{report:?}"));
}
