//! `meshseg problem`: exports problems for external solvers, and imports their iterates.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Subcommand;

use crate::certificate::DUAL_STEPS;
use crate::classes::carry::labels_of_vertices;
use crate::domain::Element;
use crate::exchange::{End, Exchanged, Iterates, certify};
use crate::experiment::{Folders, Spec, did_you_mean};
use crate::names::Named;
use crate::operator::Mass;
use crate::outcome::{self, Drawn, Labeled};
use crate::relaxation::Relaxation;
use crate::render::View;
use crate::run::{Status, Stop};
use crate::solve::{Request, model_mesh};
use crate::solver::Method;
use crate::{Error, Result, costs};

use super::inputs::mesh_with_costs;
use super::memory::Memory;
use super::progress::Progress;
use super::solve::Init;
use super::solving::{exit, summary_lines};
use super::{Outcome, named, pairs, preview, print, table, warn, welding};

/// Export problems for external solvers, and import their iterates
#[derive(Subcommand)]
pub enum Verb {
    Export(Export),
    ImportTrace(ImportTrace),
}

/// Write one problem as a NumPy archive, which many languages can read.
///
/// It holds K in compressed rows, masses, integrated costs, lambda, mesh and initial U; experiments/reference/README.md
/// lists names and shapes. Vertices are those of the file; `meshseg mesh convert --weld` merges coincident ones.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  meshseg problem export mesh.ply --costs S.npy --lambda 0.005 --out problem.npz
  meshseg problem export mesh.ply --costs S.npy --on faces --lambda 0.005 --out problem.npz
  meshseg problem export experiments/reference.toml --instance small --out problem.npz")]
pub struct Export {
    /// Mesh file, builtin:spot, a shape such as torus:400x250, or an experiment file (.toml)
    input: PathBuf,

    /// Pointwise costs, V x m, or F x m with --on faces
    #[arg(long, value_name = "S.npy")]
    costs: Option<PathBuf>,

    /// What has a label: the vertices or the faces of the mesh [default: vertices]
    #[arg(long, value_parser = named::<Element>())]
    on: Option<Element>,

    /// Weight of the total variation
    #[arg(long, allow_negative_numbers = true)]
    lambda: Option<f64>,

    /// The relaxation, see `solve --help` [default: frobenius; separate on faces, for which it is exact]
    #[arg(long, value_parser = named::<Relaxation>())]
    relaxation: Option<Relaxation>,

    /// How much cuts between each two labels weigh, see `solve --help`
    #[arg(long, value_name = "FILE", conflicts_with = "relaxation")]
    pairs: Option<PathBuf>,

    /// Quadrature of the data term; on faces all are the same [default: barycentric]
    #[arg(long, value_parser = named::<Mass>())]
    mass: Option<Mass>,

    /// Initial U: uniform, random, argmin, or a file U.npy [default: argmin]
    #[arg(long, value_name = "uniform|random|argmin|U.npy")]
    init: Option<Init>,

    /// Seed of a random start [default: 0]
    #[arg(long, allow_negative_numbers = true)]
    seed: Option<u64>,

    /// Label of the instance; needed if the experiment file has several
    #[arg(long)]
    instance: Option<String>,

    /// Folder that `data:` stands for in an experiment file [default: the environment variable MESHSEG_DATA]
    #[arg(long, value_name = "DIR")]
    data_dir: Option<PathBuf>,

    /// Archive to write
    #[arg(long, value_name = "PROBLEM.npz")]
    out: PathBuf,
}

/// Evaluate and certify the iterates of an external solver, and write a results folder as `solve` does.
///
/// FOLDER holds trace.csv (iteration, seconds, and epsilon and epsilon_mode if a smoothed energy is minimized),
/// u_<iteration>.npy and optionally q_<iteration>.npy. The bound of an iterate comes from its q, else from the
/// smoothing, else from steps of the default solver; the column `certificate` says which.
#[derive(clap::Args)]
#[command(after_help = "Example:
  meshseg problem export mesh.ply --costs S.npy --lambda 0.005 --out problem.npz
  mkdir out && python3 experiments/reference/example.py problem.npz out
  meshseg problem import-trace problem.npz out --out results/mine")]
