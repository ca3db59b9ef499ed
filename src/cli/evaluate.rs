//! `meshseg evaluate`: energies and certificate of any U, as JSON.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use ndarray::Array2;

use crate::certificate::DUAL_STEPS;
use crate::counted::counted;
use crate::domain::Element;
use crate::evaluate::{Evaluation, Question, evaluate, evaluate_on_faces};
use crate::mesh::{Mesh, Weld};
use crate::operator::Mass;
use crate::problem::{Smoothing, SmoothingMode};
use crate::relaxation::Relaxation;
use crate::{Error, Result};

use super::inputs::mesh_with_costs;
use super::memory::Memory;
use super::progress::Progress;
use super::{Outcome, named, note, pairs, print_json, warn, welding};

/// Print the energies, the lower bound and the rounding of any U as JSON.
///
/// The bound is valid however U was computed. It comes from a given dual field q, from steps of the default solver
/// that start at U, or from the gradient of the smoothed total variation at U, whichever is largest.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  meshseg solve mesh.ply --costs S.npy --lambda 0.005 --save q --out results/mesh
  meshseg evaluate mesh.ply --costs S.npy --lambda 0.005 --u results/mesh/u.npy --q results/mesh/q.npy
  meshseg evaluate mesh.ply --costs S.npy --lambda 0.005 --u results/mesh/u.npy --epsilon 0.01
  meshseg evaluate mesh.ply --costs S.npy --on faces --lambda 0.005 --u one-hot.npy

Evaluate the results of `solve --weld` with the same --weld: rows of U and q refer to vertices and faces of the file.")]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// Pointwise costs, V x m, or F x m with --on faces
    #[arg(long, value_name = "S.npy")]
    costs: PathBuf,

    /// What has a label: the vertices or the faces of the mesh
    #[arg(long, value_parser = named::<Element>(), default_value = "vertices")]
    on: Element,

    /// Weight of the total variation
    #[arg(long, allow_negative_numbers = true)]
    lambda: f64,

    /// The relaxation, see `solve --help` [default: frobenius; separate on faces, for which it is exact]
    #[arg(long, value_parser = named::<Relaxation>())]
    relaxation: Option<Relaxation>,

    /// How much cuts between each two labels weigh, see `solve --help`
    #[arg(long, value_name = "FILE", conflicts_with = "relaxation")]
    pairs: Option<PathBuf>,

    /// Relaxed labels, of the shape of the costs
    #[arg(long, value_name = "U.npy")]
    u: PathBuf,

    /// Dual field, 2F x m, as written by `solve --save q`; the bound is then that of q
    #[arg(long, value_name = "Q.npy")]
    q: Option<PathBuf>,

    /// Steps of the default solver for the bound, if no q is given
    #[arg(long, value_name = "N", default_value_t = DUAL_STEPS, conflicts_with = "q", value_parser = clap::value_parser!(u64).range(0..=1_000_000_000), allow_negative_numbers = true)]
    dual_steps: u64,

    /// Also print the smoothed energy for this eps, and derive a bound from its gradient
    #[arg(long, allow_negative_numbers = true)]
    epsilon: Option<f64>,

    /// paper: (1/2) sqrt(xi + eps); intrinsic: A sqrt(|grad u|^2 + eps)
    #[arg(long, value_parser = named::<SmoothingMode>(), default_value = "intrinsic")]
    epsilon_mode: SmoothingMode,

    /// Quadrature of the data term
    #[arg(long, value_parser = named::<Mass>(), default_value = "barycentric")]
    mass: Mass,

    /// Merge vertices within this distance of each other, as `solve --weld` does [default: 0, equal positions only];
    /// merged vertices take the means of their costs and of their rows of U. Without --weld the mesh stays as it is
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
    weld: Option<f64>,

    /// What the names of files stand for, if they are in memory.
    #[arg(skip)]
    pub memory: Memory,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let smoothing = arguments
        .epsilon
        .map(|epsilon| Smoothing::new(arguments.epsilon_mode, epsilon))
        .transpose()?;
    let memory = &arguments.memory;
    let (mesh, costs) = mesh_with_costs(&arguments.mesh, &arguments.costs, arguments.on, memory)?;
    let u = labels(&arguments.u, &costs, memory)?;
    let q = arguments
        .q
        .as_deref()
        .map(|path| dual_field(path, &mesh, costs.ncols(), memory))
        .transpose()?;
    let labels = pairs::Labels { count: costs.ncols(), names: &[] };
    let metric = pairs::relaxation(arguments.pairs.as_deref(), labels, memory)?;
    let question = Question {
        lambda: arguments.lambda,
        relaxation: metric.or(arguments.relaxation).unwrap_or(arguments.on.relaxation()),
        mass: arguments.mass,
        smoothing,
        q: q.as_deref(),
        dual_steps: arguments.dual_steps,
    };
    let weld = match arguments.weld {
        Some(tolerance) => welding::weld(&mesh, tolerance)?,
        None => None,
    };
    let mut evaluation = evaluated(arguments.on, &mesh, &costs, &u, question, weld.as_ref())?;
    evaluation.warnings.extend((!evaluation.feasible).then(|| {
        format!(
            "rows of U are not in the simplex (sums differ from 1 by up to {:.1e}, the smallest entry is {:.1e}), so there is \
             no gap; clip them at 0 and divide them by their sums, in double precision",
            evaluation.largest_row_sum_error, evaluation.smallest_entry
        )
    }));
    if let Some(tolerance) = arguments.weld {
        note(&welding::note(weld.as_ref(), tolerance));
    }
    evaluation.warnings.extend(match arguments.weld {
        Some(_) => welding::aftermath(&mesh, weld.as_ref()),
        None => welding::seams(&mesh, "--weld"),
    });
    warn(&evaluation.warnings);
    print_json(&evaluation)?;
    Ok(())
}

