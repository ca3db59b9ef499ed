//! Regions that become one.
//!
//! Two regions with the same parameters cost the same everywhere, so that what one has may go to the other without more
//! energy. The cut between them would be arbitrary, and found slowly.

use crate::field::Row;
use crate::sweep::sum;

/// Parameters that are no farther apart than this share of the scale of distances are the same.
const SAME: f64 = 0.05;

/// Re-estimations through which parameters stay together before their regions count as one, settled or not.
const TOGETHER: usize = 10;

/// Which regions are still on their own.
pub struct Unions {
    /// m.
    pub open: Vec<bool>,
    /// For pairs a < b, at b m + a: whether their parameters were ever apart, as those of a random start are not, and for how
    /// many re-estimations they have been together since.
    apart: Vec<bool>,
    together: Vec<usize>,
    /// Up to it parameters are together.
    distance: f64,
}

impl Unions {
    /// For m regions and the scale of their distances.
    pub fn new(m: usize, scale: f64) -> Self {
        let (apart, together) = (vec![false; m * m], vec![0; m * m]);
        Unions { open: vec![true; m], apart, together, distance: SAME * scale }
    }

    /// Looks at the distances of regions after a re-estimation. Each pair is a region that goes on and one that goes into it, which is
    /// open no more; `weights` = M U.
    pub fn unite<const M: usize>(
        &mut self,
        distance: impl Fn(usize, usize) -> f64,
        weights: &[Row<M>],
        settled: bool,
    ) -> Vec<[usize; 2]> {
        let m = self.open.len();
        let mut mass: Vec<f64> = (0..m).map(|p| sum(weights.len(), |v| weights[v].0[p])).collect();
        let mut united = Vec::new();
        for b in 0..m {
            for a in 0..b {
                let pair = b * m + a;
                if distance(a, b) > self.distance {
                    (self.apart[pair], self.together[pair]) = (true, 0);
                    continue;
                }
                self.together[pair] += 1;
                let long = self.apart[pair] && self.together[pair] >= TOGETHER;
                let used = |p: usize| self.open[p] && mass[p] > 0.0;
                if used(a) && used(b) && (settled || long) {
                    let [kept, left] = if mass[a] < mass[b] { [b, a] } else { [a, b] };
                    self.open[left] = false;
                    mass[kept] += mass[left];
                    united.push([kept, left]);
                }
            }
        }
        united
    }
}

/// Whether no two of m regions have the same parameters, for this scale of their distances.
pub fn are_apart(m: usize, distance: impl Fn(usize, usize) -> f64, scale: f64) -> bool {
    (0..m).all(|b| (0..b).all(|a| distance(a, b) > SAME * scale))
}

/// What region `left` has goes to region `kept`.
pub fn united<const M: usize>(mut u: Row<M>, [kept, left]: [usize; 2]) -> Row<M> {
    u.0[kept] += u.0[left];
    without(u, left)
}

pub fn without<const M: usize>(mut row: Row<M>, p: usize) -> Row<M> {
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
    fn regions_that_come_together_become_one() {
        let weights = [Row([1.0, 2.0, 4.0])];
        let mut unions = Unions::new(3, 1.0);
        assert!(unions.unite(at([0.0, 1.0, 2.0]), &weights, true).is_empty());
        for _ in 1..TOGETHER {
            assert!(unions.unite(at([0.0, 0.04, 2.0]), &weights, false).is_empty());
        }
        assert_eq!(unions.unite(at([0.0, 0.04, 2.0]), &weights, false), [[1, 0]]);
        assert_eq!(unions.open, [false, true, true]);
        assert!(unions.unite(at([0.0, 0.04, 2.0]), &weights, true).is_empty());
    }

    /// A random start has all means together: only once they have settled is that an answer.
    #[test]
    fn regions_that_were_never_apart_wait_until_they_settle() {
        let weights = [Row([1.0, 2.0, 4.0])];
        let mut unions = Unions::new(3, 1.0);
        for _ in 0..3 * TOGETHER {
            assert!(unions.unite(at([0.0, 0.01, 0.02]), &weights, false).is_empty());
        }
        assert_eq!(unions.unite(at([0.0, 0.01, 0.02]), &weights, true), [[1, 0], [2, 1]]);
        assert_eq!(unions.open, [false, false, true]);
    }

    /// A union has the mass of both, and the larger of two goes on.
    #[test]
    fn the_larger_region_goes_on() {
        let mut unions = Unions::new(3, 1.0);
        let weights = [Row([3.0, 2.0, 4.0])];
        assert_eq!(unions.unite(at([0.0, 0.01, 0.02]), &weights, true), [[0, 1], [0, 2]]);
    }

    #[test]
    fn an_empty_region_is_none_to_unite_with() {
        let mut unions = Unions::new(3, 1.0);
        let weights = [Row([1.0, 0.0, 4.0])];
        assert!(unions.unite(at([0.0, 0.01, 2.0]), &weights, true).is_empty());
    }

    #[test]
    fn a_union_keeps_the_row_in_the_simplex() {
        assert_eq!(united(Row([0.25, 0.5, 0.25]), [2, 0]), Row([0.0, 0.5, 0.5]));
    }
}
