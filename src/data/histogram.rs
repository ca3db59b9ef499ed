//! Data with any density in each region: smoothed histograms.
//!
//! ```text
//! s_p(x) = sum_b phi_b(C(x)) s_pb,     s_p. = F ( -log( D_p / |bin| ) )
//! D_p    = max( floor, t F W_p ),      W_pb = int u_p phi_b(C)
//! ```
//!
//! with the masses D_pb of the bins, whose sum is 1 by the choice of t; the multilinear interpolation weights phi_b(c) of
//! the centers of the bins around c, of sum 1; and a symmetric smoothing F with row sums 1. The model is -log D_p(C(x)) of
//! Delaunoy et al., ICCV 2009, section 3.2, with the logarithm interpolated and smoothed.
//!
//! Fit and costs agree: the energy of region p is
//!
//! ```text
//! int u_p s_p = sum_b W_pb (F s)_b = sum_b (F W_p)_b (-log( D_pb / |bin| ))
//! ```
//!
//! whose minimizer among all D_p of sum 1 with D_pb >= floor is the smoothed histogram above (Gibbs' inequality for
//! floor 0). Data enter by phi(C) alone, and linearly, so that coarse data with the restricted costs are histograms too.
//!
//! exp(-s_p) is a geometric mean of the density D_p / |bin| around C(x). It is at most the arithmetic mean, whose integral
//! is 1, and close to it where the density varies little over the smoothing.

mod density;
mod grid;
mod shares;
mod start;

use std::borrow::Cow;
use std::sync::Arc;

use rand::RngExt;
use rand_pcg::Pcg64;

use self::grid::Grid;
use self::shares::Shares;
use self::start::Samples;
use super::values::check_values;
use super::{Cost, Data, DataModel, Initial, Scale, Weights};
use crate::error::Result;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::results;

pub use self::density::{FLOOR, Frequencies};
pub use self::grid::MAX_DIMENSION;

/// The likelihood of data in R^d, d <= 3, with a histogram per region.
#[derive(Clone)]
pub struct Histogram<'a> {
    /// C; on a coarse mesh the means of what its vertices stand for.
    data: Cow<'a, Data>,
    /// On a coarse mesh phi(C) averaged over what its vertices stand for.
    shares: Option<Shares>,
    /// The same on all meshes.
    grid: Grid,
    /// Some data of the finest mesh, on a coarser one.
    samples: Option<Arc<Samples>>,
}

/// Data are binned in at most this number of tasks, of at least `MIN_BLOCK` vertices.
const MAX_BLOCKS: usize = 64;
const MIN_BLOCK: usize = 8192;

impl<'a> Histogram<'a> {
    /// The model of these data, which are borrowed.
    ///
    /// # Errors
    /// More than [`MAX_DIMENSION`] columns, and data whose range leaves that of double precision.
    pub fn new(data: &'a Data) -> Result<Self> {
        let grid = Grid::of(data)?;
        Ok(Histogram { data: Cow::Borrowed(data), shares: None, grid, samples: None })
    }

    /// Calls `add(b, share)` for phi(C(x_k)).
    #[inline(always)]
    fn each_bin(&self, k: usize, mut add: impl FnMut(usize, f64)) {
        match &self.shares {
            None => self.grid.corners(self.data.at(k)).iter().for_each(|(b, share)| add(b, share)),
            Some(shares) => shares.at(k).for_each(|(b, share)| add(b, share)),
        }
    }

    /// W_p for m regions; `row(k, w)` writes the m weights of vertex k.
    fn sums(&self, m: usize, row: impl Fn(usize, &mut [f64]) + Sync) -> Vec<Vec<f64>> {
        let (n, bins) = (self.data.len(), self.grid.len());
        let block = n.div_ceil(MAX_BLOCKS).max(MIN_BLOCK);
        let of_blocks = results((0..n).step_by(block).collect(), |from: usize| {
            let (mut sums, mut w) = (vec![0.0; bins * m], vec![0.0; m]);
            for k in (from..n.min(from + block)).filter(|&k| self.is_known(k)) {
                row(k, &mut w);
                self.each_bin(k, |b, share| {
                    let sums = &mut sums[b * m..][..m];
                    sums.iter_mut().zip(&w).for_each(|(sum, w)| *sum += share * w);
                });
            }
            sums
        });
        let mut total = vec![0.0; bins * m];
        for sums in of_blocks {
            total.iter_mut().zip(&sums).for_each(|(total, sum)| *total += sum);
        }
        (0..m).map(|p| total[p..].iter().step_by(m).copied().collect()).collect()
    }
}

