//! Data models: which pointwise costs s_p(x) the data suggest for region p, and which region parameters mu_p
//! suit given labels. One likelihood a file; what all of them have to answer is [`DataModel`].

pub mod constant;
pub mod curved;
pub mod input;
pub mod kmeans;
pub mod l1;
pub mod palette;
pub mod projection;
pub mod range;
pub mod synthetic;
pub mod texture;

pub use constant::PiecewiseConstant;
pub use l1::L1;

use std::borrow::Cow;
use std::fmt::Debug;

use rand_pcg::Pcg64;
use serde::Serialize;
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::sum;
use range::robust_unit_range;

/// What is segmented: a value in R^d at every vertex. Where nothing is known, d times NaN: such a vertex costs nothing,
/// counts for no region parameter, and takes the label of its neighbors.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// d.
    pub dimension: usize,
    /// V x d, row by row.
    pub values: Vec<f64>,
}

impl Data {
    /// A row with any NaN is unknown.
    ///
    /// # Errors
    /// Infinite values, naming the first one; nothing known of any vertex.
    pub fn new(dimension: usize, mut values: Vec<f64>) -> Result<Self> {
        assert!(dimension > 0 && values.len().is_multiple_of(dimension));
        if let Some(i) = values.iter().position(|x| x.is_infinite()) {
            return Err(Error::unsuitable(format!(
                "the data at vertex {} are {}, not a finite number",
                i / dimension,
                values[i]
            )));
        }
        for row in values.chunks_mut(dimension).filter(|row| row.iter().any(|x| x.is_nan())) {
            row.fill(f64::NAN);
        }
        if !values.is_empty() && values.iter().all(|x| x.is_nan()) {
            return Err(Error::unsuitable("nothing is known of any vertex: all data are NaN"));
        }
        Ok(Data { dimension, values })
    }

    /// Whether anything is known of vertex k.
    #[inline(always)]
    pub fn is_known(&self, k: usize) -> bool {
        !self.values[k * self.dimension].is_nan()
    }

    /// `area` where something is known, 0 elsewhere.
    pub fn known_area(&self, area: &[f64]) -> Vec<f64> {
        (area.iter().enumerate()).map(|(k, &a)| if self.is_known(k) { a } else { 0.0 }).collect()
    }

    /// The same data with the vertices in that order.
    pub fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let Some(order) = order.vertices() else { return Cow::Borrowed(self) };
        let values = order.iter().flat_map(|&k| self.at(k as usize)).copied().collect();
        Cow::Owned(Data { dimension: self.dimension, values })
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.values.len() / self.dimension
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// int |C - mean C|^2 / area, over what is known: the sum of the variances of the coordinates.
    pub fn variance(&self, area: &[f64]) -> f64 {
        let total: f64 = self.known_area(area).iter().sum();
        (0..self.dimension)
            .map(|i| {
                let column = || {
                    let values = self.values[i..].iter().step_by(self.dimension);
                    values.zip(area).filter(|(c, _)| !c.is_nan())
                };
                let mean = column().map(|(c, a)| a * c).sum::<f64>() / total;
                column().map(|(c, a)| a * (c - mean).powi(2)).sum::<f64>() / total
            })
            .sum()
    }

    /// The variance, but no more than four times that of the data whose extreme 2 % are cut off at both ends: a few values
    /// far away, such as those that stand for missing ones, say nothing about how far regions lie apart.
    pub fn robust_variance(&self, area_of_all: &[f64]) -> f64 {
        let known: Vec<usize> = (0..self.len()).filter(|&k| self.is_known(k)).collect();
        let area: Vec<f64> = known.iter().map(|&k| area_of_all[k]).collect();
        let total: f64 = area.iter().sum();
        let cut_off = |i: usize| {
            let column: Vec<f64> = known.iter().map(|&k| self.at(k)[i]).collect();
            let (unit, [low, high]) = robust_unit_range(&column, &area);
            let weighted = || unit.iter().zip(&area);
            let mean = weighted().map(|(t, a)| a * t).sum::<f64>() / total;
            let variance = weighted().map(|(t, a)| a * (t - mean).powi(2)).sum::<f64>() / total;
            variance * (high - low).powi(2)
        };
        let (all, most) =
            (self.variance(area_of_all), (0..self.dimension).map(cut_off).sum::<f64>());
        if most > 0.0 { all.min(4.0 * most) } else { all }
    }

