//! A mixture of normal distributions fitted to the data, ignoring their positions: the initial parameters.
//!
//! ```text
//! max over pi, mu, Sigma of     sum_k w_k log sum_p pi_p exp(-s_p(y_k))
//! ```
//!
//! by expectation maximization: A. P. Dempster, N. M. Laird, D. B. Rubin, *Maximum likelihood from incomplete data via
//! the EM algorithm*, J. R. Stat. Soc. B 39, 1977. It finds local maxima, so several partitions compete on a random
//! subset of the data for a few steps, and the most likely one continues. The partitions are clusters of k-means, the
//! nearest of random data, and clusters split by the distance from their center: regions of equal means and different
//! spreads are shells.

use rand::{Rng, RngExt};

use super::floor::Floor;
use super::normal::{Density, Moments, Sums};
use crate::data::kmeans::kmeans;
use crate::sweep::results;

const SUBSET_SIZE: usize = 4096;
const RANDOM_PARTITIONS: usize = 4;
const TRIAL_STEPS: usize = 10;
const FINAL_STEPS: usize = 60;

/// EM ends when a step increases the mean logarithm of the likelihood by less than this.
const MIN_GAIN: f64 = 1e-6;

/// A random subset of the data whose weight is positive.
#[derive(Clone)]
pub struct Samples {
    floor: Floor,
    weight: Vec<f64>,
    /// d numbers each.
    rows: Vec<f64>,
    /// The rows in coordinates in which the covariance of all data is 1.
    whitened: Vec<f64>,
}

/// A mixture after some steps.
struct Mixture {
    share: Vec<f64>,
    parts: Vec<Moments>,
    /// The mean logarithm of the likelihood before the last step.
    likelihood: f64,
}

