//! `meshseg experiment`: run, list and report reproducible experiments.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use sha2::{Digest, Sha256};

use crate::Result;
use crate::experiment::{
    self, Cluster, Command, Done, Event, Folders, Machine, Plan, Planned, Program, Spec, Store,
    one_line, operand,
};

use super::progress::Progress;
use super::{Failure, Outcome, named, note, print, shard, table};

/// Reproducible runs of solvers on instances, with figures, tables and a page.
///
/// An experiment is a TOML file that asks one question. Each of its runs is made once and stored separately. A file may
/// name commands of solvers outside the program (`name = "external"`), which `run` starts as you: read a file of
/// somebody else first.
#[derive(clap::Subcommand)]
#[command(after_help = EXAMPLES)]
pub enum Verb {
    /// Make the missing runs
    Run(Run),
    /// List the runs: which are done, which are missing, and how long those may take
    List(Selection),
    /// Write figures, tables and a page from the runs on disk
    Report(Report),
    /// Show which runs, commits and commands the numbers of a figure or table come from
    Why(WhyArguments),
}

const EXAMPLES: &str = "\
Examples:
  meshseg experiment run experiments/quickstart.toml
  meshseg experiment list experiments/profile.toml
  meshseg experiment run experiments/profile.toml --shard 1/4
  meshseg experiment run experiments/profile.toml --emit snakemake > Snakefile
  meshseg experiment report results/quickstart
  meshseg experiment why results/quickstart/figures/decay.svg";

#[derive(clap::Args)]
pub struct Selection {
    /// Experiment file
    file: PathBuf,

    /// Folder for the results of all experiments; those of FILE go to a subfolder named after it
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,

    /// Folder that `data:` stands for in file names [default: the environment variable MESHSEG_DATA]
    #[arg(long, value_name = "DIR")]
    data_dir: Option<PathBuf>,

    /// Only every N-th run, starting with the I-th
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
}

#[derive(clap::Args)]
pub struct Run {
    #[command(flatten)]
    selection: Selection,

    /// Also repeat the runs that are already done
    #[arg(long)]
    force: bool,

    /// Run nothing; print a script that makes all runs on a cluster, and then the report
    #[arg(long, value_name = "CLUSTER", value_parser = named::<Cluster>(), conflicts_with_all = ["shard", "force"])]
    emit: Option<Cluster>,

    /// Number of jobs that --emit divides the runs among [default: one per run, at most 100]
    #[arg(long, value_name = "N", requires = "emit", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    jobs: Option<u32>,
}

#[derive(clap::Args)]
pub struct Report {
    /// Results folder of one experiment
    folder: PathBuf,
}

#[derive(clap::Args)]
pub struct WhyArguments {
    /// Figure or table of a report, for example results/NAME/figures/decay.svg
    file: PathBuf,
}

pub fn run(verb: &Verb) -> Outcome {
    match verb {
        Verb::Run(arguments) => make(arguments),
        Verb::List(selection) => list(selection),
        Verb::Report(arguments) => report(&arguments.folder),
        Verb::Why(arguments) => why(&arguments.file),
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

    fn folders(&self) -> Folders {
        let parent = self.file.parent().unwrap_or(Path::new(""));
        Folders {
            folder: parent.to_owned(),
            data: self
                .data_dir
                .clone()
                .or_else(|| std::env::var_os("MESHSEG_DATA").map(Into::into)),
        }
    }

    fn plan<'a>(&self, spec: &'a Spec) -> Result<Plan<'a>> {
        let mut plan = Plan::of(spec, &self.folders(), env!("CARGO_PKG_VERSION"))?;
        if let Some(shard) = self.shard {
            plan.shard(shard);
        }
        Ok(plan)
    }

    /// How a job calls the program: as this process was called.
    fn command(&self, folder: &Path) -> Command {
        let mut run = vec![operand(&self.file.display().to_string())];
        run.extend(["--results".to_owned(), self.results.display().to_string()]);
        if let Some(data) = self.folders().data {
            run.extend(["--data-dir".to_owned(), data.display().to_string()]);
        }
        Command {
            program: std::env::args().next().unwrap_or_else(|| "meshseg".into()),
            run,
            report: operand(&folder.display().to_string()),
        }
    }

    fn store(&self, spec: &Spec) -> PathBuf {
        self.results.join(&spec.name)
    }
}

fn make(Run { selection, force, emit, jobs }: &Run) -> Outcome {
    let spec = selection.spec()?;
    let plan = selection.plan(&spec)?;
    let folder = selection.store(&spec);
    if let Some(cluster) = emit {
        let command = selection.command(&folder);
        let jobs = jobs.map(|n| n as usize);
        return Ok(print(&experiment::emit(*cluster, &plan, &command, jobs))?);
    }
    crate::file::check_folder(&folder)?;
    let store = Store::open(folder)?;
    store.keep(&spec)?;
    let mut progress = Progress::new(spec.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |event: Event<'_>| match event {
        Event::Skipped(label) => {
            note(&format!("skipped: {}: needs --data-dir or MESHSEG_DATA", one_line(label)));
            ControlFlow::Continue(())
        }
        Event::Begins { index, all, run } => {
            progress.title(format!("{}/{all} {}", index + 1, describe(run)));
            progress.observe(None)
        }
        Event::Step(sample) => progress.observe(sample),
        Event::Ended { run, numbers } => {
            note(&format!("{} {}: {}", run.id, describe(run), numbers.line()));
            progress.observe(None)
        }
        Event::Elsewhere(run) => {
            note(&format!("{}: another process is making this run", describe(run)));
            progress.observe(None)
        }
    };
    let tally =
        experiment::run(&plan, &selection.folders(), &store, &program(), *force, &mut observe)?;
    progress.finish();
    for (origin, count) in &tally.foreign {
        let runs = if *count == 1 { "1 run was" } else { &format!("{count} runs were") };
        let again = if *count == 1 { "it" } else { "them" };
        let made = origin.sentence(&Machine::this());
        note(&format!("{runs} made {made}; --force makes {again} again here"));
    }
    let mut lines = vec![
        ("made", tally.made.to_string()),
        ("already done", tally.there.to_string()),
        ("folder", store.folder.display().to_string()),
    ];
    if tally.elsewhere > 0 {
        lines.push(("running elsewhere", tally.elsewhere.to_string()));
    }
    if tally.interrupted {
        note("interrupted; run the same command again to continue");
        return Err(Failure::Interrupted);
    }
    Ok(print(&table::pairs(&lines))?)
}

