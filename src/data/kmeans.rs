//! Area-weighted k-means and k-medians in the space of the data: the initial region parameters.
//!
//! ```text
//! sum_k a_k min_p |y_k - c_p|^2      centers are means
//! sum_k a_k min_p |y_k - c_p|_1      centers are medians, coordinate by coordinate
//! ```
//!
//! is minimized over the centers c_p. Seeding is by k-means++: each center is a datum drawn with a probability
//! proportional to a_k times its cost with the nearest center so far. Lloyd's iteration then alternates between nearest
//! centers and weighted means or medians. Several seedings compete on a random subset of the data; the best one
//! continues on all data if that is fast. Reference: D. Arthur, S. Vassilvitskii, *k-means++: the advantages of careful
//! seeding*, SODA 2007.

use rand::{Rng, RngExt};

use super::range::median;
use crate::sweep::{collect, results};

const SEEDINGS: usize = 8;
const SUBSET_SIZE: usize = 4096;
const LLOYD_STEPS: usize = 50;

/// The centers c_p of `regions` clusters, one row of d values each.
///
/// `data` holds V rows of d values, `area` the V weights; rows without weight are ignored, all others must be finite,
/// and some weight must be positive. Fewer distinct rows than regions give repeated centers. Deterministic for a given
/// state of `rng`.
pub fn kmeans(
    data: &[f64],
    d: usize,
    area: &[f64],
    regions: usize,
    rng: &mut impl Rng,
) -> Vec<Vec<f64>> {
    clusters::<Squares>(data, d, area, regions, rng)
}

/// The same with medians, of the random subset only: medians of all data need a sort per step and differ little.
pub fn kmedians(
    data: &[f64],
    d: usize,
    area: &[f64],
    regions: usize,
    rng: &mut impl Rng,
) -> Vec<Vec<f64>> {
    clusters::<Absolutes>(data, d, area, regions, rng)
}

/// The kind of center: mean or median.
trait Center: Sized {
    /// Whether Lloyd's steps on all data are fast.
    const FAST_ON_ALL_DATA: bool;

    /// The cost of a datum with a center.
    fn cost(datum: &[f64], center: &[f64]) -> f64;

    /// One step of Lloyd's iteration: moves the center of each cluster to where the cost of its data is smallest; the
    /// center of an empty cluster stays. Returns the cost of the centers before.
    fn step(data: &Weighted, centers: &mut [f64]) -> f64;
}

struct Squares;

impl Center for Squares {
    const FAST_ON_ALL_DATA: bool = true;

    fn cost(datum: &[f64], center: &[f64]) -> f64 {
        datum.iter().zip(center).map(|(s, t)| (s - t) * (s - t)).sum()
    }

    fn step(data: &Weighted, centers: &mut [f64]) -> f64 {
        let d = data.d;
        let none = || (0.0, vec![0.0; centers.len() / d], vec![0.0; centers.len()]);
        let n = data.weight.len();
        let blocks = results((0..n).step_by(SUBSET_SIZE).collect(), |from: usize| {
            let (mut cost, mut weights, mut sums) = none();
            for k in from..n.min(from + SUBSET_SIZE) {
                let (row, a) = (data.row(k), data.weight[k]);
                let (p, cost_here) = nearest::<Self>(row, centers);
                cost += a * cost_here;
                weights[p] += a;
                sums[p * d..][..d].iter_mut().zip(row).for_each(|(sum, y)| *sum += a * y);
            }
            (cost, weights, sums)
        });
        let (mut cost, mut weights, mut sums) = none();
        for (more, more_weights, more_sums) in blocks {
            cost += more;
            weights.iter_mut().zip(more_weights).for_each(|(total, more)| *total += more);
            sums.iter_mut().zip(more_sums).for_each(|(total, more)| *total += more);
        }
        for p in (0..weights.len()).filter(|&p| weights[p] > 0.0) {
            for i in p * d..(p + 1) * d {
                centers[i] = sums[i] / weights[p];
            }
        }
        cost
    }
}

struct Absolutes;

impl Center for Absolutes {
    const FAST_ON_ALL_DATA: bool = false;

    fn cost(datum: &[f64], center: &[f64]) -> f64 {
        datum.iter().zip(center).map(|(s, t)| (s - t).abs()).sum()
    }

    fn step(data: &Weighted, centers: &mut [f64]) -> f64 {
        let n = data.weight.len();
        let found = collect(n, |k| nearest::<Self>(data.row(k), centers));
        for (p, center) in centers.chunks_mut(data.d).enumerate() {
            let members = || (0..n).filter(|&k| found[k].0 == p);
            let weight: Vec<f64> = members().map(|k| data.weight[k]).collect();
            if weight.is_empty() {
                continue;
            }
            for (i, center) in center.iter_mut().enumerate() {
                let values: Vec<f64> = members().map(|k| data.row(k)[i]).collect();
                *center = median(&values, &weight);
            }
        }
        found.iter().zip(&data.weight).map(|((_, cost), a)| a * cost).sum()
    }
}

