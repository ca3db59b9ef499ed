//! Piecewise constant data: every region has one value.
//!
//!     s_p(x) = |C(x) - mu_p|^2,     mu_p = int u_p C / int u_p
//!
//! Delaunoy et al., ICCV 2009, section 3.2; the Chan-Vese model for m = 2.

use super::{Data, DataModel, RegionParameters};
use crate::field::Row;

pub struct PiecewiseConstant<'a> {
    data: &'a Data,
    /// mu_p in R^d, one per region.
    mu: Vec<Vec<f64>>,
}

impl<'a> PiecewiseConstant<'a> {
    /// Starts with the given means.
    pub fn new(data: &'a Data, mu: Vec<Vec<f64>>) -> Self {
        assert!(mu.iter().all(|mu| mu.len() == data.dimension));
        PiecewiseConstant { data, mu }
    }
}

impl<const M: usize> DataModel<M> for PiecewiseConstant<'_> {
    fn costs(&self) -> Vec<Row<M>> {
        let cost = |k: usize, mu: &[f64]| -> f64 {
            self.data.at(k).iter().zip(mu).map(|(c, mu)| (c - mu).powi(2)).sum()
        };
        (0..self.data.len())
            .map(|k| Row::from_fn(|p| self.mu.get(p).map_or(0.0, |mu| cost(k, mu))))
            .collect()
    }

    fn fit(&mut self, weights: &[Row<M>]) -> f64 {
        let total: f64 = weights.iter().map(|w| w.0.iter().sum::<f64>()).sum();
        let mut change = 0.0;
        for (p, mu) in self.mu.iter_mut().enumerate() {
            let mass: f64 = weights.iter().map(|w| w.0[p]).sum();
            if mass <= f64::EPSILON * total {
                continue;
            }
            for (i, mu) in mu.iter_mut().enumerate() {
                let sum: f64 =
                    weights.iter().enumerate().map(|(k, w)| w.0[p] * self.data.at(k)[i]).sum();
                change = f64::max(change, (sum / mass - *mu).abs());
                *mu = sum / mass;
            }
        }
        change
    }

    fn parameters(&self) -> Vec<RegionParameters> {
        self.mu.iter().map(|mu| RegionParameters { mean: mu.clone() }).collect()
    }
}
