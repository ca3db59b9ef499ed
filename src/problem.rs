//! The convex problem, its smoothing, and the dual bound that certifies its solutions.
//!
//! ```text
//! E(U)     = sum_k <u_k, f_k> + lambda sum_j |(K U)_j|,      rows of U in the simplex
//! D(q)     = sum_k min_p ( f_k + (K^T q)_k )_p,               |q_j| <= lambda
//! E_eps(U) = sum_k <u_k, f_k> + lambda sum_j sqrt( |(K U)_j|^2 + eps_j^2 )
//! ```
//!
//! D(q) <= E* <= E(U) for every feasible pair. Delaunoy et al., ICCV 2009, equations (7) and (9). This is for the norm of all
//! regions together; `relaxation.rs` has the sets of q_j, and the energies, of all relaxations.
//!
//! No labels have an energy below B = sum_k min_p f_kp, and a constant added to all costs of a vertex changes only B. A
//! problem therefore stores f_k - min_p f_kp and B separately: its energies and bounds are E - B and D - B,
//! `relative_gap` is (E - D) / (E - B), and no decision and no claim depends on such a constant.

use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::relaxation::{DualSet, Relaxation, with_set};
use crate::sweep::{collect, sum, sum_blocks, sweep};

/// The cost of forbidden labels and of padding regions, which only fill up a row to its compiled length. It stands for
/// +infinity, whose product with zero is NaN; u is exactly zero there throughout.
pub const FORBIDDEN_COST: f64 = 1e300;

/// The convex problem: minimize E over U in the simplex, for an operator K and compiled rows of M regions. Padding
/// regions cost [`FORBIDDEN_COST`].
pub struct Problem<K, const M: usize> {
    /// The gradient, for F faces and V vertices.
    pub k: K,
    /// Integrated costs minus the minimum of their row, one row per vertex.
    pub f: Vec<Row<M>>,
    /// B, the sum of these minima: all energies and bounds below are measured from here.
    pub baseline: f64,
    /// Weight of the total variation, in units of cost times length; not negative.
    pub lambda: f64,
    /// The set in which each q_j lives, and with it the energy of a face.
    pub relaxation: Relaxation,
    /// The sum of the lengths of all columns K_jk; lambda times this bounds the sum of all |(K^T q)_k|.
    total_column_length: f64,
}

impl<K: Operator, const M: usize> Problem<K, M> {
    /// The problem with integrated costs f, in the relaxation of the paper. Panics if the sizes do not fit or lambda is negative or not finite.
    pub fn new(k: K, f: Vec<Row<M>>, lambda: f64) -> Self {
        assert!(lambda >= 0.0 && lambda.is_finite());
        let total_column_length = sum(
            k.faces(),
            #[inline(always)]
            |j| k.face(j).columns.iter().map(|[x, y]| x.abs() + y.abs()).sum(),
        );
        let relaxation = Relaxation::Frobenius;
        let mut problem =
            Problem { k, f: Vec::new(), baseline: 0.0, lambda, relaxation, total_column_length };
        problem.set_costs(f);
        problem
    }

    /// The same problem in another relaxation.
    pub fn in_relaxation(self, relaxation: Relaxation) -> Self {
        Problem { relaxation, ..self }
    }

    /// Replaces the integrated costs f, and the baseline by their B. Panics unless there are V rows.
    pub fn set_costs(&mut self, mut f: Vec<Row<M>>) {
        assert_eq!(f.len(), self.k.vertices());
        self.baseline = sum(
            f.len(),
            #[inline(always)]
            |v| f[v].min(),
        );
        sweep(
            &mut f[..],
            #[inline(always)]
            |_, f| {
                let minimum = f.min();
                *f = Row::from_fn(|p| {
                    if f.0[p] == FORBIDDEN_COST { FORBIDDEN_COST } else { f.0[p] - minimum }
                });
            },
        );
        self.f = f;
    }

    /// sum_k <u_k, f_k> - B, for V rows that sum to 1.
    pub fn data_term(&self, u: &[Row<M>]) -> f64 {
        sum(
            u.len(),
            #[inline(always)]
            |v| u[v].dot(self.f[v]),
        )
    }

