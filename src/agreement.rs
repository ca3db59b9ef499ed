//! Measures of agreement between two labelings of the same vertices, such as a result and a human segmentation.
//!
//! A labeling has one integer per vertex, negative where unknown; the names of the labels do not matter. A vertex
//! counts with a weight: its area, or 1 for pixels. All region measures derive from the confusion matrix p_ab, the
//! share of the weight that has label a in the labeling and b in the truth:
//!
//! | measure | equal partitions | reference |
//! |---|---|---|
//! | accuracy: share under the best matching of labels | 1 | `matching.rs` |
//! | Rand index, and adjusted for chance | 1 | `rand_index.rs` |
//! | variation of information, in bits | 0 | `information.rs` |
//! | covering of the truth | 1 | `covering.rs` |
//!
//! Precision and recall of the boundaries of images are in `boundary.rs`. Scores against several humans are means over
//! the humans; the mean of the Rand index is the probabilistic Rand index of R. Unnikrishnan, C. Pantofaru, M. Hebert,
//! *Toward Objective Evaluation of Image Segmentation Algorithms*, PAMI 29, 2007.

mod assignment;
mod bipartite;
mod boundary;
mod confusion;
mod covering;
mod information;
mod matching;
mod rand_index;
mod thin;

#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::error::Result;

pub use assignment::assignment;
pub use boundary::{Boundaries, Boundary, MAX_STEPS, TOLERANCE, boundaries, grid_image};
pub use confusion::{Confusion, MAX_LABELS};

/// The scores of a labeling against one truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Number of labels of the labeling.
    pub regions: usize,
    /// Number of labels of the truth.
    pub truth_regions: usize,
    /// Vertices that are unknown in either labeling and left out.
    pub unknown: usize,
    /// The share of correct weight when labels are matched one to one in the best way, 0 to 1.
    pub accuracy: f64,
    /// The probability that two random points are together in both labelings or apart in both, 0 to 1.
    pub rand_index: f64,
    /// The Rand index on a scale on which 0 is the expected value of independent labelings and 1 its maximum.
    pub adjusted_rand_index: f64,
    /// H(labels | truth) + H(truth | labels) in bits, 0 or more.
    pub variation_of_information: f64,
    /// The mean, over the truth, of the largest overlap (intersection over union) of its regions, 0 to 1.
    pub covering: f64,
}

impl Agreement {
    /// Compares labels with a truth; all slices have one entry per vertex, and weights are not negative.
    ///
    /// # Errors
    /// As [`Confusion::new`].
    pub fn new(labels: &[i64], truth: &[i64], weights: &[f64]) -> Result<Self> {
        let confusion = Confusion::new(labels, truth, weights)?;
        let (regions, truth_regions) = confusion.shares.dim();
        Ok(Agreement {
            regions,
            truth_regions,
            unknown: confusion.unknown,
            accuracy: confusion.accuracy(),
            rand_index: confusion.rand_index(),
            adjusted_rand_index: confusion.adjusted_rand_index(),
            variation_of_information: confusion.variation_of_information(),
            covering: confusion.covering(),
        })
    }
}

/// Mean scores over several truths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanAgreement {
    /// Mean accuracy.
    pub accuracy: f64,
    /// The probabilistic Rand index.
    pub rand_index: f64,
    /// Mean adjusted Rand index.
    pub adjusted_rand_index: f64,
    /// Mean variation of information in bits.
    pub variation_of_information: f64,
    /// Mean covering.
    pub covering: f64,
}

impl MeanAgreement {
    /// The means over one or more truths.
    pub fn of(agreements: &[Agreement]) -> Self {
        assert!(!agreements.is_empty(), "at least one truth");
        let mean = |score: fn(&Agreement) -> f64| {
            agreements.iter().map(score).sum::<f64>() / agreements.len() as f64
        };
        MeanAgreement {
            accuracy: mean(|it| it.accuracy),
            rand_index: mean(|it| it.rand_index),
            adjusted_rand_index: mean(|it| it.adjusted_rand_index),
            variation_of_information: mean(|it| it.variation_of_information),
            covering: mean(|it| it.covering),
        }
    }
}
