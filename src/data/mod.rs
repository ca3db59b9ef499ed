//! Data models: which pointwise costs s_p(x) the data suggest for region p, and which region parameters
//! suit given labels. One likelihood a file.

pub mod constant;
pub mod curved;
pub mod kmeans;
pub mod looks;
pub mod projection;
pub mod range;
pub mod seen;
pub mod synthetic;
pub mod texture;

pub use constant::PiecewiseConstant;

use std::borrow::Cow;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::order::Order;
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

    /// C(x_k).
    pub fn at(&self, k: usize) -> &[f64] {
        &self.values[k * self.dimension..(k + 1) * self.dimension]
    }
}

/// What is known of one region in the end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RegionParameters {
    /// mu_p.
    pub mean: Vec<f64>,
}

pub trait DataModel<const M: usize> {
    /// s_p(x_k), one row per vertex.
    fn costs(&self) -> Vec<Row<M>>;

    /// The parameters that minimize sum_k <u_k, f_k> for given U. `weights` = M U with the mass matrix of
    /// f, so that both use one quadrature. A region without mass keeps its parameters.
    /// Returns the largest change, in the units of the data.
    fn fit(&mut self, weights: &[Row<M>]) -> f64;

    /// One entry per region.
    fn parameters(&self) -> Vec<RegionParameters>;
}
