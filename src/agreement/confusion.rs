//! The confusion matrix of two labelings, weighted.
//!
//! ```text
//! p_ab = sum of w_k over vertices k with labels a and b / sum of w_k over all known vertices
//! ```

use std::collections::BTreeMap;

use ndarray::{Array2, Axis};

use crate::error::{Error, Result};

/// Labelings with more labels than this are refused: such numbers are no labels of regions.
pub const MAX_LABELS: usize = 1024;

/// The joint distribution of two labelings. Labels without weight have no row or column.
#[derive(Clone, Debug, PartialEq)]
pub struct Confusion {
    /// p_ab: one row per label of the labeling, one column per label of the truth; entries sum to 1.
    pub shares: Array2<f64>,
    /// The label of each row, increasing.
    pub labels: Vec<i64>,
    /// The label of each column, increasing.
    pub truth_labels: Vec<i64>,
    /// The sum of the weights of all known vertices, in their unit.
    pub weight: f64,
    /// Vertices that are unknown (negative) in either labeling; they are left out.
    pub unknown: usize,
}

impl Confusion {
    /// Compares labels with a truth; all slices have one entry per vertex, and weights are finite and not negative.
    ///
    /// # Errors
    /// Either labeling has more than [`MAX_LABELS`] labels, or no vertex with a weight is known in both.
    pub fn new(labels: &[i64], truth: &[i64], weights: &[f64]) -> Result<Self> {
        assert!(labels.len() == truth.len() && labels.len() == weights.len(), "one per vertex");
        assert!(weights.iter().all(|&w| w >= 0.0 && w.is_finite()), "weights are not negative");
        let known = |k: usize| labels[k] >= 0 && truth[k] >= 0;
        let counts = |k: &usize| known(*k) && weights[*k] > 0.0;
        let vertices = || (0..labels.len()).filter(counts);
        let rows = Index::new("the labeling", vertices().map(|k| labels[k]))?;
        let columns = Index::new("the truth", vertices().map(|k| truth[k]))?;
        let mut shares = Array2::zeros((rows.0.len(), columns.0.len()));
        for k in vertices() {
            shares[[rows.0[&labels[k]], columns.0[&truth[k]]]] += weights[k];
        }
        let weight: f64 = shares.sum();
        assert!(weight.is_finite(), "the sum of the weights is finite");
        let unknown = (0..labels.len()).filter(|&k| !known(k)).count();
        if shares.is_empty() {
            return Err(Error::unsuitable(match unknown {
                0 => "no vertex has a weight, so there is nothing to compare",
                _ => {
                    "no vertex has a weight and a known label (0 or more) in both labelings, so there is nothing to \
                     compare"
                }
            }));
        }
        shares /= weight;
        let [labels, truth_labels] = [rows, columns].map(|index| index.0.into_keys().collect());
        Ok(Confusion { shares, labels, truth_labels, weight, unknown })
    }

    /// p_a: the share of each label of the labeling.
    pub fn row_sums(&self) -> Vec<f64> {
        self.shares.sum_axis(Axis(1)).to_vec()
    }

    /// p_b: the share of each label of the truth.
    pub fn column_sums(&self) -> Vec<f64> {
        self.shares.sum_axis(Axis(0)).to_vec()
    }
}

/// The position of each label among all, in increasing order.
struct Index(BTreeMap<i64, usize>);

impl Index {
    fn new(whose: &str, labels: impl Iterator<Item = i64>) -> Result<Self> {
        let mut index = BTreeMap::new();
        for label in labels {
            index.entry(label).or_insert(0);
            if index.len() > MAX_LABELS {
                return Err(Error::unsuitable(format!(
                    "{whose} has more than {MAX_LABELS} different labels; labels must be numbers of regions"
                )));
            }
        }
        for (position, slot) in index.values_mut().enumerate() {
            *slot = position;
        }
        Ok(Index(index))
    }
}