    /// sum_j |(K U)_j|, in units of length, in the norm of the relaxation.
    pub fn total_variation(&self, u: &[Row<M>]) -> f64 {
        with_set!(self.relaxation, set => sum_blocks(
            self.k.faces(),
            #[inline(always)]
            |first, norms| self.k.norms(set, u, first, norms),
        ))
    }

    /// E(U) - B.
    pub fn energy(&self, u: &[Row<M>]) -> f64 {
        self.data_term(u) + self.lambda * self.total_variation(u)
    }

    /// E_eps(U) - B.
    pub fn smoothed_energy(&self, u: &[Row<M>], smoothing: Smoothing) -> f64 {
        let variation = with_set!(self.relaxation, set => sum(
            self.k.faces(),
            #[inline(always)]
            |j| set.smoothed(self.k.at(u, j), smoothing.radius(self.k.area(j))),
        ));
        self.data_term(u) + self.lambda * variation
    }

    /// Writes the gradient of the smoothed total variation at U, q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 ) for the
    /// norm of all regions together. It is feasible, so a smoothed method has a certificate: dE_eps/dU = f + K^T q, and D(q)
    /// bounds every energy.
    pub fn smoothed_dual(&self, u: &[Row<M>], smoothing: Smoothing, q: &mut [Tangent<M>]) {
        let Problem { k, lambda, .. } = self;
        with_set!(self.relaxation, set => sweep(
            q,
            #[inline(always)]
            |j, q| *q = set.smoothed_dual(k.at(u, j), smoothing.radius(k.area(j)), *lambda),
        ));
    }

    /// Makes a field of any origin feasible. For the relaxations in which only the differences q_ja - q_jb count, infeasible
    /// ones are first centered, over the regions that are allowed anywhere.
    pub fn make_feasible(&self, q: &mut [Tangent<M>]) {
        let lambda = self.lambda;
        let center = self.relaxation != Relaxation::Frobenius;
        let exists: [bool; M] =
            std::array::from_fn(|p| center && self.f.iter().any(|f| f.0[p] != FORBIDDEN_COST));
        let count = exists.iter().filter(|exists| **exists).count() as f64;
        with_set!(self.relaxation, set => sweep(q, |_, q| {
            if center && set.gauge(*q) > lambda * (1.0 + 1e-12) {
                for row in &mut q.0 {
                    let sum: f64 = (0..M).filter(|&p| exists[p]).map(|p| row.0[p]).sum();
                    *row = Row::from_fn(|p| if exists[p] { row.0[p] - sum / count } else { 0.0 });
                }
            }
            *q = set.project(*q, lambda);
        }));
    }

    /// D(q) - B, a lower bound on every E(U) - B if each q_j is in the set of the relaxation.
    pub fn dual_bound(&self, q: &[Tangent<M>]) -> f64 {
        let kt = self.k.adjoint();
        sum(
            self.f.len(),
            #[inline(always)]
            |v| (self.f[v] + kt.at(q, v)).min(),
        )
    }

    /// sum_k (max_p f_kp - min_p f_kp): how much the choice of labels can change the data term.
    pub fn spread(&self) -> f64 {
        sum(
            self.f.len(),
            #[inline(always)]
            |v| {
                let f = self.f[v];
                Row::<M>::from_fn(|p| if f.0[p] == FORBIDDEN_COST { 0.0 } else { f.0[p] }).max()
            },
        )
    }

    /// The mean over the vertices of the sum of the lengths of their columns K_jk: lambda times this is how much the
    /// total variation can weigh at a vertex.
    pub(crate) fn mean_column(&self) -> f64 {
        self.total_column_length / self.f.len() as f64
    }

    /// What rounding can change in sums of costs and cuts.
    fn rounding(&self, energy: f64) -> f64 {
        let weight = self.lambda * self.relaxation.label_metric().largest();
        64.0 * f64::EPSILON * (energy + weight * self.total_column_length)
    }

    /// Whether sums of costs and cuts determine this energy to nine digits: cuts do not absorb the costs.
    pub fn is_accurate(&self, energy: f64) -> bool {
        self.rounding(energy) <= 1e-9 * energy
    }