pub struct ImportTrace {
    /// Archive that the solver has read
    problem: PathBuf,

    /// Folder that the solver has written
    folder: PathBuf,

    /// Name of the solver in the summary
    #[arg(long, default_value = "external")]
    name: String,

    /// Certified relative gap that counts as converged
    #[arg(long, default_value_t = 1e-4, allow_negative_numbers = true)]
    gap: f64,

    /// Steps of the default solver for each iterate that has neither q nor epsilon
    #[arg(long, default_value_t = DUAL_STEPS, value_parser = clap::value_parser!(u64).range(1..))]
    dual_steps: u64,

    /// Do not write preview.png
    #[arg(long)]
    no_preview: bool,

    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub fn run(verb: &Verb) -> Outcome {
    match verb {
        Verb::Export(arguments) => export(arguments),
        Verb::ImportTrace(arguments) => import(arguments),
    }
}

impl Export {
    fn problem(&self) -> Result<Exchanged> {
        if self.input.extension().is_some_and(|extension| extension == "toml") {
            return self.of_experiment();
        }
        let (Some(costs), Some(lambda)) = (&self.costs, self.lambda) else {
            return Err(Error::unsuitable(
                "a mesh needs --costs S.npy and --lambda; an experiment file ends in .toml",
            ));
        };
        if self.instance.is_some() || self.data_dir.is_some() {
            return Err(Error::unsuitable(
                "--instance and --data-dir need an experiment file, which ends in .toml",
            ));
        }
        let memory = Memory::default();
        let on = self.on.unwrap_or(Element::Vertices);
        let (mesh, s) = mesh_with_costs(&self.input, costs, on, &memory)?;
        let init = self.init.as_ref().unwrap_or(&Init::Argmin);
        let start = init.start(&s, self.seed.unwrap_or(0), &memory)?;
        let mass = self.mass.unwrap_or(Mass::Barycentric);
        if on == Element::Faces && mass != Mass::Barycentric {
            return Err(Error::unsuitable("--mass: faces count with their areas; leave it out"));
        }
        let problem = match on {
            Element::Vertices => Exchanged::new(&mesh, &s, lambda, mass, &start)?,
            Element::Faces => Exchanged::on_faces(&mesh, None, &s, lambda, &start)?,
        };
        warn(&welding::seams(&mesh, welding::CONVERT_COMMAND));
        warn(&costs::checked(&s, mass)?.1);
        if on == Element::Vertices {
            warn(&model_mesh(&mesh)?.1);
        }
        let labels = pairs::Labels { count: s.ncols(), names: &[] };
        let metric = pairs::relaxation(self.pairs.as_deref(), labels, &memory)?;
        let relaxation = metric.or(self.relaxation).unwrap_or(problem.relaxation);
        Ok(problem.in_relaxation(relaxation))
    }

    fn of_experiment(&self) -> Result<Exchanged> {
        let given = [
            ("--costs", self.costs.is_some()),
            ("--on", self.on.is_some()),
            ("--lambda", self.lambda.is_some()),
            ("--relaxation", self.relaxation.is_some()),
            ("--pairs", self.pairs.is_some()),
            ("--mass", self.mass.is_some()),
            ("--init", self.init.is_some()),
            ("--seed", self.seed.is_some()),
        ];
        if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
            let message = format!("{option} is set in the experiment file: leave it out here");
            return Err(Error::malformed(&self.input, message));
        }
        let spec = Spec::open(&self.input)?;
        let cell = match (&self.instance, &spec.instances[..]) {
            (None, [only]) => Some(only),
            (None, _) => None,
            (Some(label), all) => all.iter().find(|cell| cell.label == *label),
        };
        let Some(cell) = cell else {
            let labels: Vec<String> =
                spec.instances.iter().map(|cell| format!("{:?}", cell.label)).collect();
            let all = spec.instances.iter().map(|cell| cell.label.as_str());
            let meant =
                self.instance.as_ref().map_or(String::new(), |given| did_you_mean(given, all));
            let message =
                format!("name one of its instances: --instance {}{meant}", labels.join(" or "));
            return Err(Error::malformed(&self.input, message));
        };
        let folders = Folders {
            folder: self.input.parent().unwrap_or(Path::new("")).to_owned(),
            data: (self.data_dir.clone())
                .or_else(|| std::env::var_os("MESHSEG_DATA").map(Into::into)),
        };
        let instance = folders
            .instance(cell)
            .map_err(|missing| spec.format_error(folders.blame(cell), Error::from(missing)))?;
        instance.exchanged(cell)
    }
}

