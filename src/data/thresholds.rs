//! Thresholds of scalar data: the classes of least variance (N. Otsu, *A threshold selection method from gray-level
//! histograms*, IEEE Trans. SMC 9, 1979), for any number of classes and without a histogram.
//!
//! ```text
//! min over t_1 < ... < t_{m-1} of   sum_p sum_{k in class p} a_k (y_k - mu_p)^2,     class p: t_p <= y_k < t_{p+1}
//! ```
//!
//! Otsu's criterion, the largest variance between classes, is the same. Dynamic programming over the sorted values finds
//! the global optimum in O(m n log n), since the first value of the last class is a nondecreasing function of the last
//! value (X. Wu, *Optimal quantization by matrix searching*, J. Algorithms 12, 1991).

use std::ops::Range;

/// The m - 1 thresholds of least variance within the classes, ascending: midpoints between neighboring values. Fewer
/// than m distinct values give fewer thresholds. `values` and `area` have V entries; values that are NaN, and those
/// without area, are ignored.
pub fn least_variance_thresholds(values: &[f64], area: &[f64], m: usize) -> Vec<f64> {
    let moments = Moments::of(values, area);
    let n = moments.values.len();
    let classes = m.min(n);
    // The least cost of the first i values in p classes, and where the last of them begins.
    let mut cost: Vec<f64> = (0..=n).map(|i| moments.scatter(0..i)).collect();
    let mut first: Vec<Vec<usize>> = Vec::new();
    for p in 1..classes {
        let (mut next, mut begin) = (vec![f64::INFINITY; n + 1], vec![p; n + 1]);
        Layer { moments: &moments, before: &cost, cost: &mut next, first: &mut begin }
            .fill(p + 1..n + 1, p..n);
        first.push(begin);
        cost = next;
    }
    let mut end = n;
    let mut thresholds: Vec<f64> = (first.iter().rev())
        .map(|first| {
            end = first[end];
            0.5 * moments.values[end - 1] + 0.5 * moments.values[end]
        })
        .collect();
    thresholds.reverse();
    thresholds
}

/// The class of a value: the number of thresholds at or below it.
pub fn class_of(value: f64, thresholds: &[f64]) -> usize {
    thresholds.partition_point(|&t| t <= value)
}

/// The distinct values, ascending, and sums over those before each.
struct Moments {
    values: Vec<f64>,
    mass: Vec<f64>,
    /// Of a (y - mean).
    first: Vec<f64>,
    /// Of a (y - mean)^2.
    second: Vec<f64>,
}

impl Moments {
    fn of(values: &[f64], area: &[f64]) -> Self {
        let known = values.iter().zip(area).filter(|&(y, &a)| !y.is_nan() && a > 0.0);
        let mut weighted: Vec<(f64, f64)> = known.map(|(&y, &a)| (y, a)).collect();
        weighted.sort_unstable_by(|(x, _), (y, _)| x.total_cmp(y));
        let total: f64 = weighted.iter().map(|(_, a)| a).sum();
        let mean = weighted.iter().map(|(y, a)| a * y).sum::<f64>() / total;
        let mut moments =
            Moments { values: Vec::new(), mass: vec![0.0], first: vec![0.0], second: vec![0.0] };
        let mut sums = [0.0; 3];
        for equal in weighted.chunk_by(|(x, _), (y, _)| x == y) {
            let (y, a) = (equal[0].0, equal.iter().map(|(_, a)| a).sum::<f64>());
            let d = y - mean;
            for (sum, term) in sums.iter_mut().zip([a, a * d, a * d * d]) {
                *sum += term;
            }
            moments.values.push(y);
            moments.mass.push(sums[0]);
            moments.first.push(sums[1]);
            moments.second.push(sums[2]);
        }
        moments
    }

    /// sum a (y - mu)^2 over a range of the values, mu their mean.
    fn scatter(&self, range: Range<usize>) -> f64 {
        let over = |sums: &[f64]| sums[range.end] - sums[range.start];
        let (mass, first, second) = (over(&self.mass), over(&self.first), over(&self.second));
        if mass > 0.0 { (second - first * first / mass).max(0.0) } else { 0.0 }
    }
}

/// The step from p - 1 classes to p.
struct Layer<'a> {
    moments: &'a Moments,
    before: &'a [f64],
    cost: &'a mut [f64],
    first: &'a mut [usize],
}

