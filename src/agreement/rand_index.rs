//! The Rand index, and the one adjusted for chance.
//!
//! Two points are drawn independently by weight. The labelings agree on them if both put them into one region or both
//! into two:
//!
//! ```text
//! RI  = 1 - sum_ab p_ab (p_a - p_ab) - sum_ab p_ab (p_b - p_ab)
//! ARI = (sum_ab p_ab^2 - A B) / ((A + B) / 2 - A B),   A = sum_a p_a^2,  B = sum_b p_b^2
//! ```
//!
//! Both sums have no negative terms, so that nothing cancels. With N equal weights, counting pairs of distinct vertices
//! only, as usual, multiplies 1 - RI by N / (N - 1); drawing points makes a vertex of weight 2 equal to two vertices of
//! weight 1. References: W. M. Rand, *Objective Criteria for the Evaluation of Clustering Methods*, JASA 66, 1971;
//! L. Hubert, P. Arabie, *Comparing Partitions*, Journal of Classification 2, 1985.

use super::Confusion;

impl Confusion {
    /// The probability that the labelings agree on two random points.
    pub fn rand_index(&self) -> f64 {
        let [split, merged] = self.disagreements();
        1.0 - split - merged
    }

    /// 1 for equal partitions, 0 on average for independent ones of the given sizes, also less.
    pub fn adjusted_rand_index(&self) -> f64 {
        let [split, merged] = self.disagreements();
        let half = 0.5 * (split + merged);
        if half == 0.0 {
            return 1.0;
        }
        let squares = |shares: Vec<f64>| shares.iter().map(|p| p * p).sum::<f64>();
        let (a, b) = (squares(self.row_sums()), squares(self.column_sums()));
        // (A + B) / 2 = sum_ab p_ab^2 + (split + merged) / 2
        let excess = self.shares.iter().map(|p| p * p).sum::<f64>() - a * b;
        excess / (excess + half)
    }

    /// The probabilities that two points are together in the labeling only, and in the truth only.
    fn disagreements(&self) -> [f64; 2] {
        let (rows, columns) = (self.row_sums(), self.column_sums());
        let mut sums = [0.0; 2];
        for ((a, b), &p) in self.shares.indexed_iter() {
            sums[0] += p * (rows[a] - p);
            sums[1] += p * (columns[b] - p);
        }
        sums
    }
}