fn export(arguments: &Export) -> Outcome {
    let problem = arguments.problem()?;
    problem.write(&arguments.out)?;
    let lines = [
        ("vertices", problem.mesh.vertices.len().to_string()),
        ("faces", problem.mesh.faces.len().to_string()),
        ("labels of", problem.domain().element().nouns()[1].to_owned()),
        ("regions", problem.f.ncols().to_string()),
        ("lambda", table::number(problem.lambda)),
        ("relaxation", problem.relaxation.name().to_owned()),
        ("written to", arguments.out.display().to_string()),
    ];
    Ok(print(&table::pairs(&lines))?)
}

fn import(arguments: &ImportTrace) -> Outcome {
    let ImportTrace { problem: path, folder, name, gap, dual_steps, no_preview, out } = arguments;
    if !(*gap >= 0.0 && gap.is_finite()) {
        let message = format!("--gap {gap:?}: must be a finite number, 0 or more");
        return Err(Error::unsuitable(message).into());
    }
    crate::file::check_folder(out)?;
    let problem = Exchanged::read(path)?;
    let mut iterates = Iterates::of(folder);
    if let Some(error) = iterates.broken.take() {
        return Err(error.into());
    }
    if iterates.all.is_empty() {
        let message = "has no samples; below the line `iteration,seconds`, write a line for each u_<iteration>.npy";
        return Err(Error::malformed(&folder.join("trace.csv"), message).into());
    }
    let request = Request {
        lambda: problem.lambda,
        relaxation: problem.relaxation,
        mass: problem.mass,
        method: Method::default(),
        stop: Stop { relative_gap: Some(*gap), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    let end = End {
        solver: name.clone(),
        options: BTreeMap::new(),
        status: Status::Ended,
        warnings: Vec::new(),
    };
    let mut progress = Progress::new(*gap);
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let solution = certify(&problem, &iterates, *dual_steps, &request, end, &mut observe)?;
    progress.finish();
    if solution.summary.status == Status::Failed {
        return Err(Error::unsuitable(solution.summary.warnings.join("; ")).into());
    }
    let (mesh, labels, draw) = (&problem.mesh, &solution.labels, !no_preview);
    match problem.domain().element() {
        Element::Vertices => {
            let looks = preview::of_costs(mesh, &problem.f, labels, View::Auto, draw);
            let labeled = (&solution).into();
            outcome::write(out, &solution.summary, labeled, mesh, &looks, None, &[])?;
        }
        Element::Faces => {
            let vertices = labels_of_vertices(mesh, labels, problem.f.ncols());
            let (looks, picture) =
                preview::of_costs_of_faces(mesh, &problem.f, labels, View::Auto, draw);
            let drawn = picture.as_ref().map(|(mesh, u)| Drawn { mesh, u });
            let (solution, faces) = (&solution, Some(labels));
            let labeled = Labeled { solution, vertices: &vertices, faces, drawn, source: None };
            outcome::write(out, &solution.summary, labeled, mesh, &looks, None, &[])?;
        }
    }
    let summary = &solution.summary;
    warn(&summary.warnings);
    let mut lines = summary_lines(summary);
    lines.push(("written to", out.display().to_string()));
    exit(summary.status, print(&table::pairs(&lines)))
}
