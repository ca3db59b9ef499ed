//! `meshseg solve`: one convex problem for given costs.

use std::path::PathBuf;
use std::str::FromStr;

use ndarray::Array2;

use crate::domain::Element as On;
use crate::seeds::Seeds;
use crate::start::Start;
use crate::{Result, outcome, solve};

use super::inputs::mesh_with_costs;
use super::listener::{Found, listening, with_threads};
use super::memory::Memory;
use super::progress::Progress;
use super::seeds;
use super::solving::{Solving, exit, summary_lines};
use super::{Outcome, cut, note, output, preview, print, table, warn, welding};

/// Minimize the energy for given costs, on the mesh as it is (no scaling).
///
/// The costs S are pointwise: V x m, float64 or float32, in C or Fortran order.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// Pointwise costs, V x m
    #[arg(long, value_name = "S.npy")]
    costs: PathBuf,

    /// Weight of the total variation
    #[arg(long, allow_negative_numbers = true)]
    lambda: f64,

    /// Initial U: uniform, random, argmin, or a file U.npy
    #[arg(
        long,
        default_value = "argmin",
        conflicts_with = "coarse_to_fine",
        value_name = "uniform|random|argmin|U.npy"
    )]
    init: Init,

    /// Seed of a random start
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// Vertices or faces whose regions are given: a .csv file with the header vertex,region or face,region (a face
    /// stands for its corners), or FILE.npy with one integer per vertex or face, -1 where nothing is given. The labels
    /// agree with them, and so do all labelings that the certificate refers to
    #[arg(long, value_name = "FILE")]
    seeds: Option<PathBuf>,

    /// Merge vertices within this distance of each other [default: 0, equal positions only]; merged vertices take the
    /// area-weighted mean of their costs, and results refer to the vertices and faces of the file. Without --weld the
    /// mesh stays as it is
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
    weld: Option<f64>,

    #[command(flatten)]
    solving: Solving,

    /// What the names of files stand for, if they are in memory.
    #[arg(skip)]
    pub memory: Memory,
}

const EXAMPLES: &str = "\
Examples:
  meshseg solve mesh.ply --costs S.npy --lambda 0.005 --out results/mesh
  meshseg solve torus:400x250 --costs S.npy --lambda 0.005 --gap 1e-5 --solver fista \\
      --solver-option epsilon=0.1 --out results/torus";

#[derive(Clone)]
pub enum Init {
    Uniform,
    Random,
    Argmin,
    File(PathBuf),
}

impl FromStr for Init {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        Ok(match text {
            "uniform" => Init::Uniform,
            "random" => Init::Random,
            "argmin" => Init::Argmin,
            "" => return Err("must be uniform, random, argmin or a file U.npy"),
            file => Init::File(file.into()),
        })
    }
}

impl Init {
    pub fn start(&self, costs: &Array2<f64>, seed: u64, memory: &Memory) -> Result<Start> {
        Ok(match self {
            Init::Uniform => Start::Uniform,
            Init::Random => Start::Random { seed },
            Init::Argmin => Start::Argmin,
            Init::File(path) => {
                let start = Start::Given(memory.matrix(path)?.into_owned());
                start.check(costs.dim()).map_err(|error| error.of_file(path))?;
                start
            }
        })
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    with_threads(arguments.solving.threads(), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    let solving = &arguments.solving;
    let request = solving.request(&arguments.mesh, arguments.lambda)?;
    let memory = &arguments.memory;
    let (mesh, costs) = mesh_with_costs(&arguments.mesh, &arguments.costs, On::Vertices, memory)?;
    let seeds = match &arguments.seeds {
        Some(path) => seeds::read(path, &mesh, costs.ncols(), On::Vertices, memory)?,
        None => Seeds::default(),
    };
    let start = arguments.init.start(&costs, arguments.seed, memory)?;
    let weld = match arguments.weld {
        Some(tolerance) => welding::weld(&mesh, tolerance)?,
        None => None,
    };

    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let mut solution = match &weld {
        Some(weld) => {
            let weights = request.mass.weights(&mesh);
            let start = match start {
                Start::Given(u) => Start::Given(welding::means(weld, &u, &weights)),
                other => other,
            };
            let welded = welding::costs(weld, &costs, &weights)?;
            let seeds = seeds.welded(weld)?;
            solve::solve_seeded(&weld.mesh, &welded, &seeds, &start, &request, &mut observe)?
        }
        None => solve::solve_seeded(&mesh, &costs, &seeds, &start, &request, &mut observe)?,
    };
    progress.finish();
    let contours = cut::traced(weld.as_ref().map_or(&mesh, |weld| &weld.mesh), &mut solution);
    if let Some(weld) = &weld {
        solution = solution.spread(&mesh, weld);
    }
    solution.summary.warnings.extend(match arguments.weld {
        Some(_) => welding::aftermath(&mesh, weld.as_ref()),
        None => welding::seams(&mesh, "--weld"),
    });

    let draw = solving.draws();
    let looks = preview::of_costs(&mesh, &costs, &solution.labels, solving.view, draw);
    if let Some(out) = &solving.out {
        let written = cut::requested(&contours, solving);
        let labeled = (&solution).into();
        outcome::write(out, &solution.summary, labeled, &mesh, &looks, written, &solving.also)?;
    }
    let of_cut = cut::report(&mesh, &solution, &contours, &looks, solving)?;
    if let Some(tolerance) = arguments.weld {
        note(&welding::note(weld.as_ref(), tolerance));
    }
    let summary = &solution.summary;
    warn(&summary.warnings);
    let mut lines = summary_lines(summary);
    lines.extend(of_cut);
    lines.extend(solving.written_to());
    let (status, printed) = (summary.status, print(&table::pairs(&lines)));
    listening(|listener| {
        let vertices = solution.labels.clone();
        let summary = output::json(&solution.summary);
        listener.found = Some(Found { summary, vertices, faces: None, solution });
    });
    exit(status, printed)
}
