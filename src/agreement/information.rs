//! The variation of information, a metric on partitions.
//!
//! ```text
//! VI = H(a | b) + H(b | a) = - sum_ab p_ab ( log2 (p_ab / p_a) + log2 (p_ab / p_b) )
//! ```
//!
//! The logarithm has base 2, as in the benchmark of the Berkeley data set: VI is in bits. Reference: M. Meila,
//! *Comparing Clusterings: an Information Based Distance*, Journal of Multivariate Analysis 98, 2007.

use super::Confusion;

impl Confusion {
    /// VI in bits: 0 for equal partitions, at most log2 of the product of the numbers of labels.
    pub fn variation_of_information(&self) -> f64 {
        let (rows, columns) = (self.row_sums(), self.column_sums());
        let entries = self.shares.indexed_iter().filter(|&(_, &p)| p > 0.0);
        let bits = |((a, b), &p): ((usize, usize), &f64)| {
            p * ((rows[a].log2() - p.log2()) + (columns[b].log2() - p.log2()))
        };
        entries.map(bits).sum()
    }
}
