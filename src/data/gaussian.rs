//! Data with a normal distribution in each region.
//!
//! ```text
//! s_p(x) = -log N(C(x); mu_p, Sigma_p)
//!        = (1/2) (C - mu_p)^T Sigma_p^-1 (C - mu_p) + (1/2) log det Sigma_p + (d/2) log 2 pi
//! mu_p   = int u_p C / int u_p,     Sigma_p = int u_p (C - mu_p) (C - mu_p)^T / int u_p, with eigenvalues above a floor
//! ```
//!
//! with d the dimension of the data: the density has the factor (2 pi)^(-d/2) |Sigma|^(-1/2). The paper prints
//! (2 pi)^(-1/m) / |Sigma|. Regions may differ by their spread alone. Delaunoy et al., ICCV 2009, section 3.2.

mod floor;
mod mixture;
mod normal;

use std::borrow::Cow;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use self::floor::Floor;
use self::mixture::Samples;
use self::normal::{Density, Sums, packed};
use super::values::check_values;
use super::{Cost, Data, DataModel, Initial, Scale, Weights};
use crate::error::{Error, Result};
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::results;

pub use self::floor::FLOOR;
pub use self::normal::{MAX_DIMENSION, Moments};

/// The likelihood of data in R^d with a mean and a covariance per region.
#[derive(Clone)]
pub struct Gaussian<'a> {
    /// C; on a coarse mesh the means of what its vertices stand for.
    data: Cow<'a, Data>,
    /// The covariances of what the vertices of a coarse mesh stand for, packed; empty on the finest.
    scatter: Vec<f64>,
    /// The same on all meshes.
    floor: Floor,
    /// Some data of the finest mesh, on a coarser one, whose own data are mixed where regions meet: a mixture fitted to
    /// them would have a part for these.
    samples: Option<Samples>,
}

/// Number of vertices whose moments are summed in one task.
const BLOCK: usize = 8192;

impl<'a> Gaussian<'a> {
    /// The model of these data, which are borrowed.
    ///
    /// # Errors
    /// More than [`MAX_DIMENSION`] columns, and data whose variances leave the range of double precision.
    pub fn new(data: &'a Data) -> Result<Self> {
        let floor = Floor::of(data)?;
        Ok(Gaussian { data: Cow::Borrowed(data), scatter: Vec::new(), floor, samples: None })
    }

    /// The packed scatter of vertex k, or nothing.
    #[inline(always)]
    fn scatter(&self, k: usize) -> &[f64] {
        if self.scatter.is_empty() {
            return &[];
        }
        let entries = packed(self.data.dimension);
        &self.scatter[k * entries..][..entries]
    }

    /// Sums over what is known for each of m regions; `add(k, more)` calls `more(p, w)` for the weights of vertex k.
    fn sums(&self, m: usize, add: impl Fn(usize, &mut dyn FnMut(usize, f64)) + Sync) -> Vec<Sums> {
        let (n, d) = (self.data.len(), self.data.dimension);
        let none = || vec![Sums::new(d); m];
        let blocks = (0..n).step_by(BLOCK).collect();
        let of_blocks = results(blocks, |from: usize| {
            let mut sums = none();
            for k in (from..n.min(from + BLOCK)).filter(|&k| self.data.is_known(k)) {
                let (c, scatter) = (self.data.at(k), self.scatter(k));
                add(k, &mut |p, w| {
                    if w > 0.0 {
                        sums[p].add(w, c, scatter, &self.floor.center);
                    }
                });
            }
            sums
        });
        let mut total = none();
        for sums in of_blocks {
            total.iter_mut().zip(&sums).for_each(|(total, sums)| total.merge(sums));
        }
        total
    }

    /// The parameters of minimum cost for these sums.
    fn fitted(&self, sums: &Sums) -> Moments {
        self.floor.raised(sums.moments(&self.floor.center))
    }
}