impl Layer<'_> {
    /// Sets the costs for the given ends, given the range of where the last class may begin: first for the end in the
    /// middle, which divides the beginnings for those before and after it.
    fn fill(&mut self, ends: Range<usize>, begins: Range<usize>) {
        if ends.is_empty() {
            return;
        }
        let end = ends.start + ends.len() / 2;
        let mut best = begins.start;
        for begin in begins.start..begins.end.min(end) {
            let cost = self.before[begin] + self.moments.scatter(begin..end);
            if cost < self.cost[end] {
                (self.cost[end], best) = (cost, begin);
            }
        }
        self.first[end] = best;
        self.fill(ends.start..end, begins.start..best + 1);
        self.fill(end + 1..ends.end, best..begins.end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::rng;
    use rand::RngExt;

    /// The variance within the classes times the area.
    fn within(values: &[f64], area: &[f64], thresholds: &[f64]) -> f64 {
        (0..=thresholds.len())
            .map(|p| {
                let own = || {
                    let all = values.iter().zip(area);
                    all.filter(move |(y, _)| class_of(**y, thresholds) == p)
                };
                let mass: f64 = own().map(|(_, a)| a).sum();
                let mean = own().map(|(y, a)| a * y).sum::<f64>() / mass;
                own().map(|(y, a)| a * (y - mean).powi(2)).sum::<f64>()
            })
            .sum()
    }

    /// All ways to divide the sorted values into m classes are no better.
    #[test]
    fn no_other_thresholds_have_less_variance() {
        let mut rng = rng(901);
        for n in [5, 9, 12] {
            let values: Vec<f64> = (0..n).map(|_| rng.random_range(-1.0..1.0)).collect();
            let area: Vec<f64> = (0..n).map(|_| rng.random_range(0.1..1.0)).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            for m in 2..=4 {
                let found = least_variance_thresholds(&values, &area, m);
                assert_eq!(found.len(), m - 1);
                let least = within(&values, &area, &found);
                for subset in 0_u32..1 << (n - 1) {
                    if subset.count_ones() as usize == m - 1 {
                        let chosen = (1..n).filter(|i| subset >> (i - 1) & 1 == 1);
                        let thresholds: Vec<f64> = chosen.map(|i| sorted[i]).collect();
                        let other = within(&values, &area, &thresholds);
                        assert!(least <= other + 1e-12, "{n}, {m}: {least} {other}");
                    }
                }
            }
        }
    }

    /// Two groups of values: the threshold is in the middle of the gap, wherever the data lie.
    #[test]
    fn the_threshold_lies_in_the_gap() {
        for offset in [0.0, 1e6, -1e9] {
            let values = [0.0, 0.5, 1.0, 9.0, 9.5].map(|y| y + offset);
            assert_eq!(least_variance_thresholds(&values, &[1.0; 5], 2), [5.0 + offset]);
        }
        assert_eq!([4.9, 5.0, 5.1].map(|y| class_of(y, &[5.0])), [0, 1, 1]);
    }

    #[test]
    fn fewer_values_than_classes_give_fewer_thresholds() {
        let values = [2.0, f64::NAN, 2.0, 4.0, 1e9];
        let area = [1.0, 1.0, 1.0, 1.0, 0.0];
        assert_eq!(least_variance_thresholds(&values, &area, 5), [3.0]);
        assert!(least_variance_thresholds(&[7.0; 3], &[1.0; 3], 4).is_empty());
    }

    /// A weight of two is two values, and many values take O(n log n).
    #[test]
    fn weights_count_as_repetitions() {
        let mut rng = rng(902);
        let values: Vec<f64> = (0..20_000).map(|_| rng.random_range(0.0_f64..1.0)).collect();
        let area: Vec<f64> = values.iter().map(|_| f64::from(rng.random_range(1..3))).collect();
        let twice: Vec<f64> = (values.iter().zip(&area))
            .flat_map(|(&y, &a)| std::iter::repeat_n(y, a as usize))
            .collect();
        let one = least_variance_thresholds(&values, &area, 4);
        let other = least_variance_thresholds(&twice, &vec![1.0; twice.len()], 4);
        assert_eq!(one, other);
        // Uniform values have classes of equal length.
        assert!(one.iter().zip([0.25, 0.5, 0.75]).all(|(t, quarter)| (t - quarter).abs() < 0.02));
    }
}