fn clusters<C: Center>(
    data: &[f64],
    d: usize,
    area: &[f64],
    regions: usize,
    rng: &mut impl Rng,
) -> Vec<Vec<f64>> {
    assert!(d > 0 && regions > 0 && data.len() == d * area.len());
    let all = Weighted::positive(data, d, area);
    assert!(!all.weight.is_empty(), "no datum has a positive weight");

    let subset = all.subset(SUBSET_SIZE, rng);
    let seeds = (0..SEEDINGS).map(|_| subset.seed::<C>(regions, rng)).collect();
    let found = results(seeds, |mut centers: Vec<f64>| (subset.lloyd::<C>(&mut centers), centers));
    let mut best = (f64::INFINITY, Vec::new());
    for (cost, centers) in found {
        if cost < best.0 || best.1.is_empty() {
            best = (cost, centers);
        }
    }
    let mut centers = best.1;
    if C::FAST_ON_ALL_DATA && subset.weight.len() < all.weight.len() {
        all.lloyd::<C>(&mut centers);
    }
    centers.chunks(d).map(<[f64]>::to_vec).collect()
}

/// Rows y_k of d values with positive weights a_k.
struct Weighted {
    d: usize,
    rows: Vec<f64>,
    weight: Vec<f64>,
}

impl Weighted {
    fn positive(data: &[f64], d: usize, area: &[f64]) -> Self {
        let mut kept = Weighted {
            d,
            rows: Vec::with_capacity(data.len()),
            weight: Vec::with_capacity(area.len()),
        };
        for (row, &a) in data.chunks(d).zip(area) {
            if a > 0.0 {
                assert!(row.iter().all(|value| value.is_finite()));
                kept.rows.extend_from_slice(row);
                kept.weight.push(a);
            }
        }
        kept
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.d..][..self.d]
    }

    /// At most `count` rows, drawn without replacement (selection sampling, Knuth's algorithm S).
    fn subset(&self, count: usize, rng: &mut impl Rng) -> Weighted {
        let mut chosen = Weighted { d: self.d, rows: Vec::new(), weight: Vec::new() };
        let total = self.weight.len();
        for k in 0..total {
            let missing = count.min(total) - chosen.weight.len();
            if rng.random_range(0..total - k) < missing {
                chosen.rows.extend_from_slice(self.row(k));
                chosen.weight.push(self.weight[k]);
            }
        }
        chosen
    }

    /// k-means++; once every row coincides with a center, rows are drawn by weight alone.
    fn seed<C: Center>(&self, regions: usize, rng: &mut impl Rng) -> Vec<f64> {
        let mut centers = self.row(draw(&self.weight, rng)).to_vec();
        let mut cost = vec![f64::INFINITY; self.weight.len()];
        let mut chance = vec![0.0; self.weight.len()];
        while centers.len() < regions * self.d {
            let newest = &centers[centers.len() - self.d..];
            for (k, nearest) in cost.iter_mut().enumerate() {
                *nearest = nearest.min(C::cost(self.row(k), newest));
                chance[k] = self.weight[k] * *nearest;
            }
            let covered = chance.iter().all(|&c| c == 0.0);
            let next = draw(if covered { &self.weight } else { &chance }, rng);
            centers.extend_from_slice(self.row(next));
        }
        centers
    }

    /// Lloyd's steps until no center moves, or a fixed number of them. Returns the cost of the centers before the last
    /// step, which the step can only lower.
    fn lloyd<C: Center>(&self, centers: &mut [f64]) -> f64 {
        let mut cost = f64::INFINITY;
        for _ in 0..LLOYD_STEPS {
            let before = centers.to_vec();
            cost = C::step(self, centers);
            if before == centers {
                break;
            }
        }
        cost
    }
}

/// The nearest center, the first of equals, and its cost.
#[inline(always)]
fn nearest<C: Center>(row: &[f64], centers: &[f64]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (p, center) in centers.chunks_exact(row.len()).enumerate() {
        let cost = C::cost(row, center);
        if cost < best.1 {
            best = (p, cost);
        }
    }
    best
}