    /// int u_p over what is known for each of the first m regions, if it is any; `weights` = M U.
    pub fn masses<const M: usize>(&self, weights: &[Row<M>], m: usize) -> Vec<Option<f64>> {
        let n = weights.len();
        let total = sum(n, |k| weights[k].0.iter().sum());
        let mass = |p: usize| sum(n, |k| if self.is_known(k) { weights[k].0[p] } else { 0.0 });
        (0..m).map(mass).map(|mass| (mass > f64::EPSILON * total).then_some(mass)).collect()
    }

    /// How many different values there are, counted up to a number.
    pub fn different(&self, most: usize) -> usize {
        let mut found: Vec<&[f64]> = Vec::new();
        for value in (0..self.len()).filter(|&k| self.is_known(k)).map(|k| self.at(k)) {
            if !found.contains(&value) {
                found.push(value);
                if found.len() == most {
                    break;
                }
            }
        }
        found.len()
    }

    /// C_i at all vertices.
    pub fn column(&self, i: usize) -> Vec<f64> {
        self.values[i..].iter().step_by(self.dimension).copied().collect()
    }

    /// C(x_k).
    pub fn at(&self, k: usize) -> &[f64] {
        &self.values[k * self.dimension..(k + 1) * self.dimension]
    }
}

/// Where the region parameters start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Initial {
    /// Clusters of the data: area-weighted k-means++, and Lloyd's iteration.
    KMeans,
    /// What fits a random partition of the vertices.
    Random,
}

/// What the numbers of a model are measured by. Costs and distances should not be those of a few values far away.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Of costs: a quarter of what it costs to take one value for the other, if half of the data have either. The
    /// variance of constant data.
    pub cost: f64,
    /// Of [`DataModel::distance`]: how far values lie apart.
    pub distance: f64,
    /// Of the change that [`DataModel::fit`] returns.
    pub change: f64,
}

/// The data on the vertices of one mesh, and a likelihood of them: s_p(x) depends on the data at x and on mu_p alone.
/// `segment` knows nothing else of either.
///
/// A model takes no notice of vertices of which it knows nothing: they cost 0 and count for no parameters. `weights` of
/// vertices are int phi_k, V of them, those of rows M U, with the mass matrix that makes f = M S: fit and costs share
/// one quadrature. Costs are finite, of any sign.
pub trait DataModel: Clone + Sync {
    /// mu_p, what is known of one region in the end. Serialized as a map, whose keys become those of the region in
    /// `summary.json`.
    type Parameters: Clone + Debug + PartialEq + Serialize;

    /// What [`DataModel::told`] is called, in the singular.
    const TOLD: &'static str;

    /// The numbers that tables and legends tell of a region.
    fn told(mu: &Self::Parameters) -> &[f64];

    /// V.
    fn vertices(&self) -> usize;

    /// Whether anything is known of vertex k.
    fn is_known(&self, k: usize) -> bool;

    /// How many different values the data have, counted up to `most`: there are no more regions.
    fn different(&self, most: usize) -> usize;

    /// The same data with the vertices in that order.
    fn in_order(&self, order: &Order) -> Cow<'_, Self>;

    /// Data on a coarser mesh whose costs with the weights P^T w are near P^T (w s), up to what is the same for all
    /// regions. `coarse` = P^T w over what is known; a vertex without weight there may have any data.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self;

    /// In the units of the data.
    fn scale(&self, weights: &[f64]) -> Scale;

    /// Parameters of m regions to start from.
    ///
    /// # Errors
    /// As those of [`DataModel::fit`].
    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Self::Parameters>>;

    /// s_p(x_k), one row per vertex; 0 for the regions that fill a row up.
    fn costs<const M: usize>(&self, mu: &[Self::Parameters]) -> Vec<Row<M>>;

    /// Moves the parameters to those that minimize sum_k <u_k, f_k> for given U, `weights` = M U. A region without mass
    /// keeps its own. Returns the largest change.
    ///
    /// # Errors
    /// Where the fit is itself a problem that is not solved.
    fn fit<const M: usize>(&self, weights: &[Row<M>], mu: &mut [Self::Parameters]) -> Result<f64>;

    /// How far two regions differ; 0 if they cost the same everywhere.
    fn distance(a: &Self::Parameters, b: &Self::Parameters) -> f64;
}