impl DataModel for Histogram<'_> {
    type Parameters = Frequencies;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "mean";

    fn value(mu: &Frequencies) -> &[f64] {
        &mu.mean
    }

    fn vertices(&self) -> usize {
        self.data.len()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.data.known(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let Some(data) = self.data.in_order(order) else { return Cow::Borrowed(self) };
        let shares = self.shares.as_ref().map(|shares| shares.in_order(order));
        Cow::Owned(Histogram {
            data: Cow::Owned(data),
            shares,
            grid: self.grid.clone(),
            samples: self.samples.clone(),
        })
    }

    /// The mean of phi(C) over what a coarse vertex stands for:
    ///
    /// ```text
    /// w_coarse = P^T w,   phi_coarse = P^T (w phi) / w_coarse
    /// ```
    ///
    /// The costs are linear in phi, so these are the restricted costs.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let known = self.data.known_area(weights);
        let d = self.data.dimension;
        let mut values = vec![0.0; coarse.len() * d];
        for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| known[v] > 0.0) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                let c = c as usize;
                if coarse[c] > 0.0 {
                    let w = share * known[v] / coarse[c];
                    let row = values[c * d..][..d].iter_mut().zip(self.data.at(v));
                    row.for_each(|(mean, x)| *mean += w * x);
                }
            }
        }
        let each = |v: usize, add: &mut dyn FnMut(usize, f64)| self.each_bin(v, add);
        let shares = Shares::restricted(level, &known, self.grid.len(), each);
        let samples =
            (self.samples.clone()).unwrap_or_else(|| Arc::new(Samples::draw(&self.data, &known)));
        Histogram {
            data: Cow::Owned(Data { dimension: d, values }),
            shares: Some(shares),
            grid: self.grid.clone(),
            samples: Some(samples),
        }
    }

    /// Costs are logarithms of densities and have no unit; their scale is that of normal distributions, half of the number
    /// of coordinates that vary. The Hellinger distance of two normal distributions whose means differ by a standard
    /// deviation is 0.34.
    fn scale(&self, _: &[f64]) -> Scale {
        Scale { cost: 0.5 * self.grid.rank() as f64, distance: 0.34, change: 0.34 }
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Frequencies>> {
        let known = self.data.known_area(weights);
        if initial == Initial::KMeans {
            let drawn;
            let samples = match &self.samples {
                Some(samples) => samples,
                None => {
                    drawn = Samples::draw(&self.data, &known);
                    &drawn
                }
            };
            let counts = samples.clustered(&self.grid, m, rng)?;
            return Ok(counts.into_iter().map(|w| Frequencies::fitted(&self.grid, w)).collect());
        }
        let drawn: Vec<usize> = known.iter().map(|_| rng.random_range(0..m)).collect();
        let sums = self.sums(m, |k, w| {
            w.fill(0.0);
            w[drawn[k]] = known[k];
        });
        let all: Vec<f64> =
            (0..self.grid.len()).map(|b| sums.iter().map(|sums| sums[b]).sum()).collect();
        // A region that drew no vertex starts with the histogram of all.
        let own = |sums: Vec<f64>| if sums.iter().any(|&w| w > 0.0) { sums } else { all.clone() };
        Ok(sums.into_iter().map(|sums| Frequencies::fitted(&self.grid, own(sums))).collect())
    }

    fn check(&self, mu: &[Frequencies]) -> Result<()> {
        check_values(self.data.dimension, mu.iter().map(|mu| &mu.mean[..]))?;
        density::check(&self.grid, mu)
    }

    fn cost<'a>(&'a self, mu: &'a [Frequencies]) -> Cost<'a> {
        let m = mu.len();
        let mut table = vec![0.0; self.grid.len() * m];
        for (p, mu) in mu.iter().enumerate() {
            let costs = density::costs(&self.grid, &mu.mass);
            table[p..].iter_mut().step_by(m).zip(costs).for_each(|(s, cost)| *s = cost);
        }
        Box::new(move |k, s| {
            s.fill(0.0);
            self.each_bin(k, |b, share| {
                s.iter_mut().zip(&table[b * m..][..m]).for_each(|(s, cost)| *s += share * cost);
            });
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Frequencies]) -> Result<f64> {
        let m = mu.len();
        let sums = self.sums(m, |k, w| w.copy_from_slice(&weights.at(k)[..m]));
        let masses: Vec<f64> = sums.iter().map(|sums| sums.iter().sum()).collect();
        let total: f64 = masses.iter().sum();
        let mut change = 0.0;
        for ((mu, sums), mass) in mu.iter_mut().zip(sums).zip(masses) {
            if mass > f64::EPSILON * total {
                let fitted = Frequencies::fitted(&self.grid, sums);
                change = f64::max(change, density::distance(&mu.mass, &fitted.mass));
                *mu = fitted;
            }
        }
        Ok(change)
    }

    fn distance(a: &Frequencies, b: &Frequencies) -> f64 {
        density::distance(&a.mass, &b.mass)
    }
}

#[cfg(test)]
mod tests;
