//! The data that are segmented: numbers at the vertices of a mesh, some of which may be unknown.

use super::Weights;
use super::range::robust_unit_range;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::order::Order;
use crate::sweep::{sum, sums};

/// A value in R^d at every vertex. An unknown vertex has d times NaN: it costs nothing, does not affect the region
/// parameters, and takes the label of its neighbors.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    /// d.
    pub dimension: usize,
    /// V x d, row by row.
    pub values: Vec<f64>,
}

impl Data {
    /// Data of d columns, V x d values row by row. A row with any NaN becomes unknown as a whole. Panics if d is 0 or
    /// does not divide the number of values.
    ///
    /// Fails if a value is infinite, naming the first one, or if every vertex is unknown.
    pub fn new(dimension: usize, mut values: Vec<f64>) -> Result<Self> {
        assert!(dimension > 0 && values.len().is_multiple_of(dimension));
        if let Some(i) = values.iter().position(|x| x.is_infinite()) {
            return Err(Error::unsuitable(format!(
                "the data at vertex {} are {}; they must be finite, or NaN where unknown",
                i / dimension,
                values[i]
            )));
        }
        for row in values.chunks_mut(dimension).filter(|row| row.iter().any(|x| x.is_nan())) {
            row.fill(f64::NAN);
        }
        if !values.is_empty() && values.iter().all(|x| x.is_nan()) {
            return Err(Error::unsuitable(
                "the data are NaN at every vertex: at least one vertex needs known data",
            ));
        }
        Ok(Data { dimension, values })
    }

    /// Whether the data of vertex k are known.
    #[inline(always)]
    pub fn is_known(&self, k: usize) -> bool {
        !self.values[k * self.dimension].is_nan()
    }

    /// `area` (V entries) at known vertices, 0 elsewhere.
    pub fn known_area(&self, area: &[f64]) -> Vec<f64> {
        (area.iter().enumerate()).map(|(k, &a)| if self.is_known(k) { a } else { 0.0 }).collect()
    }

    /// The same data with the vertices in the given order, if it differs.
    pub fn in_order(&self, order: &Order) -> Option<Self> {
        let values = order.vertices()?.iter().flat_map(|&k| self.at(k as usize)).copied().collect();
        Some(Data { dimension: self.dimension, values })
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// Whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// int |C - mean C|^2 / area over the known vertices: the sum of the variances of the coordinates, in squared units
    /// of the data. `area` has V entries.
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

    /// The variance, but at most four times that without the extreme 2 % of the data at both ends: a few distant
    /// values, such as placeholders for missing ones, say nothing about the distance between regions.
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

    /// int u_p over the known vertices for each of the first m regions; `None` if the integral is zero up to rounding.
    /// `weights` = M U, V rows.
    pub fn masses(&self, weights: Weights<'_>, m: usize) -> Vec<Option<f64>> {
        let n = weights.vertices();
        let total = sum(n, |k| weights.at(k).iter().sum());
        let mass = |p: usize| move |k| if self.is_known(k) { weights.at(k)[p] } else { 0.0 };
        let masses = sums(n, m, mass);
        masses.into_iter().map(|mass| (mass > f64::EPSILON * total).then_some(mass)).collect()
    }

    /// C_i at all vertices.
    pub fn column(&self, i: usize) -> Vec<f64> {
        self.values[i..].iter().step_by(self.dimension).copied().collect()
    }

    /// C(x_k), if it is known.
    pub fn known(&self, k: usize) -> Option<&[f64]> {
        self.is_known(k).then(|| self.at(k))
    }

    /// C(x_k).
    pub fn at(&self, k: usize) -> &[f64] {
        &self.values[k * self.dimension..(k + 1) * self.dimension]
    }
}

/// Checks that each region has d finite numbers.
///
/// # Errors
/// The first region that has not.
pub fn check_values<'a>(d: usize, values: impl Iterator<Item = &'a [f64]>) -> Result<()> {
    for (p, value) in values.enumerate() {
        if value.len() != d {
            return Err(Error::unsuitable(format!(
                "region {p} has {} for data of {}",
                counted(value.len(), "number", "numbers"),
                counted(d, "column", "columns")
            )));
        }
        if !value.iter().all(|x| x.is_finite()) {
            return Err(Error::unsuitable(format!("region {p} has a number that is not finite")));
        }
    }
    Ok(())
}
