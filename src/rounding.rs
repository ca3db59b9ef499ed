//! Labels from a relaxed U, by lowering the energy of argmax_p u_kp further.
//!
//! With two regions, the labels are optimal: the energy of labels is that of a cut of a graph, and a minimum cut needs no
//! U. With more, expansion moves lower the energy of the graph and single moves the energy itself; each accepted move lowers
//! the latter. `rounding/labels.rs` has the formulas.

mod expansion;
mod labels;
mod min_cut;
mod moves;

use pulp::bytemuck::TransparentWrapper;
use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::Stencil;
use crate::problem::{Problem, rounded};
use crate::sweep::collect;
use labels::Labels;

/// How U is rounded to labels.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames,
)]
#[strum(serialize_all = "lowercase")]
pub enum Rounding {
    /// A minimum cut for two regions; for more, expansion moves, then single moves, from argmax_p u_kp.
    #[default]
    Expansion,
    /// Single moves from argmax_p u_kp.
    Moves,
    /// argmax_p u_kp.
    Argmax,
}

/// A vertex with all entries of u below this may change its label anywhere.
const CERTAIN: f64 = 0.99;

/// Labels and their energies.
pub struct Rounded {
    /// One per vertex.
    pub labels: Vec<u8>,
    /// R - B.
    pub energy: f64,
    /// R - B of argmax_p u_kp.
    pub argmax_energy: f64,
    /// Whether no labels have a smaller energy.
    pub is_optimal: bool,
}

/// Rounds U for a problem of m regions on a mesh; labels are never worse than argmax_p u_kp.
pub fn round<const M: usize>(
    mesh: &Mesh,
    problem: &Problem<Stencil, M>,
    m: usize,
    u: &[Row<M>],
    rounding: Rounding,
) -> Rounded {
    let argmax = collect(u.len(), |v| u[v].argmax() as u8);
    let argmax_energy = problem.energy(&rounded(u));
    let is_optimal = rounding == Rounding::Expansion && m == 2;
    let unchanged = |labels| Rounded { labels, energy: argmax_energy, argmax_energy, is_optimal };
    if rounding == Rounding::Argmax {
        return unchanged(argmax);
    }
    let costs = Row::peel_slice(&problem.f).as_flattened();
    let mut state = Labels::new(mesh, costs, m, problem.lambda, argmax.clone());
    match rounding {
        Rounding::Expansion if m == 2 => expansion::minimize_two(&mut state),
        Rounding::Expansion => {
            expansion::expand(&mut state, |v| u[v].max() < CERTAIN);
            moves::improve(&mut state);
        }
        Rounding::Moves | Rounding::Argmax => moves::improve(&mut state),
    }
    let labels = state.labels;
    if labels == argmax {
        return unchanged(argmax);
    }
    let energy = problem.energy(&collect(labels.len(), |v| Row::one_hot(labels[v].into())));
    if energy > argmax_energy {
        // Equal but for rounding errors.
        return unchanged(argmax);
    }
    Rounded { labels, energy, argmax_energy, is_optimal }
}

#[cfg(test)]
mod tests;
