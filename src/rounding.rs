//! Labels from a relaxed U, by lowering the energy of argmax_p u_kp further.
//!
//! With two regions, the labels are optimal: the energy of labels is that of a cut of a graph, and a minimum cut needs no
//! U. With more, expansion moves lower the energy of the graph and single moves the energy itself; each accepted move lowers
//! the latter. `rounding/labels.rs` has the formulas.

mod bound;
pub(crate) mod expansion;
pub(crate) mod graph;
mod labels;
mod min_cut;
mod moves;

use pulp::bytemuck::TransparentWrapper;
use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::domain::Domain;
use crate::field::{Row, Tangent};
use crate::operator::{Operator, Stencil};
use crate::problem::{Problem, label_gap, rounded};
use crate::relaxation::Relaxation;
use crate::sweep::{collect, sum};
use bound::LabelBound;
use labels::{Cuts, Labels};

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

/// Rounds U for a problem of m regions on its domain; labels are never worse than argmax_p u_kp. Expansions end early if `go_on`
/// returns false.
pub fn round<const M: usize>(
    domain: Domain<'_>,
    problem: &Problem<Stencil, M>,
    m: usize,
    u: &[Row<M>],
    rounding: Rounding,
    go_on: &mut dyn FnMut() -> bool,
) -> Rounded {
    let argmax = collect(u.len(), |v| u[v].argmax() as u8);
    let argmax_energy = problem.energy(&rounded(u));
    let is_optimal =
        rounding == Rounding::Expansion && m == 2 && problem.is_accurate(argmax_energy);
    let unchanged = |labels| Rounded { labels, energy: argmax_energy, argmax_energy, is_optimal };
    if rounding == Rounding::Argmax {
        return unchanged(argmax);
    }
    let costs = Row::peel_slice(&problem.f).as_flattened();
    let mut state = Labels::new(domain, costs, m, cuts(problem), argmax.clone());
    match rounding {
        Rounding::Expansion if m == 2 => expansion::minimize_two(&mut state),
        Rounding::Expansion => {
            expansion::expand(&mut state, |v| u[v].max() < CERTAIN, go_on);
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

/// lambda sum_j n_j: what the cuts of labels cost, one label per unknown.
pub fn cut_energy(domain: Domain<'_>, relaxation: Relaxation, lambda: f64, labels: &[u8]) -> f64 {
    let cuts = Cuts { lambda, relaxation };
    let labels = Labels::new(domain, &[], 0, cuts, labels.to_vec());
    sum(domain.terms(), |j| labels.face_cost(j as u32, labels.face_labels(j as u32)))
}

fn cuts<K, const M: usize>(problem: &Problem<K, M>) -> Cuts {
    Cuts { lambda: problem.lambda, relaxation: problem.relaxation }
}

/// After this many ascents, and whenever their number has doubled, decoded labels are expanded. The bound is evaluated, and
/// labels are decoded, after each tenth more ascents.
const FIRST_EXPANSION: u64 = 5;

/// The ascent is over if a tenth more ascents, and at least this number, lower the gap by less than a hundredth.
const MIN_STALLED_ASCENTS: u64 = 20;

/// The result of [`tighten`].
pub struct Tightened {
    /// The best labels.
    pub rounded: Rounded,
    /// L - B: no labels have a smaller energy. Above the energy of the labels only if the computation is in error.
    pub bound: f64,
    /// Number of ascents, in both orders each.
    pub ascents: u64,
}

/// Raises a bound for labels and looks for better ones until they are within a relative gap, the bound stalls or `go_on`
/// returns false. `q` is a feasible dual field, or none.
pub fn tighten<const M: usize>(
    domain: Domain<'_>,
    problem: &Problem<Stencil, M>,
    m: usize,
    q: &[Tangent<M>],
    start: Tightened,
    gap: f64,
    go_on: &mut dyn FnMut() -> bool,
) -> Tightened {
    let costs = Row::peel_slice(&problem.f).as_flattened();
    let Tightened { mut rounded, mut bound, mut ascents } = start;
    let mut state = Labels::new(domain, costs, m, cuts(problem), rounded.labels.clone());
    let mut field = LabelBound::new(&state, reparametrization(problem, m, q));
    let (mut next, mut next_expansion) = (1, FIRST_EXPANSION);
    let mut last = (0, f64::INFINITY);
    while label_gap(rounded.energy, bound) > gap && go_on() {
        field.ascend(go_on);
        ascents += 1;
        if ascents < next {
            continue;
        }
        next += (ascents / 10).max(1);
        bound = bound.max(field.bound(&state));
        state.labels = field.decoded();
        if ascents >= next_expansion {
            next_expansion = 2 * ascents;
            expansion::expand(&mut state, |_| false, go_on);
        }
        moves::improve(&mut state);
        let one_hot = collect(state.labels.len(), |v| Row::one_hot(state.labels[v].into()));
        let energy = problem.energy(&one_hot);
        if energy < rounded.energy {
            (rounded.energy, rounded.labels) = (energy, state.labels.clone());
        }
        let present = rounded.energy - bound;
        if ascents >= last.0 + (ascents / 10).max(MIN_STALLED_ASCENTS) {
            if present > 0.99 * last.1 {
                break;
            }
            last = (ascents, present);
        }
    }
    bound = problem.clamped_bound(rounded.energy, bound);
    Tightened { rounded, bound, ascents }
}

/// y_jc = (K_jc)^T q_j: for every label it sums to zero over the corners of a face.
fn reparametrization<const M: usize>(
    problem: &Problem<Stencil, M>,
    m: usize,
    q: &[Tangent<M>],
) -> Vec<f64> {
    let faces = problem.k.faces();
    if q.is_empty() {
        return vec![0.0; 3 * m * faces];
    }
    let mut y = Vec::with_capacity(3 * m * faces);
    for (j, Tangent([q1, q2])) in q.iter().enumerate() {
        for [a, b] in problem.k.face(j).columns {
            y.extend((0..m).map(|p| q1.0[p] * a + q2.0[p] * b));
        }
    }
    y
}

#[cfg(test)]
mod tests;