fn describe(run: &Planned<'_>) -> String {
    let again = match run.repetition {
        0 => String::new(),
        n => format!(", repetition {}", n + 1),
    };
    one_line(&format!("{} on {}{again}", run.solver.label, run.instance.label))
}

fn list(selection: &Selection) -> Outcome {
    let spec = selection.spec()?;
    let plan = selection.plan(&spec)?;
    let store = selection.store(&spec);
    let done = if store.join("runs").is_dir() {
        Done::complete(&Store::open(store)?)?
    } else {
        Vec::new()
    };
    let by_id: BTreeMap<&str, &Done> =
        done.iter().map(|done| (done.manifest.id.as_str(), done)).collect();
    let mut rows =
        vec![["run", "instance", "solver", "repetition", "state"].map(String::from).to_vec()];
    let mut remaining = Remaining::default();
    for run in &plan.runs {
        let state = match by_id.get(run.id.as_str()) {
            Some(done) => done.summary.line(),
            None => {
                remaining.add(run, &done, &spec);
                "missing".into()
            }
        };
        rows.push(vec![
            run.id.clone(),
            one_line(&run.instance.label),
            one_line(&run.solver.label),
            (run.repetition + 1).to_string(),
            state,
        ]);
    }
    let mut lines = vec![("question", one_line(&spec.question))];
    lines.push(("runs", format!("{}, {} missing", plan.runs.len(), remaining.runs)));
    if remaining.runs > 0 {
        lines.push(("time", remaining.sentence()));
    }
    for label in &plan.skipped {
        let label = one_line(label);
        lines.push(("skipped", format!("{label}: needs --data-dir or MESHSEG_DATA")));
    }
    Ok(print(&(table::columns(&rows) + "\n" + &table::pairs(&lines)))?)
}

fn report(folder: &Path) -> Outcome {
    let report = experiment::report(folder, env!("CARGO_PKG_VERSION"))?;
    for line in &report.kept {
        note(line);
    }
    let mut lines = vec![("runs", format!("{}, {} missing", report.runs, report.missing))];
    let paths =
        |paths: &[PathBuf]| paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>();
    lines.extend(paths(&report.figures).into_iter().map(|path| ("figure", path)));
    lines.extend(paths(&report.tables).into_iter().map(|path| ("table", path)));
    lines.push(("page", report.page.display().to_string()));
    print(&table::pairs(&lines))?;
    report.empty.map_or(Ok(()), |error| Err(error.into()))
}

fn why(file: &Path) -> Outcome {
    let mut rows = vec![
        ["run", "instance", "solver", "repetition", "commit", "made by"].map(String::from).to_vec(),
    ];
    rows.extend(experiment::why(file)?.into_iter().map(|why| {
        let commit = why.commit.get(..12).unwrap_or(&why.commit).to_owned();
        vec![
            why.id,
            one_line(&why.instance),
            one_line(&why.solver),
            (why.repetition + 1).to_string(),
            if why.dirty { commit + " with uncommitted changes" } else { commit },
            why.command,
        ]
    }));
    Ok(print(&table::columns(&rows))?)
}

/// An estimate of the time that the missing runs take, based on those that are done.
#[derive(Default)]
struct Remaining {
    runs: usize,
    /// Of the runs that can be estimated.
    seconds: f64,
    /// Number of the others, and a limit of their time.
    unknown: usize,
    at_most: f64,
}

impl Remaining {
    /// Takes the mean time of the other repetitions, else of the runs of the same solver; otherwise unknown.
    fn add(&mut self, run: &Planned<'_>, done: &[Done], spec: &Spec) {
        self.runs += 1;
        let mean = |is_similar: &dyn Fn(&Done) -> bool| {
            let times: Vec<f64> = done
                .iter()
                .filter(|done| is_similar(done))
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
                format!("{known}, plus at most {:.0} s for {n} of unknown length", self.at_most)
            }
            (n, false) => format!("{known}, plus {n} of unknown length"),
        }
    }
}

/// Shows the lines of the experiment file that an error is about, on a terminal.
pub fn draw(error: &experiment::FormatError) {
    if !std::io::stderr().is_terminal() {
        return;
    }
    let span = error.span.start..error.span.end.max(error.span.start + 1);
    let path = error.path.display().to_string();
    let lines = Snippet::source(&error.text).path(path);
    let lines = lines.annotation(AnnotationKind::Primary.span(span));
    let renderer = match std::env::var_os("NO_COLOR") {
        Some(_) => Renderer::plain(),
        None => Renderer::styled(),
    };
    let report = [Group::with_level(Level::ERROR).element(lines)];
    note(&renderer.decor_style(DecorStyle::Unicode).render(&report));
}
