//! Accuracy up to a permutation of the labels.
//!
//! ```text
//! accuracy = max over one-to-one matchings of labels a with labels b of   sum over matched (a, b) of p_ab
//! ```
//!
//! If one labeling has more labels, those that stay without a partner count as wrong.

use super::{Confusion, assignment};

impl Confusion {
    /// The column that is matched with each row, if there is one.
    pub fn matching(&self) -> Vec<Option<usize>> {
        assignment(self.shares.view())
    }

    /// The share of the weight on matched pairs of labels.
    pub fn accuracy(&self) -> f64 {
        let matched = self.matching().into_iter().enumerate();
        let share = |(a, b): (usize, Option<usize>)| b.map_or(0.0, |b| self.shares[[a, b]]);
        matched.map(share).sum::<f64>().min(1.0)
    }
}
