//! Regions with the same parameters are merged.
//!
//! Such regions cost the same everywhere, so moving the mass of one to the other does not increase the energy. The cut
//! between them would be arbitrary, and solvers find it slowly.

use crate::field::Row;
use crate::sweep::sums;

/// Parameters whose distance is at most this fraction of the scale of distances are the same.
const SAME_DISTANCE: f64 = 0.05;

/// Regions are merged after their parameters have been the same for this number of re-estimations, settled or not.
const ESTIMATES_BEFORE_MERGE: usize = 10;

/// The active regions, and for each pair how long its parameters have been the same.
pub struct Merger {
    /// Which of the m regions have not been merged into another.
    pub active: Vec<bool>,
    /// For pairs a < b, at b m + a: whether their parameters were ever distinct, unlike those of a random start, and
    /// for how many re-estimations they have been the same since.
    were_distinct: Vec<bool>,
    same_for: Vec<usize>,
    /// Which regions have seeds; these are never merged into another.
    seeded: Vec<bool>,
    /// Parameters within this distance are the same.
    same_within: f64,
}

impl Merger {
    /// For m active regions, of which some have seeds, and the scale of their distances.
    pub fn new(seeded: Vec<bool>, scale: f64) -> Self {
        let m = seeded.len();
        let (were_distinct, same_for) = (vec![false; m * m], vec![0; m * m]);
        Merger {
            active: vec![true; m],
            were_distinct,
            same_for,
            seeded,
            same_within: SAME_DISTANCE * scale,
        }
    }

    /// Merges regions according to their distances after a re-estimation. Each returned pair is a region that is kept
    /// and one that is merged into it and becomes inactive; `weights` = M U.
    pub fn merge<const M: usize>(
        &mut self,
        distance: impl Fn(usize, usize) -> f64,
        weights: &[Row<M>],
        settled: bool,
    ) -> Vec<[usize; 2]> {
        let m = self.active.len();
        let mut mass = sums(weights.len(), m, |p| move |v: usize| weights[v].0[p]);
        let mut pairs = Vec::new();
        for b in 0..m {
            for a in 0..b {
                let pair = b * m + a;
                if distance(a, b) > self.same_within {
                    (self.were_distinct[pair], self.same_for[pair]) = (true, 0);
                    continue;
                }
                self.same_for[pair] += 1;
                let lasting =
                    self.were_distinct[pair] && self.same_for[pair] >= ESTIMATES_BEFORE_MERGE;
                let used = |p: usize| self.active[p] && mass[p] > 0.0;
                let both_seeded = self.seeded[a] && self.seeded[b];
                if used(a) && used(b) && !both_seeded && (settled || lasting) {
                    // A region with seeds is kept, else the larger one.
                    let order = |p: usize| (self.seeded[p], mass[p]);
                    let [kept, absorbed] = if order(a) < order(b) { [b, a] } else { [a, b] };
                    self.active[absorbed] = false;
                    mass[kept] += mass[absorbed];
                    pairs.push([kept, absorbed]);
                }
            }
        }
        pairs
    }
}

/// Whether no two of m regions have the same parameters, for the given scale of their distances.
pub fn are_distinct(m: usize, distance: impl Fn(usize, usize) -> f64, scale: f64) -> bool {
    (0..m).all(|b| (0..b).all(|a| distance(a, b) > SAME_DISTANCE * scale))
}

/// The row with the mass of region `absorbed` moved to region `kept`.
pub fn merged<const M: usize>(mut u: Row<M>, [kept, absorbed]: [usize; 2]) -> Row<M> {
    u.0[kept] += u.0[absorbed];
    zeroed(u, absorbed)
}

/// The row with a zero for region p.
pub fn zeroed<const M: usize>(mut row: Row<M>, p: usize) -> Row<M> {
    row.0[p] = 0.0;
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distances of three numbers.
    fn at(means: [f64; 3]) -> impl Fn(usize, usize) -> f64 {
        move |a, b| (means[a] - means[b]).abs()
    }

    #[test]
    fn regions_whose_parameters_stay_the_same_are_merged() {
        let weights = [Row([1.0, 2.0, 4.0])];
        let mut merger = Merger::new(vec![false; 3], 1.0);
        assert!(merger.merge(at([0.0, 1.0, 2.0]), &weights, true).is_empty());
        for _ in 1..ESTIMATES_BEFORE_MERGE {
            assert!(merger.merge(at([0.0, 0.04, 2.0]), &weights, false).is_empty());
        }
        assert_eq!(merger.merge(at([0.0, 0.04, 2.0]), &weights, false), [[1, 0]]);
        assert_eq!(merger.active, [false, true, true]);
        assert!(merger.merge(at([0.0, 0.04, 2.0]), &weights, true).is_empty());
    }

    /// The means of a random start are all close: such regions are merged only after the parameters have settled.
    #[test]
    fn regions_that_were_never_distinct_are_merged_once_settled() {
        let weights = [Row([1.0, 2.0, 4.0])];
        let mut merger = Merger::new(vec![false; 3], 1.0);
        for _ in 0..3 * ESTIMATES_BEFORE_MERGE {
            assert!(merger.merge(at([0.0, 0.01, 0.02]), &weights, false).is_empty());
        }
        assert_eq!(merger.merge(at([0.0, 0.01, 0.02]), &weights, true), [[1, 0], [2, 1]]);
        assert_eq!(merger.active, [false, false, true]);
    }

    /// A merged region has the mass of both, and the larger of the two is kept.
    #[test]
    fn the_larger_region_is_kept() {
        let mut merger = Merger::new(vec![false; 3], 1.0);
        let weights = [Row([3.0, 2.0, 4.0])];
        assert_eq!(merger.merge(at([0.0, 0.01, 0.02]), &weights, true), [[0, 1], [0, 2]]);
    }

    /// A region with seeds absorbs a larger one without; two with seeds stay separate.
    #[test]
    fn regions_with_seeds_are_kept() {
        let weights = [Row([1.0, 2.0, 4.0])];
        let equal = || at([0.0, 0.01, 0.02]);
        let mut merger = Merger::new(vec![true, false, true], 1.0);
        assert_eq!(merger.merge(equal(), &weights, true), [[0, 1]]);
        assert_eq!(merger.active, [true, false, true]);
        assert!(merger.merge(equal(), &weights, true).is_empty());
    }

    #[test]
    fn empty_regions_are_not_merged() {
        let mut merger = Merger::new(vec![false; 3], 1.0);
        let weights = [Row([1.0, 0.0, 4.0])];
        assert!(merger.merge(at([0.0, 0.01, 2.0]), &weights, true).is_empty());
    }

    #[test]
    fn merging_keeps_the_row_in_the_simplex() {
        assert_eq!(merged(Row([0.25, 0.5, 0.25]), [2, 0]), Row([0.0, 0.5, 0.5]));
    }
}
