//! The convex problem, its smoothing, and the bound that certifies any answer to it.
//!
//! ```text
//! E(U)     = sum_k <u_k, f_k> + lambda sum_j |(K U)_j|,      rows of U in the simplex
//! D(q)     = sum_k min_p ( f_k + (K^T q)_k )_p,               |q_j| <= lambda
//! E_eps(U) = sum_k <u_k, f_k> + lambda sum_j sqrt( |(K U)_j|^2 + eps_j^2 )
//! ```
//!
//! D(q) <= E* <= E(U) for every feasible pair. Delaunoy et al., ICCV 2009, equations (7) and (9).
//!
//! No labels cost less than B = sum_k min_p f_kp, and a constant that is added to all costs of a vertex changes B
//! alone. A problem therefore keeps f_k - min_p f_kp and B apart: its energies and bounds are E - B and D - B,
//! `relative_gap` is (E - D) / (E - B), and nothing that is decided or claimed depends on such a constant.

use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator};
use crate::sweep::{collect, sum, sum_blocks, sweep};

/// Costs of regions that only fill up a row to its compiled length. It stands for +infinity, which is
/// no number to multiply by zero; u is exactly zero there from the start to the end.
pub const FORBIDDEN: f64 = 1e300;

pub struct Problem<K, const M: usize> {
    pub k: K,
    /// Integrated costs above the least of their row, one row per vertex.
    pub f: Vec<Row<M>>,
    /// B, the sum of these least costs: all energies and bounds below are measured from here.
    pub baseline: f64,
    /// Weight of the total variation, in units of cost times length; not negative.
    pub lambda: f64,
    /// The sum of the lengths of all columns K_jk: no K^T q is larger than lambda times this.
    columns: f64,
}

impl<K: Operator, const M: usize> Problem<K, M> {
    /// For integrated costs f. Panics if the sizes do not fit or lambda is negative or not finite.
    pub fn new(k: K, f: Vec<Row<M>>, lambda: f64) -> Self {
        assert!(lambda >= 0.0 && lambda.is_finite());
        let columns = sum(
            k.faces(),
            #[inline(always)]
            |j| k.face(j).columns.iter().map(|[x, y]| x.abs() + y.abs()).sum(),
        );
        let mut problem = Problem { k, f: Vec::new(), baseline: 0.0, lambda, columns };
        problem.set_costs(f);
        problem
    }

    /// Other integrated costs take the place of f.
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
                let least = f.min();
                *f = Row::from_fn(|p| if f.0[p] == FORBIDDEN { FORBIDDEN } else { f.0[p] - least });
            },
        );
        self.f = f;
    }

    /// sum_k <u_k, f_k> - B.
    pub fn data_term(&self, u: &[Row<M>]) -> f64 {
        sum(
            u.len(),
            #[inline(always)]
            |v| u[v].dot(self.f[v]),
        )
    }

    /// sum_j |(K U)_j|, in units of length.
    pub fn total_variation(&self, u: &[Row<M>]) -> f64 {
        sum_blocks(
            self.k.faces(),
            #[inline(always)]
            |first, norms| self.k.norms(u, first, norms),
        )
    }

    /// E(U) - B.
    pub fn energy(&self, u: &[Row<M>]) -> f64 {
        self.data_term(u) + self.lambda * self.total_variation(u)
    }

    /// E_eps(U) - B.
    pub fn smoothed_energy(&self, u: &[Row<M>], smoothing: Smoothing) -> f64 {
        let variation = sum(
            self.k.faces(),
            #[inline(always)]
            |j| smoothing.norm(self.k.at(u, j), self.k.area(j)),
        );
        self.data_term(u) + self.lambda * variation
    }

    /// D(q) - B; a lower bound of every E(U) - B if |q_j| <= lambda for all j.
    pub fn dual_bound(&self, q: &[Tangent<M>]) -> f64 {
        let kt = self.k.adjoint();
        sum(
            self.f.len(),
            #[inline(always)]
            |v| (self.f[v] + kt.at(q, v)).min(),
        )
    }

    /// sum_k (max_p f_kp - min_p f_kp): how much the choice of the regions can weigh.
    pub fn spread(&self) -> f64 {
        sum(
            self.f.len(),
            #[inline(always)]
            |v| {
                let f = self.f[v];
                Row::<M>::from_fn(|p| if f.0[p] == FORBIDDEN { 0.0 } else { f.0[p] }).max()
            },
        )
    }

    /// The mean over the vertices of the sum of the lengths of their columns K_jk: lambda times that is what the total
    /// variation can ask of a vertex.
    pub(crate) fn mean_column(&self) -> f64 {
        self.columns / self.f.len() as f64
    }

    /// The bound, or the energy where rounding alone puts the bound above it: by no more than a small multiple of the
    /// unit roundoff times the sizes of all terms that the two sum up. Costs that are not paid do not count.
    pub fn settled(&self, energy: f64, bound: f64) -> f64 {
        let rounding = 64.0 * f64::EPSILON * (energy + self.lambda * self.columns);
        if bound > energy && bound - energy <= rounding { energy } else { bound }
    }
}