/// Reads U, which must have the shape of the costs.
fn labels<'a>(
    path: &Path,
    costs: &Array2<f64>,
    memory: &'a Memory,
) -> Result<Cow<'a, Array2<f64>>> {
    let u = memory.matrix(path)?;
    if u.dim() == costs.dim() {
        return Ok(u);
    }
    let (rows, columns) = u.dim();
    let (needed, regions) = costs.dim();
    let message =
        format!("has {rows} x {columns} entries, but the costs have {needed} x {regions}");
    Err(Error::malformed(path, message))
}

/// Reads q, which must have two rows for each face.
fn dual_field<'a>(
    path: &Path,
    mesh: &Mesh,
    regions: usize,
    memory: &'a Memory,
) -> Result<Cow<'a, Array2<f64>>> {
    let q = memory.matrix(path)?;
    let faces = mesh.faces.len();
    if q.dim() == (2 * faces, regions) {
        return Ok(q);
    }
    let (rows, columns) = q.dim();
    let message = format!(
        "has {rows} x {columns} entries, but needs two rows for each of the {faces} faces and {regions} columns"
    );
    Err(Error::malformed(path, message))
}

/// The evaluation of U, or of its means on the welded mesh.
fn evaluated(
    on: Element,
    mesh: &Mesh,
    costs: &Array2<f64>,
    u: &Array2<f64>,
    question: Question<'_>,
    weld: Option<&Weld>,
) -> Result<Evaluation> {
    let mut progress = Progress::new(0.0);
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let evaluation = match (on, weld) {
        (Element::Faces, weld) => {
            // Faces stay what they are when vertices are merged.
            let welded = weld.map_or(mesh, |weld| &weld.mesh);
            let found = evaluate_on_faces(welded, None, costs, u, question, &mut observe)?;
            Evaluation { vertices: mesh.vertices.len(), ..found }
        }
        (Element::Vertices, Some(weld)) => {
            let weights = question.mass.weights(mesh);
            let costs = welding::costs(weld, costs, &weights)?;
            let means = welding::means(weld, u, &weights);
            let mut evaluation = evaluate(&weld.mesh, &costs, &means, question, &mut observe)?;
            evaluation.vertices = mesh.vertices.len();
            evaluation.warnings.extend(disagreement(u, &means, &weld.of));
            evaluation
        }
        (Element::Vertices, None) => evaluate(mesh, costs, u, question, &mut observe)?,
    };
    progress.finish();
    Ok(evaluation)
}

/// A warning if merged vertices have different rows of U.
fn disagreement(u: &Array2<f64>, means: &Array2<f64>, of: &[u32]) -> Option<String> {
    let differs = |(v, &k): (usize, &u32)| u.row(v) != means.row(k as usize);
    let count = of.iter().enumerate().filter(|&it| differs(it)).count();
    (count > 0).then(|| {
        format!(
            "{} from those of the vertices they are merged with; the means are evaluated",
            counted(count, "row of U differs", "rows of U differ")
        )
    })
}
