//! The density of a region: masses of bins, their fit, and how far two of them differ.

use serde::{Deserialize, Serialize};

use super::grid::Grid;
use crate::error::{Error, Result};

/// The bins share at least this mass equally. Without such a floor data in bins that a region has not yet seen would have
/// an infinite cost.
pub const FLOOR: f64 = 0.02;

/// D_p, on the bins of the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frequencies {
    /// The mean of the data of the region, of which those outside the range of the bins count as at its ends: d numbers, in
    /// the units of the data.
    pub mean: Vec<f64>,
    /// The lowest and the highest value of the bins, for each of d coordinates.
    pub range: Vec<[f64; 2]>,
    /// The number of bins of equal width, for each of d coordinates; 1 where the data do not vary.
    pub bins: Vec<usize>,
    /// The mass of each bin, the last coordinate fastest; their sum is 1. The density is mass / volume of a bin.
    pub mass: Vec<f64>,
}

impl Frequencies {
    /// The parameters of minimum cost for these masses of the data in the bins, whose sum is positive.
    pub fn fitted(grid: &Grid, sums: Vec<f64>) -> Self {
        let total: f64 = sums.iter().sum();
        let mut mean = vec![0.0; grid.dimension()];
        for (b, w) in sums.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            mean.iter_mut().zip(grid.center(b)).for_each(|(mean, c)| *mean += w / total * c);
        }
        Frequencies { mean, range: grid.ranges(), bins: grid.bins(), mass: masses(grid, sums) }
    }

    /// Fails with a message if these are no masses of the bins of this grid.
    pub fn check(&self, grid: &Grid) -> std::result::Result<(), &'static str> {
        if self.range != grid.ranges() || self.bins != grid.bins() {
            return Err("the histogram has other bins than these data");
        }
        if self.mass.len() != grid.len() {
            return Err("the histogram must have a mass for each of its bins");
        }
        if !self.mass.iter().all(|x| x.is_normal() && *x > 0.0) {
            return Err("the masses of the bins must be positive");
        }
        let total: f64 = self.mass.iter().sum();
        if (total - 1.0).abs() > 1e-6 {
            return Err("the masses of the bins must have the sum 1");
        }
        Ok(())
    }
}

/// F counts / |counts| with its small entries raised to the floor: the masses D of sum 1, D_b >= FLOOR / bins, that
/// minimize - sum_b (F counts)_b log D_b.
///
/// By the conditions of optimality D_b = max(FLOOR / bins, t (F counts)_b). Bins at the floor have more than their share,
/// which lowers t, so that more of them may follow, until t is that of the sum 1.
pub fn masses(grid: &Grid, mut counts: Vec<f64>) -> Vec<f64> {
    grid.smooth(&mut counts);
    let floor = FLOOR / counts.len() as f64;
    let mut t = 1.0 / counts.iter().sum::<f64>();
    loop {
        let above = || counts.iter().filter(|&&x| t * x > floor);
        let raised = counts.len() - above().count();
        let next = (1.0 - floor * raised as f64) / above().sum::<f64>();
        if next >= t {
            break;
        }
        t = next;
    }
    counts.iter_mut().for_each(|x| *x = f64::max(floor, t * *x));
    counts
}

/// F(-log density) for the centers of the bins.
pub fn costs(grid: &Grid, mass: &[f64]) -> Vec<f64> {
    let log_volume = grid.log_volume();
    let mut costs: Vec<f64> = mass.iter().map(|mass| -mass.ln()).collect();
    grid.smooth(&mut costs);
    costs.iter_mut().for_each(|s| *s += log_volume);
    costs
}

/// The Hellinger distance, from 0 to 1:
///
/// ```text
/// H^2 = 1 - sum_b sqrt(a_b b_b) = (1/2) sum_b (sqrt a_b - sqrt b_b)^2
/// ```
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a.sqrt() - b.sqrt()).powi(2));
    (0.5 * squares.sum::<f64>()).sqrt()
}

/// Checks the masses of all regions.
pub fn check(grid: &Grid, mu: &[Frequencies]) -> Result<()> {
    for (p, mu) in mu.iter().enumerate() {
        mu.check(grid).map_err(|why| Error::unsuitable(format!("region {p}: {why}")))?;
    }
    Ok(())
}
