//! The initial U. The optimum does not depend on it; the number of iterations does.

use ndarray::{Array2, ArrayView1};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::order::Order;
use crate::problem::FORBIDDEN_COST;
use crate::prox::project_simplex;
use crate::sweep::{collect, sweep};

/// The initial U. Forbidden labels never get any mass.
#[derive(Clone, Debug)]
pub enum Start {
    /// 1/m everywhere.
    Uniform,
    /// Rows drawn uniformly from the simplex by [`Pcg64`].
    Random {
        /// The seed; the same seed gives the same rows with any number of threads.
        seed: u64,
    },
    /// The cheapest region at each vertex, the first one in case of ties.
    Argmin,
    /// A given U: V x m, rows in the simplex.
    Given(Array2<f64>),
}

/// How far a given row may lie off the simplex, to allow for single precision.
const OFF_SIMPLEX: f64 = 1e-5;

impl Start {
    /// Fails if a given U has another shape than `dim`, V x m, or a row off the simplex by more than 1e-5.
    pub fn check(&self, dim: (usize, usize)) -> Result<()> {
        let Start::Given(u) = self else { return Ok(()) };
        if u.dim() != dim {
            return Err(Error::unsuitable(format!(
                "the initial U has {} x {} entries, but the costs have {} x {}; both must be V x m",
                u.nrows(),
                u.ncols(),
                dim.0,
                dim.1
            )));
        }
        let off = |row: ArrayView1<f64>| {
            let sums = (row.sum() - 1.0).abs() <= OFF_SIMPLEX;
            !(sums && row.iter().all(|&x| x >= -OFF_SIMPLEX))
        };
        match u.outer_iter().position(off) {
            None => Ok(()),
            Some(k) => Err(Error::unsuitable(format!(
                "row {k} of the initial U is not in the simplex; its entries must be non-negative and sum to 1"
            ))),
        }
    }

    /// The initial rows for m regions and integrated costs f, whose vertices are in the given order; exactly zero from
    /// column m on and at forbidden labels.
    pub fn rows<const M: usize>(&self, m: usize, f: &[Row<M>], order: &Order) -> Vec<Row<M>> {
        let only =
            |value: &dyn Fn(usize) -> f64| Row::from_fn(|p| if p < m { value(p) } else { 0.0 });
        match self {
            Start::Uniform => {
                collect(f.len(), |v| without_forbidden(only(&|_| 1.0 / m as f64), &f[v]))
            }
            Start::Argmin => cheapest_labels(f),
            Start::Given(u) => {
                let rows = order.applied(crate::regions::rows::<M>(u.view()));
                collect(rows.len(), |v| {
                    let active = |p: usize| p < m && f[v].0[p] < FORBIDDEN_COST;
                    project_simplex(Row::from_fn(|p| {
                        if active(p) { rows[v].0[p] } else { -FORBIDDEN_COST }
                    }))
                })
            }
            Start::Random { seed } => {
                let mut rng = Pcg64::seed_from_u64(*seed);
                let rows = f
                    .iter()
                    .map(|_| {
                        // Exponential variables divided by their sum are uniform on the simplex: L. Devroye,
                        // *Non-Uniform Random Variate Generation*, 1986, chapter V.
                        let mut row = Row::ZERO;
                        for entry in &mut row.0[..m] {
                            *entry = -(1.0 - rng.random::<f64>()).ln();
                        }
                        let sum: f64 = row.0.iter().sum();
                        if sum > 0.0 { row * (1.0 / sum) } else { only(&|_| 1.0 / m as f64) }
                    })
                    .collect();
                let rows = order.applied(rows);
                collect(rows.len(), |v| without_forbidden(rows[v], &f[v]))
            }
        }
    }
}

/// The one-hot rows of argmin_p f_kp: the cheapest label at each vertex.
pub fn cheapest_labels<const M: usize>(f: &[Row<M>]) -> Vec<Row<M>> {
    collect(
        f.len(),
        #[inline(always)]
        |v| Row::one_hot(f[v].argmin()),
    )
}

/// A row of the simplex without its mass at labels that f forbids, rescaled to sum to 1; the cheapest label if nothing
/// is left.
pub fn without_forbidden<const M: usize>(u: Row<M>, f: &Row<M>) -> Row<M> {
    let forbidden = |p: usize| f.0[p] == FORBIDDEN_COST;
    if (0..M).all(|p| !forbidden(p) || u.0[p] == 0.0) {
        return u;
    }
    let kept = Row::from_fn(|p| if forbidden(p) { 0.0 } else { u.0[p] });
    let sum: f64 = kept.0.iter().sum();
    if sum > 0.0 { kept * (1.0 / sum) } else { Row::one_hot(f.argmin()) }
}

/// Removes the mass at labels that f forbids, which P u of a coarser mesh may give to a finer vertex.
pub fn remove_forbidden<const M: usize>(u: &mut [Row<M>], f: &[Row<M>]) {
    sweep((u, f), |_, (u, f)| *u = without_forbidden(*u, f));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regions::pad_costs;
    use crate::samples::{random_rows, rng, shape};

    fn as_it_is() -> Order {
        Order::of(&shape("grid:2x2"))
    }

    fn costs() -> Vec<Row<12>> {
        let mut f = random_rows(2000, &mut rng(131));
        pad_costs(9, &mut f);
        f
    }

    #[test]
    fn every_start_lies_in_the_simplex_of_the_allowed_labels() {
        let mut f = costs();
        for (k, f) in f.iter_mut().enumerate() {
            (0..8).filter(|p| (k >> p) & 1 == 1).for_each(|p| f.0[p] = FORBIDDEN_COST);
        }
        let given = Array2::from_shape_fn((f.len(), 9), |(k, p)| f64::from(k % 9 == p));
        let starts =
            [Start::Uniform, Start::Random { seed: 4 }, Start::Argmin, Start::Given(given)];
        for start in starts {
            for (u, f) in start.rows::<12>(9, &f, &as_it_is()).into_iter().zip(&f) {
                assert!((0..12).all(|p| f.0[p] < FORBIDDEN_COST || u.0[p] == 0.0), "{start:?}");
                assert!((u.0.iter().sum::<f64>() - 1.0).abs() <= 1e-14, "{start:?}");
                assert!(u.min() >= 0.0 && u.0[9..] == [0.0; 3], "{start:?}");
            }
        }
    }

    #[test]
    fn argmin_is_the_cheapest_region() {
        let f = costs();
        for (u, f) in Start::Argmin.rows::<12>(9, &f, &as_it_is()).iter().zip(&f) {
            assert_eq!(u.dot(*f), f.min());
        }
    }

    /// For the uniform distribution on the simplex with 9 vertices, each entry has mean 1/9 and variance 8 / (81 * 10).
    #[test]
    fn random_rows_are_uniform_on_the_simplex() {
        let f = costs();
        let drawn = |seed| Start::Random { seed }.rows::<12>(9, &f, &as_it_is());
        let rows = drawn(7);
        assert_eq!(rows, drawn(7));
        assert_ne!(rows, drawn(8));
        for p in 0..9 {
            let n = rows.len() as f64;
            let mean = rows.iter().map(|u| u.0[p]).sum::<f64>() / n;
            let variance = rows.iter().map(|u| (u.0[p] - mean).powi(2)).sum::<f64>() / n;
            assert!((mean - 1.0 / 9.0).abs() < 0.01, "{mean}");
            assert!((variance / (8.0 / 810.0) - 1.0).abs() < 0.2, "{variance}");
        }
    }
}
