//! What a data model has to answer: [`DataModel`].

use std::borrow::Cow;
use std::fmt::Debug;

use rand_pcg::Pcg64;
use serde::Serialize;
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::error::Result;
use crate::field::Row;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;

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

    /// What the data are at one vertex.
    type Datum: PartialEq + ?Sized;

    /// V.
    fn vertices(&self) -> usize;

    /// The datum of vertex k, if anything is known of it.
    fn at(&self, k: usize) -> Option<&Self::Datum>;

    /// Whether anything is known of vertex k.
    fn is_known(&self, k: usize) -> bool {
        self.at(k).is_some()
    }

    /// How many different values the data have, counted up to `most`: there are no more regions.
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

    /// The same data with the vertices in that order.
    fn in_order(&self, order: &Order) -> Cow<'_, Self>;

    /// Data on a coarser mesh whose costs with the weights P^T w are near P^T (w s), up to what is the same for all
    /// regions. `coarse` = P^T w over what is known; a vertex without weight there may have any data.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self;

    /// The units of costs, distances and changes, which follow from the data and the weights.
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
