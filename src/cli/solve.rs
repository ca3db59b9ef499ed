//! `meshseg solve`: one convex problem for given costs, on vertices or on faces.

mod faces;
mod given;
mod vertices;

use std::path::PathBuf;
use std::str::FromStr;

use ndarray::Array2;

use crate::Result;
use crate::domain::Element;
use crate::seeds::Seeds;
use crate::start::Start;

use super::inputs::mesh_with_costs;
use super::listener::with_threads;
use super::memory::Memory;
use super::solving::{Solving, exit, summary_lines};
use super::{Outcome, named, note, print, table, warn, welding};
use super::{pairs, seeds};
use given::Given;

/// Minimize the energy for given costs, on the mesh as it is (no scaling).
///
/// The costs S are pointwise: V x m, or F x m with --on faces, float64 or float32, in C or Fortran order.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// Pointwise costs, V x m, or F x m with --on faces
    #[arg(long, value_name = "S.npy")]
    costs: PathBuf,

    /// What gets a label: the vertices or the faces of the mesh. Costs of faces count with their areas, cuts with the
    /// lengths of edges; the relaxation is separate unless another is given
    #[arg(long, value_parser = named::<Element>(), default_value = "vertices")]
    on: Element,

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
      --solver-option epsilon=0.1 --out results/torus
  meshseg solve mesh.ply --costs S.npy --on faces --lambda 0.005 --out results/faces";

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
    let mut request = solving.request(&arguments.mesh, arguments.lambda)?;
    let on = arguments.on;
    let memory = &arguments.memory;
    let (mesh, costs) = mesh_with_costs(&arguments.mesh, &arguments.costs, on, memory)?;
    let labels = pairs::Labels { count: costs.ncols(), names: &[] };
    let metric = pairs::relaxation(solving.pairs.as_deref(), labels, memory)?;
    request.relaxation = metric.or(solving.relaxation).unwrap_or(on.relaxation());
    let seeds = match &arguments.seeds {
        Some(path) => seeds::read(path, &mesh, costs.ncols(), on, memory)?,
        None => Seeds::default(),
    };
    let start = arguments.init.start(&costs, arguments.seed, memory)?;
    let weld = match arguments.weld {
        Some(tolerance) => welding::weld(&mesh, tolerance)?,
        None => None,
    };
    let of_weld = match arguments.weld {
        Some(_) => welding::aftermath(&mesh, weld.as_ref()),
        None => welding::seams(&mesh, "--weld"),
    };
    let weld = weld.as_ref();
    let source = memory.file(&arguments.mesh);
    let given = Given { mesh: &mesh, source, costs: &costs, seeds: &seeds, start, weld };
    let (summary, of_cut) = match on {
        Element::Vertices => vertices::solve(given, &request, of_weld, solving)?,
        Element::Faces => faces::solve(&given, &request, of_weld, solving)?,
    };
    if let Some(tolerance) = arguments.weld {
        note(&welding::note(weld, tolerance));
    }
    warn(&summary.warnings);
    let mut lines = summary_lines(&summary);
    lines.extend(of_cut);
    lines.extend(solving.written_to());
    exit(summary.status, print(&table::pairs(&lines)))
}
