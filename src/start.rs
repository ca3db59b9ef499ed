//! Where U starts. The optimum does not depend on it; the number of iterations does.

use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::field::Row;

#[derive(Clone, Debug)]
pub enum Start {
    /// 1/m everywhere.
    Uniform,
    /// Rows drawn uniformly from the simplex, with this seed for [`Pcg64`].
    Random { seed: u64 },
    /// The region with the least cost at each vertex, the first of equals.
    Argmin,
    /// V x m; rows in the simplex.
    Given(Array2<f64>),
}

impl Start {
    /// The rows for m regions of integrated costs f; exactly zero from column m on.
    pub fn rows<const M: usize>(&self, m: usize, f: &[Row<M>]) -> Vec<Row<M>> {
        let only =
            |value: &dyn Fn(usize) -> f64| Row::from_fn(|p| if p < m { value(p) } else { 0.0 });
        match self {
            Start::Uniform => vec![only(&|_| 1.0 / m as f64); f.len()],
            Start::Argmin => f.iter().map(|f| Row::one_hot(f.argmin())).collect(),
            Start::Given(u) => crate::regions::rows(u.view()),
            Start::Random { seed } => {
                let mut rng = Pcg64::seed_from_u64(*seed);
                f.iter()
                    .map(|_| {
                        // Exponential variables over their sum are uniform on the simplex.
                        let mut row = Row::ZERO;
                        for entry in &mut row.0[..m] {
                            *entry = -(1.0 - rng.random::<f64>()).ln();
                        }
                        let sum: f64 = row.0.iter().sum();
                        if sum > 0.0 { row * (1.0 / sum) } else { only(&|_| 1.0 / m as f64) }
                    })
                    .collect()
            }
        }
    }
}
