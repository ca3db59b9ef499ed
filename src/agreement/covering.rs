//! The segmentation covering of the truth by a labeling.
//!
//! ```text
//! C = sum_b p_b max_a O_ab       O_ab = p_ab / (p_a + p_b - p_ab)   (intersection over union)
//! ```
//!
//! It is not symmetric: regions of the labeling may serve several regions of the truth. Reference: P. Arbelaez, M.
//! Maire, C. Fowlkes, J. Malik, *Contour Detection and Hierarchical Image Segmentation*, PAMI 33, 2011, section 2.

use super::Confusion;

impl Confusion {
    /// The covering of the truth: 1 for equal partitions.
    pub fn covering(&self) -> f64 {
        let (rows, columns) = (self.row_sums(), self.column_sums());
        let best = |b: usize| {
            let overlap = |a: usize| {
                let p = self.shares[[a, b]];
                // p_a - p_ab is exactly 0 where a lies within b.
                p / (columns[b] + (rows[a] - p))
            };
            (0..rows.len()).map(overlap).fold(0.0, f64::max)
        };
        columns.iter().enumerate().map(|(b, p)| p * best(b)).sum::<f64>().min(1.0)
    }
}
