//! Piecewise constant data with outliers: every region has one value, up to errors of any size.
//!
//! ```text
//! s_p(x) = |C(x) - mu_p|_1 = sum_i |C_i(x) - mu_pi|,     mu_pi = the median of C_i with the weights u_p
//! ```
//!
//! A datum affects mu_p only by its weight, however far away it is: the median withstands outliers in up to half of a
//! region. The median minimizes the sum of absolute deviations: P. J. Huber, *Robust Statistics*, Wiley 1981. As a data
//! term: T. F. Chan, S. Esedoglu, *Aspects of total variation regularized L1 function approximation*, SIAM J. Appl.
//! Math. 65, 2005.

use std::borrow::Cow;

use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::kmeans::kmedians;
use super::range::{median, robust_range, robust_unit_range};
use super::values::check_values;
use super::{Cost, Data, DataModel, Initial, Scale, Weights};
use crate::error::Result;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;

/// Number of quantiles that a coarse vertex has of each coordinate: odd, so that one of them is the median.
const QUANTILES: usize = 5;

/// The likelihood of data in R^d with outliers: distances in the 1-norm to one median per region.
#[derive(Clone)]
pub struct L1<'a> {
    /// C; on a coarse mesh n adjacent values of each coordinate, each of which stands for an n-th of the vertex.
    data: Cow<'a, Data>,
    /// n, odd.
    copies: usize,
    /// For each coordinate the indices of its known values, sorted by value.
    sorted: Vec<Vec<usize>>,
}

/// mu_p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Median {
    /// d numbers, in the units of the data.
    pub median: Vec<f64>,
}

impl<'a> L1<'a> {
    /// The model of the given data, which are borrowed; each coordinate is sorted once.
    pub fn new(data: &'a Data) -> Self {
        L1::of(Cow::Borrowed(data), 1)
    }

    fn of(data: Cow<'a, Data>, copies: usize) -> Self {
        let sorted = |i: usize| {
            let known = (0..data.len()).filter(|&k| data.is_known(k));
            let of_vertex = |k: usize| k * data.dimension + i * copies;
            let indices = known.flat_map(|k| (0..copies).map(move |c| of_vertex(k) + c));
            let mut sorted: Vec<usize> = indices.collect();
            let value = |index: &usize| data.values[*index];
            sorted.sort_unstable_by(|a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
            sorted
        };
        let sorted = (0..data.dimension / copies).map(sorted).collect();
        L1 { sorted, data, copies }
    }

    /// d.
    fn dimension(&self) -> usize {
        self.sorted.len()
    }

    /// The values of coordinate i at vertex k.
    fn values(&self, k: usize, i: usize) -> &[f64] {
        &self.data.at(k)[i * self.copies..][..self.copies]
    }

    /// The medians of coordinate i at all vertices.
    fn middle(&self, i: usize) -> Vec<f64> {
        self.data.column(i * self.copies + self.copies / 2)
    }
}

impl DataModel for L1<'_> {
    type Parameters = Median;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "median";

    fn value(mu: &Median) -> &[f64] {
        &mu.median
    }