impl DataModel for Gaussian<'_> {
    type Parameters = Moments;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "mean";

    fn value(mu: &Moments) -> &[f64] {
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
        let vertices = order.vertices().unwrap_or_default();
        let scatter = vertices.iter().flat_map(|&k| self.scatter(k as usize)).copied().collect();
        Cow::Owned(Gaussian { data: Cow::Owned(data), scatter, ..self.clone() })
    }

    /// The mean and the covariance of the data that a coarse vertex stands for:
    ///
    /// ```text
    /// w_coarse = P^T w,   C_coarse = P^T (w C) / w_coarse
    /// S_coarse = P^T (w ((C - C_coarse) (C - C_coarse)^T + S)) / w_coarse
    /// ```
    ///
    /// The costs are quadratic in the data, so these are the restricted costs. Unlike for constant data, the spread
    /// that is averaged away matters: (1/2) tr Sigma_p^-1 S differs from region to region.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let Data { dimension: d, .. } = *self.data;
        let mut sums = vec![Sums::new(d); coarse.len()];
        for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| self.is_known(v)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                let sums = &mut sums[c as usize];
                sums.add(share * weights[v], self.data.at(v), self.scatter(v), &self.floor.center);
            }
        }
        let (mut values, mut scatter) = (Vec::new(), Vec::new());
        for sums in &sums {
            if sums.mass > 0.0 {
                let moments = sums.moments(&self.floor.center);
                values.extend(moments.mean);
                let rows = moments.covariance.iter().enumerate();
                scatter.extend(rows.flat_map(|(i, row)| &row[..=i]));
            } else {
                values.resize(values.len() + d, 0.0);
                scatter.resize(scatter.len() + packed(d), 0.0);
            }
        }
        let samples = self.samples.clone().unwrap_or_else(|| {
            let known = self.data.known_area(weights);
            Samples::draw(&self.floor, &self.data.values, &known, &mut Pcg64::seed_from_u64(0))
        });
        let data = Cow::Owned(Data { dimension: d, values });
        Gaussian { data, scatter, floor: self.floor.clone(), samples: Some(samples) }
    }

    /// Costs are logarithms of densities and have no unit. If all data are one region, (1/2) |C - mu|^2 in the norm of
    /// its covariance is half of the dimension on average. Distances and changes are square roots of costs.
    fn scale(&self, _: &[f64]) -> Scale {
        Scale { cost: 0.5 * self.floor.rank as f64, distance: 1.0, change: 1.0 }
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Moments>> {
        let known = self.data.known_area(weights);
        if initial == Initial::KMeans {
            let draw = |rng: &mut Pcg64| {
                Cow::Owned(Samples::draw(&self.floor, &self.data.values, &known, rng))
            };
            let samples = self.samples.as_ref().map_or_else(|| draw(rng), Cow::Borrowed);
            return Ok(samples.fitted(m, rng));
        }
        let drawn: Vec<usize> = known.iter().map(|_| rng.random_range(0..m)).collect();
        let sums = self.sums(m, |k, add| add(drawn[k], known[k]));
        let mut all = Sums::new(self.data.dimension);
        sums.iter().for_each(|sums| all.merge(sums));
        // A region that drew no vertex starts with the moments of all.
        Ok(sums.iter().map(|sums| self.fitted(if sums.mass > 0.0 { sums } else { &all })).collect())
    }

    fn check(&self, mu: &[Moments]) -> Result<()> {
        check_values(self.data.dimension, mu.iter().map(|mu| &mu.mean[..]))?;
        for (p, mu) in mu.iter().enumerate() {
            mu.check().map_err(|why| Error::unsuitable(format!("region {p}: {why}")))?;
        }
        Ok(())
    }

    fn cost<'a>(&'a self, mu: &'a [Moments]) -> Cost<'a> {
        assert!(mu.iter().all(|mu| mu.mean.len() == self.data.dimension));
        let densities: Vec<Density> = mu.iter().map(Density::new).collect();
        Box::new(move |k, s| {
            let (c, scatter) = (self.data.at(k), self.scatter(k));
            s.iter_mut().zip(&densities).for_each(|(s, density)| *s = density.cost(c, scatter));
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Moments]) -> Result<f64> {
        let m = mu.len();
        let sums = self.sums(m, |k, add| (0..m).for_each(|p| add(p, weights.at(k)[p])));
        let total: f64 = sums.iter().map(|sums| sums.mass).sum();
        let mut change = 0.0;
        for (mu, sums) in mu.iter_mut().zip(&sums) {
            if sums.mass > f64::EPSILON * total {
                let fitted = self.fitted(sums);
                change = f64::max(change, normal::distance(mu, &fitted));
                *mu = fitted;
            }
        }
        Ok(change)
    }

    fn distance(a: &Moments, b: &Moments) -> f64 {
        normal::distance(a, b)
    }
}

#[cfg(test)]
mod tests;
