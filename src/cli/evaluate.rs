//! `meshseg evaluate`: energies and certificate of any U, as JSON.

use std::path::PathBuf;

use meshseg::evaluate::evaluate;
use meshseg::operator::Mass;
use meshseg::problem::{Smoothing, SmoothingMode};
use meshseg::{Error, npy};

use super::inputs::mesh_with_costs;
use super::{Outcome, named, print_json, warn, welding};

/// Print the energies, the lower bound and the rounding of any U as JSON.
///
/// The bound comes from the gradient of the smoothed total variation at U, so it holds whoever computed U.
#[derive(clap::Args)]
#[command(after_help = "Example:
  meshseg evaluate mesh.ply --costs S.npy --lambda 0.005 --u results/mesh/u.npy --epsilon 0.01")]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// Pointwise costs, V x m
    #[arg(long, value_name = "S.npy")]
    costs: PathBuf,

    /// Weight of the total variation
    #[arg(long, allow_negative_numbers = true)]
    lambda: f64,

    /// V x m
    #[arg(long, value_name = "U.npy")]
    u: PathBuf,

    /// Also print the smoothed energy with this eps
    #[arg(long, allow_negative_numbers = true)]
    epsilon: Option<f64>,

    /// paper: (1/2) sqrt(xi + eps); intrinsic: A sqrt(|grad u|^2 + eps)
    #[arg(long, value_parser = named(&SmoothingMode::NAMES), default_value = "intrinsic")]
    epsilon_mode: SmoothingMode,

    /// Quadrature of the data term
    #[arg(long, value_parser = named(&Mass::NAMES), default_value = "barycentric")]
    mass: Mass,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let smoothing = arguments
        .epsilon
        .map(|epsilon| Smoothing::new(arguments.epsilon_mode, epsilon))
        .transpose()?;
    let (mesh, costs) = mesh_with_costs(&arguments.mesh, &arguments.costs)?;
    let u = npy::read_matrix(&arguments.u)?;
    if u.dim() != costs.dim() {
        let (rows, columns) = u.dim();
        let (needed, regions) = costs.dim();
        let message =
            format!("has {rows} x {columns} entries, the costs have {needed} x {regions}");
        return Err(Error::malformed(&arguments.u, message).into());
    }
    let mut evaluation = evaluate(&mesh, &costs, &u, arguments.lambda, arguments.mass, smoothing)?;
    let seams = welding::seams(&mesh, welding::CONVERT);
    warn(&seams);
    evaluation.warnings.extend(seams);
    print_json(&evaluation)?;
    Ok(())
}