    fn vertices(&self) -> usize {
        self.data.len()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.data.known(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let data = self.data.in_order(order).map(Cow::Owned);
        data.map_or(Cow::Borrowed(self), |data| Cow::Owned(L1::of(data, self.copies)))
    }

    /// The quantiles of each coordinate at (c + 1/2) / n with the weights P_kc w_k, c from 0 to n - 1: their
    /// mean of |C_i - mu_pi| approximates that over the fine vertices of the coarse vertex. A mean would spread every
    /// outlier; the median alone has less noise than the data and would exaggerate the differences between regions.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); coarse.len()];
        for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| self.is_known(v)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                if share * weights[v] > 0.0 {
                    shares[c as usize].push((v, share * weights[v]));
                }
            }
        }
        let dimension = self.dimension() * QUANTILES;
        let mut values = Vec::with_capacity(coarse.len() * dimension);
        for shares in &shares {
            for i in 0..self.dimension() {
                let each = |&(v, w): &(usize, f64)| self.values(v, i).iter().map(move |&x| (x, w));
                let mut all: Vec<(f64, f64)> = shares.iter().flat_map(each).collect();
                all.sort_unstable_by(|(x, _), (y, _)| x.total_cmp(y));
                values.extend(quantiles(&all));
            }
        }
        L1::of(Cow::Owned(Data { dimension, values }), QUANTILES)
    }

    /// The mean deviation from the median, without the extreme 2 % of the data at both ends if the rest still varies.
    /// If half of the data have one value and half another, it is half the cost of confusing the two.
    fn scale(&self, weights: &[f64]) -> Scale {
        let area = self.data.known_area(weights).repeat(self.copies);
        let column = |i: usize| -> Vec<f64> {
            (0..self.copies).flat_map(|c| self.data.column(i * self.copies + c)).collect()
        };
        let columns: Vec<Vec<f64>> = (0..self.dimension()).map(column).collect();
        let cut_off = |column: &Vec<f64>| {
            let (unit, [low, high]) = robust_unit_range(column, &area);
            deviation(&unit, &area) * (high - low)
        };
        let robust: f64 = columns.iter().map(cut_off).sum();
        let all = || columns.iter().map(|column| deviation(column, &area)).sum();
        let deviation = if robust > 0.0 { robust } else { all() };
        Scale { cost: 0.5 * deviation, distance: deviation, change: deviation }
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Median>> {
        let area = self.data.known_area(weights);
        let columns: Vec<Vec<f64>> = (0..self.dimension()).map(|i| self.middle(i)).collect();
        if initial == Initial::KMeans {
            // Distant values, which would otherwise become initial regions, are clipped to the range of the others.
            let near = |column: &Vec<f64>| -> Vec<f64> {
                let [low, high] = robust_range(column, &area);
                let near = |&x: &f64| if low < high { x.clamp(low, high) } else { x };
                column.iter().map(near).collect()
            };
            let columns: Vec<Vec<f64>> = columns.iter().map(near).collect();
            let rows: Vec<f64> =
                (0..area.len()).flat_map(|k| columns.iter().map(move |column| column[k])).collect();
            let medians = kmedians(&rows, self.dimension(), &area, m, rng);
            return Ok(medians.into_iter().map(|median| Median { median }).collect());
        }
        let drawn: Vec<usize> = area.iter().map(|_| rng.random_range(0..m)).collect();
        let of = |p: usize| {
            let own = area.iter().zip(&drawn).map(|(&a, &q)| if q == p { a } else { 0.0 });
            let own: Vec<f64> = own.collect();
            // A region without vertices starts at the median of all data.
            let area = if own.iter().any(|&a| a > 0.0) { &own } else { &area };
            Median { median: columns.iter().map(|column| median(column, area)).collect() }
        };
        Ok((0..m).map(of).collect())
    }

    fn check(&self, mu: &[Median]) -> Result<()> {
        check_values(self.dimension(), mu.iter().map(|mu| &mu.median[..]))
    }

    fn cost<'a>(&'a self, mu: &'a [Median]) -> Cost<'a> {
        assert!(mu.iter().all(|mu| mu.median.len() == self.dimension()));
        let mean = |c: &[f64], mu: &Median| {
            let values = c.chunks(self.copies).zip(&mu.median);
            values.flat_map(|(c, mu)| c.iter().map(move |c| (c - mu).abs())).sum::<f64>()
                / self.copies as f64
        };
        Box::new(move |k, s| {
            let c = self.data.at(k);
            s.iter_mut().zip(mu).for_each(|(s, mu)| *s = mean(c, mu));
        })
    }

    /// If half of a region lies on either side of a gap, every value in the gap is a median: the nearest to the
    /// previous one is taken, so that an optimal value stays.
    fn fit(&self, weights: Weights<'_>, mu: &mut [Median]) -> Result<f64> {
        let masses = self.data.masses(weights, mu.len());
        // Each vertex appears n times.
        let half = 0.5 * self.copies as f64;
        let halves: Vec<f64> =
            masses.iter().map(|mass| mass.map_or(f64::INFINITY, |mass| half * mass)).collect();
        let mut change = 0.0;
        for (i, sorted) in self.sorted.iter().enumerate() {
            let mut passed = vec![0.0; mu.len()];
            // The smallest and the largest median of a region.
            let mut ends: Vec<[Option<f64>; 2]> = vec![[None; 2]; mu.len()];
            let mut open = masses.iter().flatten().count();
            for &index in sorted {
                let value = self.data.values[index];
                let row = weights.at(index / self.data.dimension);
                for (p, (passed, ends)) in passed.iter_mut().zip(&mut ends).enumerate() {
                    *passed += row[p];
                    if ends[1].is_none() && *passed >= halves[p] {
                        ends[0].get_or_insert(value);
                        if *passed > halves[p] {
                            ends[1] = Some(value);
                            open -= 1;
                        }
                    }
                }
                if open == 0 {
                    break;
                }
            }
            for (mu, ends) in mu.iter_mut().zip(ends) {
                let [Some(least), Some(largest)] = ends else { continue };
                let nearest = mu.median[i].clamp(least, largest);
                change = f64::max(change, (nearest - mu.median[i]).abs());
                mu.median[i] = nearest;
            }
        }
        Ok(change)
    }

    /// |mu_a - mu_b|_1.
    fn distance(a: &Median, b: &Median) -> f64 {
        a.median.iter().zip(&b.median).map(|(a, b)| (a - b).abs()).sum()
    }
}

/// The quantiles of weighted values in increasing order; 0 if there are none.
fn quantiles(values: &[(f64, f64)]) -> [f64; QUANTILES] {
    let total: f64 = values.iter().map(|(_, w)| w).sum();
    let (mut passed, mut next, mut last) = (0.0, values.iter(), 0.0);
    std::array::from_fn(|c| {
        while passed <= (c as f64 + 0.5) / QUANTILES as f64 * total {
            let Some(&(value, w)) = next.next() else { break };
            (passed, last) = (passed + w, value);
        }
        last
    })
}

/// int |x - median of x| / area, over the known values.
fn deviation(values: &[f64], area: &[f64]) -> f64 {
    let middle = median(values, area);
    let known = || values.iter().zip(area).filter(|(x, _)| !x.is_nan());
    let total: f64 = known().map(|(_, a)| a).sum();
    known().map(|(x, a)| a * (x - middle).abs()).sum::<f64>() / total
}

#[cfg(test)]
mod tests;
