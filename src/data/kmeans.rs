//! Area-weighted k-means in the space of the data: where the region parameters start.
//!
//! Minimizes sum_k a_k min_p |y_k - c_p|^2 over the centers c_p. Seeding: D. Arthur, S. Vassilvitskii,
//! *k-means++: the advantages of careful seeding*, SODA 2007: each next center is a datum drawn with
//! probability a_k D_k^2, D_k the distance to the centers so far. Then Lloyd's alternation of nearest
//! centers and weighted means. Several seedings compete on a random subset of the data; the best one
//! continues on all of them.

use rand::{Rng, RngExt};

use crate::sweep::collect;

const SEEDINGS: usize = 8;
const SUBSET: usize = 4096;
const STEPS: usize = 50;

/// The centers c_p of `regions` clusters, as many rows of d values.
///
/// `data` holds V rows of d values, `area` the V weights; rows without weight are ignored, all others finite, and some
/// weight must be positive. Fewer distinct rows than regions give repeated centers. Deterministic for a
/// given state of `rng`.
pub fn kmeans(
    data: &[f64],
    d: usize,
    area: &[f64],
    regions: usize,
    rng: &mut impl Rng,
) -> Vec<Vec<f64>> {
    assert!(d > 0 && regions > 0 && data.len() == d * area.len());
    let all = Weighted::positive(data, d, area);
    assert!(!all.weight.is_empty(), "no datum has a positive weight");

    let subset = all.subset(SUBSET, rng);
    let mut best = (f64::INFINITY, Vec::new());
    for _ in 0..SEEDINGS {
        let mut centers = subset.seed(regions, rng);
        let cost = subset.lloyd(&mut centers);
        if cost < best.0 || best.1.is_empty() {
            best = (cost, centers);
        }
    }
    let mut centers = best.1;
    if subset.weight.len() < all.weight.len() {
        all.lloyd(&mut centers);
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
    fn seed(&self, regions: usize, rng: &mut impl Rng) -> Vec<f64> {
        let mut centers = self.row(draw(&self.weight, rng)).to_vec();
        let mut distance = vec![f64::INFINITY; self.weight.len()];
        let mut chance = vec![0.0; self.weight.len()];
        while centers.len() < regions * self.d {
            let newest = &centers[centers.len() - self.d..];
            for (k, nearest) in distance.iter_mut().enumerate() {
                *nearest = nearest.min(distance_squared(self.row(k), newest));
                chance[k] = self.weight[k] * *nearest;
            }
            let covered = chance.iter().all(|&c| c == 0.0);
            let next = draw(if covered { &self.weight } else { &chance }, rng);
            centers.extend_from_slice(self.row(next));
        }
        centers
    }

    /// Lloyd's steps until no row changes its center, or a fixed number of them. Returns the cost of the
    /// centers before the last step, which the step can only lower. An empty cluster keeps its center.
    fn lloyd(&self, centers: &mut [f64]) -> f64 {
        let regions = centers.len() / self.d;
        let mut assigned = vec![usize::MAX; self.weight.len()];
        let mut cost = f64::INFINITY;
        for _ in 0..STEPS {
            let mut changed = false;
            let mut sums = vec![0.0; centers.len()];
            let mut weights = vec![0.0; regions];
            cost = 0.0;
            let found = collect(self.weight.len(), |k| nearest(self.row(k), centers));
            for (k, (&a, (p, distance))) in self.weight.iter().zip(found).enumerate() {
                changed |= assigned[k] != p;
                assigned[k] = p;
                cost += a * distance;
                weights[p] += a;
                let sum = &mut sums[p * self.d..][..self.d];
                sum.iter_mut().zip(self.row(k)).for_each(|(s, y)| *s += a * y);
            }
            if !changed {
                break;
            }
            for p in (0..regions).filter(|&p| weights[p] > 0.0) {
                for i in p * self.d..(p + 1) * self.d {
                    centers[i] = sums[i] / weights[p];
                }
            }
        }
        cost
    }
}

/// The nearest center, the first of equals, and its squared distance.
fn nearest(row: &[f64], centers: &[f64]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (p, center) in centers.chunks_exact(row.len()).enumerate() {
        let distance = distance_squared(row, center);
        if distance < best.1 {
            best = (p, distance);
        }
    }
    best
}

fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(s, t)| (s - t) * (s - t)).sum()
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
                let hits = found.iter().filter(|c| distance_squared(c, &center) < 1e-3).count();
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

    #[test]
    fn lloyd_never_raises_the_cost_of_the_seeding() {
        let data = blobs(&[[0.0, 0.0], [0.3, 0.1], [0.1, 0.4]], 100, 0.5);
        let samples = Weighted::positive(&data, 2, &[1.0; 300]);
        for seed in 0..20 {
            let mut centers = samples.seed(4, &mut rng(seed));
            let seeded: f64 = (0..300).map(|k| nearest(samples.row(k), &centers).1).sum();
            samples.lloyd(&mut centers);
            let reached: f64 = (0..300).map(|k| nearest(samples.row(k), &centers).1).sum();
            assert!(reached <= seeded, "{reached} {seeded}");
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

    /// A datum far away with next to no area is drawn in next to no seeding: a_k D_k^2, not D_k^2.
    #[test]
    fn a_speck_far_away_is_no_center() {
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
