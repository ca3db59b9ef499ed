//! Piecewise constant data: every region has one value.
//!
//! ```text
//! s_p(x) = |C(x) - mu_p|^2,     mu_p = int u_p C / int u_p
//! ```
//!
//! Reference: Delaunoy et al., ICCV 2009, section 3.2; the Chan-Vese model for m = 2.

use std::borrow::Cow;

use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::kmeans::kmeans;
use super::values::check_values;
use super::{Cost, Data, DataModel, Initial, Scale, Weights};
use crate::error::Result;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::sums;

/// The likelihood of piecewise constant data in R^d: squared distances to one mean per region.
#[derive(Clone)]
pub struct PiecewiseConstant<'a> {
    /// C.
    data: Cow<'a, Data>,
}

/// mu_p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mean {
    /// d numbers, in the units of the data.
    pub mean: Vec<f64>,
}

impl<'a> PiecewiseConstant<'a> {
    /// The model of the given data, which are borrowed.
    pub fn new(data: &'a Data) -> Self {
        PiecewiseConstant { data: Cow::Borrowed(data) }
    }
}

/// |c - mu|^2
fn squared_distance(c: &[f64], mu: &[f64]) -> f64 {
    c.iter().zip(mu).map(|(c, mu)| (c - mu).powi(2)).sum()
}

