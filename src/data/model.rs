//! The interface of data models: [`DataModel`].

use std::borrow::Cow;
use std::fmt::Debug;

use rand_pcg::Pcg64;
use serde::Serialize;
use serde::de::DeserializeOwned;
use strum::{EnumString, IntoStaticStr, VariantNames};

use super::Weights;
use crate::error::Result;
use crate::field::Row;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::collect;

/// How the initial region parameters are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Initial {
    /// Clusters of the data: area-weighted k-means++, and Lloyd's iteration.
    KMeans,
    /// The parameters that fit a random partition of the vertices.
    Random,
}

/// The units in which the numbers of a model are measured. They should not depend on a few outliers.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The unit of costs: if half of the data have one value and half another, a quarter of the cost of confusing the
    /// two. For piecewise constant data the variance.
    pub cost: f64,
    /// The unit of [`DataModel::distance`]: the typical distance between values.
    pub distance: f64,
    /// The unit of the change that [`DataModel::fit`] returns.
    pub change: f64,
}

/// See [`DataModel::cost`].
pub type Cost<'a> = Box<dyn Fn(usize, &mut [f64]) + Sync + 'a>;

/// The costs of m regions at V vertices; 0 at unknown vertices and for padding regions.
pub fn rows<const M: usize>(
    vertices: usize,
    m: usize,
    is_known: impl Fn(usize) -> bool + Sync,
    cost: &(dyn Fn(usize, &mut [f64]) + Sync),
) -> Vec<Row<M>> {
    collect(vertices, |k| cost_row(k, m, &is_known, cost))
}

/// The costs of m regions at vertex k; 0 if it is unknown, and for padding regions.
#[inline(always)]
pub fn cost_row<const M: usize>(
    k: usize,
    m: usize,
    is_known: impl Fn(usize) -> bool,
    cost: &(dyn Fn(usize, &mut [f64]) + Sync),
) -> Row<M> {
    let mut s = Row::ZERO;
    if is_known(k) {
        cost(k, &mut s.0[..m]);
    }
    s
}

/// The data on the vertices of one mesh, and a likelihood of them: s_p(x) depends on the data at x and on mu_p alone.
/// `segment` uses nothing else.
///
/// A model ignores unknown vertices: they cost 0 and do not affect the parameters. Vertex weights are the V numbers int
/// phi_k; row weights are M U, with the same mass matrix as in f = M S, so that fit and costs share one quadrature.
/// Costs are finite, of any sign.
pub trait DataModel: Clone + Sync {
    /// mu_p, the parameters of one region. Serialized as a map, whose keys become those of the region in
    /// `summary.json`.
    type Parameters: Clone + Debug + PartialEq + Serialize + DeserializeOwned + Sync;

    /// The name of [`DataModel::value`], in the singular, such as `mean`.
    const VALUE_NAME: &'static str;

    /// The parameter that tables and legends show, as numbers.
    fn value(mu: &Self::Parameters) -> &[f64];

    /// The data at one vertex.
    type Datum: PartialEq + ?Sized;

    /// V.
    fn vertices(&self) -> usize;

    /// The datum of vertex k, if it is known.
    fn at(&self, k: usize) -> Option<&Self::Datum>;

    /// Whether the datum of vertex k is known.
    fn is_known(&self, k: usize) -> bool {
        self.at(k).is_some()
    }

    /// The number of different values of the data, counted up to `most`. There cannot be more regions.
    fn different(&self, most: usize) -> usize {
        let mut found: Vec<&Self::Datum> = Vec::new();
        for value in (0..self.vertices()).filter_map(|k| self.at(k)) {
            if !found.contains(&value) {
                found.push(value);
                if found.len() == most {
                    break;
                }
            }
        }
        found.len()
    }

    /// The same data with the vertices in the given order.
    fn in_order(&self, order: &Order) -> Cow<'_, Self>;

    /// Data on a coarser mesh whose costs with the weights P^T w are close to P^T (w s), up to a constant per vertex.
    /// `coarse` = P^T w over the known vertices; a coarse vertex without weight may have any data.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self;

    /// The units of costs, distances and changes, which follow from the data and the weights.
    fn scale(&self, weights: &[f64]) -> Scale;

    /// Initial parameters of m regions.
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

    /// Checks parameters from outside: those of this model for data of this dimension, and none that have no costs.
    ///
    /// # Errors
    /// Parameters that [`DataModel::cost`] cannot take, with the region.
    fn check(&self, mu: &[Self::Parameters]) -> Result<()>;

    /// The function that writes s_p(x_k) for all p into a row of m numbers, given a vertex k whose datum is known.
    fn cost<'a>(&'a self, mu: &'a [Self::Parameters]) -> Cost<'a>;

    /// s_p(x_k), one row per vertex; 0 at unknown vertices and for padding regions.
    fn costs<const M: usize>(&self, mu: &[Self::Parameters]) -> Vec<Row<M>> {
        rows(self.vertices(), mu.len(), |k| self.is_known(k), &*self.cost(mu))
    }

    /// Sets the parameters to those that minimize sum_k <u_k, f_k> for given U, `weights` = M U. A region without mass
    /// keeps its parameters. Returns the largest change.
    ///
    /// # Errors
    /// If the fit is itself an optimization problem and could not be solved.
    fn fit(&self, weights: Weights<'_>, mu: &mut [Self::Parameters]) -> Result<f64>;

    /// The distance between two regions; 0 if their costs agree everywhere.
    fn distance(a: &Self::Parameters, b: &Self::Parameters) -> f64;
}