    /// The bound, clamped to the energy if it exceeds it by no more than rounding can cause: a small multiple of the
    /// unit roundoff times the sizes of all terms in the two sums. Costs of labels that U does not use are not among
    /// these.
    pub fn clamped_bound(&self, energy: f64, bound: f64) -> f64 {
        if bound > energy && bound - energy <= self.rounding(energy) { energy } else { bound }
    }
}

/// How the norm in the total variation is made differentiable.
///
/// E_eps must not be compared with E: it lies above E, and only E is the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// The formula of eps_j.
    pub mode: SmoothingMode,
    /// eps, positive; squared length for `Paper`, inverse squared length for `Intrinsic`.
    pub epsilon: f64,
}

/// The formula of eps_j, see [`Smoothing::radius`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum SmoothingMode {
    /// lambda A_j sqrt(|grad_j U|^2 + eps): independent of the resolution, with a bias of at most lambda sqrt(eps)
    /// times the area.
    Intrinsic,
    /// (lambda/2) sqrt(xi + eps), xi = 4 |(K U)_j|^2, as printed in equations (7) and (9). Its bias depends
    /// on the mesh.
    Paper,
}

/// sqrt(eps) times the square root of the area, by default. On a torus of 20,000 to 200,000 faces with noisy data, the
/// energy of the smoothed minimizer is then about 3e-4 above the minimum.
const DEFAULT_SMOOTHNESS: f64 = 0.3;

impl Smoothing {
    /// The smoothing with a given eps. Fails unless eps is positive and finite.
    pub fn new(mode: SmoothingMode, epsilon: f64) -> Result<Self> {
        if epsilon > 0.0 && epsilon.is_finite() {
            Ok(Smoothing { mode, epsilon })
        } else {
            Err(Error::unsuitable(format!(
                "epsilon = {epsilon}: must be a positive, finite number"
            )))
        }
    }

    /// An eps that suits the mesh, whatever its units: sqrt(eps) = 0.3 / sqrt(area) for `Intrinsic`, and for `Paper`
    /// the one with the same eps_j on a face of mean area.
    pub fn default_for(k: &impl Operator, mode: SmoothingMode) -> Self {
        let area = sum(k.faces(), |j| k.area(j));
        let root = DEFAULT_SMOOTHNESS / area.sqrt();
        let epsilon = match mode {
            SmoothingMode::Intrinsic => root.powi(2),
            SmoothingMode::Paper => (2.0 * root * area / k.faces() as f64).powi(2),
        };
        Smoothing { mode, epsilon }
    }

    /// eps_j, the radius within which the norm |(K U)_j| is rounded off, in units of length.
    #[inline(always)]
    pub fn radius(self, area: f64) -> f64 {
        match self.mode {
            SmoothingMode::Paper => 0.5 * self.epsilon.sqrt(),
            SmoothingMode::Intrinsic => area * self.epsilon.sqrt(),
        }
    }
}

/// (E - D) / (E - B), for E - B and D - B: at most this fraction of the energy above B can be saved. It is 0 where E =
/// B or E = D.
pub fn relative_gap(energy: f64, bound: f64) -> f64 {
    if energy == 0.0 || energy == bound { 0.0 } else { (energy - bound) / energy }
}

/// (R - D) / (D - B), for R - B and D - B: labels of energy R are at most this fraction above any labeling L, since
/// (R - L) / (L - B) is no larger for L >= D. Infinite where the bound is B.
pub fn label_gap(rounded_energy: f64, bound: f64) -> f64 {
    if rounded_energy == 0.0 || rounded_energy == bound {
        0.0
    } else if bound <= 0.0 {
        f64::INFINITY
    } else {
        (rounded_energy - bound) / bound
    }
}

/// Rounded labels: the one-hot rows of argmax_p u_kp.
pub fn rounded<const M: usize>(u: &[Row<M>]) -> Vec<Row<M>> {
    collect(
        u.len(),
        #[inline(always)]
        |v| Row::one_hot(u[v].argmax()),
    )
}

#[cfg(test)]
mod tests;