/// How the norm in the total variation is made differentiable.
///
/// Never compare E_eps with E: only E is the energy, E_eps lies above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    pub mode: SmoothingMode,
    /// eps, positive; squared length for `Paper`, inverse squared length for `Intrinsic`.
    pub epsilon: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum SmoothingMode {
    /// lambda A_j sqrt(|grad_j U|^2 + eps): the same for every resolution, with a bias of at most
    /// lambda sqrt(eps) times the area.
    Intrinsic,
    /// (lambda/2) sqrt(xi + eps), xi = 4 |(K U)_j|^2, as equations (7) and (9) print it. Its bias depends
    /// on the mesh.
    Paper,
}

/// sqrt(eps) times the square root of the area, unless something else is asked for. On a torus of 20,000 to
/// 200,000 faces with noisy data the energy of the smoothed minimizer is then about 3e-4 above the least.
const DEFAULT_SMOOTHNESS: f64 = 0.3;

impl Smoothing {
    /// Refuses an eps that is not a positive number.
    pub fn new(mode: SmoothingMode, epsilon: f64) -> Result<Self> {
        if epsilon > 0.0 && epsilon.is_finite() {
            Ok(Smoothing { mode, epsilon })
        } else {
            Err(Error::unsuitable(format!("epsilon = {epsilon}: must be a positive number")))
        }
    }

    /// An eps that suits the mesh, whatever its units.
    pub fn default_for(k: &impl Operator, mode: SmoothingMode) -> Self {
        let area = sum(k.faces(), |j| k.area(j));
        let root = DEFAULT_SMOOTHNESS / area.sqrt();
        let epsilon = match mode {
            SmoothingMode::Intrinsic => root.powi(2),
            SmoothingMode::Paper => (2.0 * root * area / k.faces() as f64).powi(2),
        };
        Smoothing { mode, epsilon }
    }

    /// eps_j: what the norm |(K U)_j| is rounded off by, in units of length.
    #[inline(always)]
    pub fn radius(self, area: f64) -> f64 {
        match self.mode {
            SmoothingMode::Paper => 0.5 * self.epsilon.sqrt(),
            SmoothingMode::Intrinsic => area * self.epsilon.sqrt(),
        }
    }

    /// sqrt( |(K U)_j|^2 + eps_j^2 ).
    #[inline(always)]
    pub fn norm<const M: usize>(self, ku: Tangent<M>, area: f64) -> f64 {
        (ku.norm_squared() + self.radius(area).powi(2)).sqrt()
    }

    /// The gradient of lambda times that norm by (K U)_j. It lies in the ball |q_j| <= lambda, so a
    /// smoothed method owns a certificate: dE_eps/dU = f + K^T q, and D(q) bounds every energy.
    #[inline(always)]
    pub fn dual<const M: usize>(self, ku: Tangent<M>, area: f64, lambda: f64) -> Tangent<M> {
        ku * (lambda / self.norm(ku, area))
    }
}

/// (E - D) / (E - B), for E - B and D - B: at most this share of what labels cost beyond B can be saved; nothing where
/// they cost B, or where energy and bound are equal.
pub fn relative_gap(energy: f64, bound: f64) -> f64 {
    if energy == 0.0 || energy == bound { 0.0 } else { (energy - bound) / energy }
}

/// (R - D) / (D - B), for R - B and D - B: labels of energy R are at most this share above any labeling L, since
/// (R - L) / (L - B) is no larger where L >= D. Infinite where the bound says no more than B does.
pub fn label_gap(rounded_energy: f64, bound: f64) -> f64 {
    if rounded_energy == 0.0 || rounded_energy == bound {
        0.0
    } else if bound <= 0.0 {
        f64::INFINITY
    } else {
        (rounded_energy - bound) / bound
    }
}

/// Labels as a field: the one-hot rows of argmax_p u_kp.
pub fn rounded<const M: usize>(u: &[Row<M>]) -> Vec<Row<M>> {
    collect(
        u.len(),
        #[inline(always)]
        |v| Row::one_hot(u[v].argmax()),
    )
}

#[cfg(test)]
mod tests;