impl Samples {
    /// Drawn without replacement from the rows of positive weight.
    pub fn draw(floor: &Floor, rows: &[f64], weights: &[f64], rng: &mut impl Rng) -> Self {
        let d = floor.center.len();
        let used: Vec<usize> = (0..weights.len()).filter(|&k| weights[k] > 0.0).collect();
        let (mut weight, mut drawn, mut whitened) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &k) in used.iter().enumerate() {
            // Selection sampling, Knuth's algorithm S.
            let missing = SUBSET_SIZE.min(used.len()) - weight.len();
            if rng.random_range(0..used.len() - i) < missing {
                let row = &rows[k * d..][..d];
                weight.push(weights[k]);
                drawn.extend(row);
                whitened.extend(floor.whitened(row));
            }
        }
        Samples { floor: floor.clone(), weight, rows: drawn, whitened }
    }

    fn dimension(&self) -> usize {
        self.floor.center.len()
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.rows[k * self.dimension()..][..self.dimension()]
    }

    fn whitened(&self, k: usize) -> &[f64] {
        &self.whitened[k * self.dimension()..][..self.dimension()]
    }

    /// The parameters of the most likely mixture of m parts that is found.
    pub fn fitted(&self, m: usize, rng: &mut impl Rng) -> Vec<Moments> {
        let mut clusters = vec![1, m.div_ceil(2), m];
        clusters.dedup();
        let mut partitions: Vec<Vec<usize>> = Vec::new();
        for clusters in clusters {
            let centers = kmeans(&self.whitened, self.dimension(), &self.weight, clusters, rng);
            partitions.push(self.shells(&centers, m));
        }
        for _ in 0..RANDOM_PARTITIONS {
            let drawn =
                (0..m).map(|_| self.whitened(rng.random_range(0..self.weight.len())).to_vec());
            partitions.push(self.nearest(&drawn.collect::<Vec<_>>()));
        }
        let tried =
            results(partitions, |labels| self.improved(self.of_partition(&labels, m), TRIAL_STEPS));
        // In case of ties the first, so that rounding does not decide.
        let likelier = |a: Mixture, b: Mixture| {
            if b.likelihood > a.likelihood + MIN_GAIN { b } else { a }
        };
        let best = tried.into_iter().reduce(likelier).expect("there are partitions");
        let Mixture { share, parts, .. } = self.improved(best, FINAL_STEPS);
        // The largest first: in which order k-means finds clusters may depend on rounding.
        let mut parts: Vec<(f64, Moments)> = share.into_iter().zip(parts).collect();
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        parts.into_iter().map(|(_, part)| part).collect()
    }

    /// The index of the nearest center of each row, the first of equals.
    fn nearest(&self, centers: &[Vec<f64>]) -> Vec<usize> {
        let nearest = |k: usize| {
            let distance = |c: &Vec<f64>| squared_distance(self.whitened(k), c);
            let nearer =
                |a: &usize, b: &usize| distance(&centers[*a]).total_cmp(&distance(&centers[*b]));
            (0..centers.len()).min_by(nearer).expect("there are centers")
        };
        (0..self.weight.len()).map(nearest).collect()
    }

    /// m parts: the clusters around the centers, split into shells of equal weight. Larger clusters have one more shell
    /// where their number does not divide m.
    fn shells(&self, centers: &[Vec<f64>], m: usize) -> Vec<usize> {
        let clusters = self.nearest(centers);
        let mut masses = vec![0.0; centers.len()];
        clusters.iter().zip(&self.weight).for_each(|(&p, w)| masses[p] += w);
        let mut largest_first: Vec<usize> = (0..centers.len()).collect();
        largest_first.sort_by(|&a, &b| masses[b].total_cmp(&masses[a]));
        let mut labels = vec![0; clusters.len()];
        let mut first = 0;
        for (rank, &p) in largest_first.iter().enumerate() {
            let shells = m / centers.len() + usize::from(rank < m % centers.len());
            let radius = |k: usize| squared_distance(self.whitened(k), &centers[p]);
            let mut members: Vec<(f64, usize)> =
                (0..clusters.len()).filter(|&k| clusters[k] == p).map(|k| (radius(k), k)).collect();
            members.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut passed = 0.0;
            for (_, k) in members {
                let shell = (passed / masses[p] * shells as f64) as usize;
                labels[k] = first + shell.min(shells - 1);
                passed += self.weight[k];
            }
            first += shells;
        }
        labels
    }

    /// What fits a partition; an empty part is like all data.
    fn of_partition(&self, labels: &[usize], m: usize) -> Mixture {
        let mut sums = vec![Sums::new(self.dimension()); m + 1];
        for (k, &p) in labels.iter().enumerate() {
            for p in [p, m] {
                sums[p].add(self.weight[k], self.row(k), &[], &self.floor.center);
            }
        }
        let total = sums[m].mass;
        let fitted = |p: usize| {
            let sums = if sums[p].mass > 0.0 { &sums[p] } else { &sums[m] };
            self.floor.raised(sums.moments(&self.floor.center))
        };
        Mixture {
            share: (0..m).map(|p| sums[p].mass / total).collect(),
            parts: (0..m).map(fitted).collect(),
            likelihood: f64::NEG_INFINITY,
        }
    }

    /// The mixture after the given number of steps of EM, or fewer if it no longer improves.
    fn improved(&self, mut mixture: Mixture, steps: usize) -> Mixture {
        for _ in 0..steps {
            let before = mixture.likelihood;
            mixture = self.step(mixture);
            if mixture.likelihood - before < MIN_GAIN {
                break;
            }
        }
        mixture
    }

    fn step(&self, mixture: Mixture) -> Mixture {
        let Mixture { mut share, mut parts, .. } = mixture;
        let m = parts.len();
        let densities: Vec<Density> = parts.iter().map(Density::new).collect();
        let offsets: Vec<f64> = share.iter().map(|share| share.ln()).collect();
        let mut sums = vec![Sums::new(self.dimension()); m];
        let (mut likelihood, mut total) = (0.0, 0.0);
        let mut logs = vec![0.0; m];
        for (k, &w) in self.weight.iter().enumerate() {
            let row = self.row(k);
            for ((log, density), offset) in logs.iter_mut().zip(&densities).zip(&offsets) {
                *log = offset - density.cost(row, &[]);
            }
            let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            logs.iter_mut().for_each(|log| *log = (*log - largest).exp());
            let sum: f64 = logs.iter().sum();
            likelihood += w * (largest + sum.ln());
            total += w;
            for (sums, part) in sums.iter_mut().zip(&logs) {
                if *part > 0.0 {
                    sums.add(w * part / sum, row, &[], &self.floor.center);
                }
            }
        }
        for ((share, part), sums) in share.iter_mut().zip(&mut parts).zip(&sums) {
            *share = sums.mass / total;
            if sums.mass > f64::EPSILON * total {
                *part = self.floor.raised(sums.moments(&self.floor.center));
            }
        }
        Mixture { share, parts, likelihood: likelihood / total }
    }
}

fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