/// An index drawn with probability proportional to the weights, some of which are positive.
fn draw(weights: &[f64], rng: &mut impl Rng) -> usize {
    let mut left = rng.random::<f64>() * weights.iter().sum::<f64>();
    let mut last = 0;
    for (k, &a) in weights.iter().enumerate().filter(|&(_, &a)| a > 0.0) {
        last = k;
        left -= a;
        if left < 0.0 {
            break;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    fn rng(seed: u64) -> Pcg64 {
        Pcg64::seed_from_u64(seed)
    }

    /// n points around each of the given planar centers.
    fn blobs(centers: &[[f64; 2]], n: usize, radius: f64) -> Vec<f64> {
        let mut rng = rng(7);
        let mut data = Vec::new();
        for _ in 0..n {
            for center in centers {
                data.extend(center.map(|c| c + radius * (rng.random::<f64>() - 0.5)));
            }
        }
        data
    }

    #[test]
    fn separated_blobs_are_found() {
        let truth = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]];
        for n in [40, 4000] {
            let data = blobs(&truth, n, 0.1);
            let found = kmeans(&data, 2, &vec![1.0; n * truth.len()], 5, &mut rng(1));
            for center in truth {
                let hits = found.iter().filter(|c| Squares::cost(c, &center) < 1e-3).count();
                assert_eq!(hits, 1, "{found:?}");
            }
        }
    }

    #[test]
    fn a_weight_of_two_is_two_vertices() {
        let data = [0.0, 0.2, 0.9, 1.0];
        let weighted = kmeans(&data, 1, &[2.0, 1.0, 1.0, 3.0], 1, &mut rng(2));
        let repeated = [0.0, 0.0, 0.2, 0.9, 1.0, 1.0, 1.0];
        let counted = kmeans(&repeated, 1, &[1.0; 7], 1, &mut rng(3));
        assert!((weighted[0][0] - counted[0][0]).abs() < 1e-15);
        assert!((weighted[0][0] - 4.1 / 7.0).abs() < 1e-15);
    }

    fn lloyd_lowers_the_cost_of<C: Center>() {
        let data = blobs(&[[0.0, 0.0], [0.3, 0.1], [0.1, 0.4]], 100, 0.5);
        let samples = Weighted::positive(&data, 2, &[1.0; 300]);
        for seed in 0..20 {
            let mut centers = samples.seed::<C>(4, &mut rng(seed));
            let cost = |centers: &[f64]| -> f64 {
                (0..300).map(|k| nearest::<C>(samples.row(k), centers).1).sum()
            };
            let seeded = cost(&centers);
            samples.lloyd::<C>(&mut centers);
            let reached = cost(&centers);
            assert!(reached <= seeded, "{reached} {seeded}");
        }
    }

    #[test]
    fn lloyd_never_raises_the_cost_of_the_seeding() {
        lloyd_lowers_the_cost_of::<Squares>();
        lloyd_lowers_the_cost_of::<Absolutes>();
    }

    /// Moving a tenth of the data far away moves the means, but hardly the medians.
    #[test]
    fn outliers_move_means_more_than_medians() {
        let truth = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mut data = blobs(&truth, 2000, 0.1);
        let mut rng = rng(8);
        data.extend((0..1200).map(|_| rng.random_range(-2.0..3.0)));
        let area = vec![1.0; data.len() / 2];
        let found = kmedians(&data, 2, &area, 3, &mut rng);
        for center in truth {
            let hits = found.iter().filter(|c| Squares::cost(c, &center) < 1e-3).count();
            assert_eq!(hits, 1, "{found:?}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_bits() {
        let data = blobs(&[[0.0, 0.0], [1.0, 2.0]], 5000, 2.0);
        let run = || kmeans(&data, 2, &[1.0; 10_000], 3, &mut rng(11));
        assert_eq!(run(), run());
    }

    #[test]
    fn rows_without_area_are_ignored() {
        let data = [0.0, 1.0, 1e6, 0.0, 1.0];
        let mut found = kmeans(&data, 1, &[1.0, 1.0, 0.0, 1.0, 1.0], 2, &mut rng(5));
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(found, vec![vec![0.0], vec![1.0]]);
    }

    /// A distant datum with almost no area is almost never a seed: the probability is a_k D_k^2, not D_k^2.
    #[test]
    fn a_distant_datum_of_tiny_area_is_no_center() {
        let mut data = blobs(&[[0.0, 0.0], [1.0, 0.0]], 100, 0.1);
        data.extend([1e3, 0.0]);
        let area: Vec<f64> = (0..201).map(|k| if k < 200 { 1.0 } else { 1e-9 }).collect();
        for seed in 0..5 {
            let found = kmeans(&data, 2, &area, 2, &mut rng(seed));
            assert!(found.iter().all(|c| c[0].abs() < 2.0), "{found:?}");
        }
    }

    #[test]
    fn fewer_values_than_regions_repeat_centers() {
        let found = kmeans(&[0.25; 12], 3, &[1.0; 4], 64, &mut rng(6));
        assert_eq!(found, vec![vec![0.25; 3]; 64]);
        let found = kmeans(&[0.0, 1.0], 1, &[1.0, 1.0], 5, &mut rng(6));
        assert!(found.iter().all(|c| c[0] == 0.0 || c[0] == 1.0));
        assert!(found.contains(&vec![0.0]) && found.contains(&vec![1.0]));
    }
}