impl DataModel for PiecewiseConstant<'_> {
    type Parameters = Mean;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "mean";

    fn value(mu: &Mean) -> &[f64] {
        &mu.mean
    }

    fn vertices(&self) -> usize {
        self.data.len()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.data.known(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let data = self.data.in_order(order).map(Cow::Owned);
        data.map_or(Cow::Borrowed(self), |data| Cow::Owned(PiecewiseConstant { data }))
    }

    /// The means of the data:
    ///
    /// ```text
    /// w_coarse = P^T w,   C_coarse = P^T (w C) / w_coarse
    /// w_coarse |C_coarse - mu_p|^2 = ( P^T w |C - mu_p|^2 )_coarse - the variance that was averaged away
    /// ```
    ///
    /// The variance is the same for every region, so these are the restricted costs up to a constant that does not
    /// depend on the labels.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let Data { dimension: d, .. } = *self.data;
        let mut values = vec![0.0; coarse.len() * d];
        for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| self.is_known(v)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                let (c, w) = (c as usize, share * weights[v]);
                for (sum, x) in values[c * d..(c + 1) * d].iter_mut().zip(self.data.at(v)) {
                    *sum += w * x;
                }
            }
        }
        for (mean, &w) in values.chunks_mut(d).zip(coarse) {
            if w > 0.0 {
                mean.iter_mut().for_each(|x| *x /= w);
            }
        }
        PiecewiseConstant { data: Cow::Owned(Data { dimension: d, values }) }
    }

    /// The variance, the standard deviation, and the widest range of a coordinate.
    fn scale(&self, weights: &[f64]) -> Scale {
        let variance = self.data.robust_variance(weights);
        Scale { cost: variance, distance: variance.sqrt(), change: range(&self.data) }
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Mean>> {
        let data = &*self.data;
        let area = data.known_area(weights);
        let means = match initial {
            Initial::KMeans => kmeans(&data.values, data.dimension, &area, m, rng),
            Initial::Random => means_of_random_partition(data, &area, m, rng),
        };
        Ok(means.into_iter().map(|mean| Mean { mean }).collect())
    }

    fn check(&self, mu: &[Mean]) -> Result<()> {
        check_values(self.data.dimension, mu.iter().map(|mu| &mu.mean[..]))
    }

    fn cost<'a>(&'a self, mu: &'a [Mean]) -> Cost<'a> {
        assert!(mu.iter().all(|mu| mu.mean.len() == self.data.dimension));
        Box::new(move |k, s| {
            let c = self.data.at(k);
            s.iter_mut().zip(mu).for_each(|(s, mu)| *s = squared_distance(c, &mu.mean));
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Mean]) -> Result<f64> {
        let d = self.data.dimension;
        let masses = self.data.masses(weights, mu.len());
        let moment = |n: usize| {
            let (p, i) = (n / d, n % d);
            let moment = move |k: usize| weights.at(k)[p] * self.data.at(k)[i];
            move |k: usize| if self.is_known(k) { moment(k) } else { 0.0 }
        };
        let moments = sums(weights.vertices(), mu.len() * d, moment);
        let mut change = 0.0;
        for ((mu, mass), moments) in mu.iter_mut().zip(masses).zip(moments.chunks(d)) {
            let Some(mass) = mass else { continue };
            for (mu, moment) in mu.mean.iter_mut().zip(moments) {
                let mean = moment / mass;
                change = f64::max(change, (mean - *mu).abs());
                *mu = mean;
            }
        }
        Ok(change)
    }

    /// |mu_a - mu_b|.
    fn distance(a: &Mean, b: &Mean) -> f64 {
        let pairs = a.mean.iter().zip(&b.mean);
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}

/// The means of m regions to which the vertices are assigned at random; an empty region gets the mean of all data.
fn means_of_random_partition(
    data: &Data,
    area: &[f64],
    m: usize,
    rng: &mut Pcg64,
) -> Vec<Vec<f64>> {
    let mut mass = vec![0.0; m];
    let mut sums = vec![vec![0.0; data.dimension]; m];
    for (k, &a) in area.iter().enumerate() {
        let p = rng.random_range(0..m);
        if !data.is_known(k) {
            continue;
        }
        mass[p] += a;
        for (sum, c) in sums[p].iter_mut().zip(data.at(k)) {
            *sum += a * c;
        }
    }
    let total: f64 = mass.iter().sum();
    let mean: Vec<f64> =
        (0..data.dimension).map(|i| sums.iter().map(|sum| sum[i]).sum::<f64>() / total).collect();
    sums.into_iter()
        .zip(mass)
        .map(|(sum, mass)| {
            if mass > 0.0 { sum.into_iter().map(|sum| sum / mass).collect() } else { mean.clone() }
        })
        .collect()
}

/// The widest range of a coordinate of the data.
fn range(data: &Data) -> f64 {
    (0..data.dimension)
        .map(|i| {
            // f64::min and max ignore NaN.
            let column = data.values[i..].iter().step_by(data.dimension).copied();
            let (low, high) = column.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (f64::min(low, x), f64::max(high, x))
            });
            high - low
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Row;
    use crate::operator::Mass;
    use crate::samples::{bumpy, fitted_energy, random_data, rng, to_fit, with_isolated_vertices};
    use rand::RngExt;

    fn means<const P: usize>(means: [&[f64]; P]) -> Vec<Mean> {
        means.map(|mean| Mean { mean: mean.to_vec() }).to_vec()
    }

    #[test]
    fn costs_are_squared_distances() {
        let data = Data::new(2, vec![0.0, 1.0, 3.0, 5.0]).unwrap();
        let model = PiecewiseConstant::new(&data);
        let costs = model.costs::<2>(&means([&[0.0, 0.0], &[3.0, 1.0]]));
        assert_eq!(costs, [Row([1.0, 9.0]), Row([34.0, 16.0])]);
    }

    /// The fitted means minimize sum <u, M s>, for each quadrature: moving one coordinate of one mean by d increases it
    /// by exactly d^2 times the mass of the region.
    #[test]
    fn the_fit_is_the_minimizer() {
        for (mesh, data, u, mass) in to_fit(121) {
            let (model, quadrature) = (PiecewiseConstant::new(&data), mass.on(&mesh));
            let energy = |mu: &[Mean]| fitted_energy(&model, &quadrature, &u, mu);
            let mut mu = means([&[0.5; 2]; 3]);
            let before = energy(&mu);
            let weights = quadrature.integrate(&u);
            model.fit(Weights::of(&weights), &mut mu).unwrap();
            let minimum = energy(&mu);
            assert!(minimum < before);
            for p in 0..3 {
                let region: f64 = weights.iter().map(|w| w.0[p]).sum();
                for (i, d) in [(0, 1e-2), (1, -1e-2), (0, -0.3), (1, 0.3)] {
                    let mut moved = mu.clone();
                    moved[p].mean[i] += d;
                    let rise = energy(&moved) - minimum;
                    assert!((rise - d * d * region).abs() <= 1e-12 * before, "{mass:?}, {d}");
                }
            }
            assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
        }
    }

    /// Unknown vertices cost nothing and do not affect the means.
    #[test]
    fn unknown_vertices_are_ignored() {
        let data = Data::new(2, vec![0.0, 1.0, f64::NAN, 7.0, 4.0, 3.0]).unwrap();
        let model = PiecewiseConstant::new(&data);
        let mut mu = means([&[0.0, 0.0], &[3.0, 1.0]]);
        assert_eq!(model.costs::<2>(&mu)[1], Row::ZERO);
        model
            .fit(Weights::of(&[Row([0.5, 0.0]), Row([9.0, 9.0]), Row([0.5, 2.0])]), &mut mu)
            .unwrap();
        assert_eq!(mu, means([&[2.0, 2.0], &[4.0, 3.0]]));
        assert!(model.is_known(0) && !model.is_known(1));
        assert_eq!(data.variance(&[1.0, 5.0, 1.0]), 5.0);
    }

    /// Unknown vertices have no weight in the data of a coarse mesh.
    #[test]
    fn unknown_data_do_not_affect_coarse_data() {
        let mesh = bumpy(12);
        let mut rng = rng(42);
        let values = mesh.vertices.iter().map(|_| match rng.random_range(0..3) {
            0 => f64::NAN,
            _ => 0.25,
        });
        let data = Data::new(1, values.collect()).unwrap();
        let weights = Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |v| data.is_known(v));
        let means = PiecewiseConstant::new(&data).restricted(&level, &weights, &coarse);
        let mean =
            |(w, x): (&f64, &f64)| if *w > 0.0 { (x - 0.25).abs() <= 1e-15 } else { *x == 0.0 };
        assert!(coarse.iter().zip(&means.data.values).all(mean));
    }

    /// The costs of the coarse data are the restricted costs up to a constant per vertex.
    #[test]
    fn means_have_the_restricted_costs_up_to_a_constant() {
        let mesh = with_isolated_vertices(bumpy(12));
        let data = random_data(mesh.vertices.len(), 2, 121);
        let model = PiecewiseConstant::new(&data);
        let weights = Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |_| true);
        let restricted = model.restricted(&level, &weights, &coarse);
        let mu = means([&[0.2, 0.9], &[0.5, 0.1], &[1.4, 0.3]]);
        let costs = |model: &PiecewiseConstant, weights: &[f64]| -> Vec<Row<3>> {
            model.costs::<3>(&mu).iter().zip(weights).map(|(&s, &w)| s * w).collect()
        };
        let exact = crate::transfer::restrict(&level, &costs(&model, &weights));
        for (f, exact) in costs(&restricted, &coarse).into_iter().zip(exact) {
            let constant = exact - f;
            assert!(constant.min() >= -1e-15);
            assert!(constant.max() - constant.min() <= 1e-14);
        }
    }
}
