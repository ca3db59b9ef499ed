//! Initial histograms: clusters of the data that also use which data are near each other.
//!
//! Any partition of the values makes histograms that fit, so values alone do not tell which values belong together: where
//! one region has the values +1 and -1, and another those around 0, nothing but their positions says so. Neighbors in the
//! numbering of the vertices are mostly neighbors on the surface. So the data are taken in short runs, and each run is from
//! one region:
//!
//! ```text
//! max over pi, D of     sum_g log sum_p pi_p exp( - sum_{k in g} s_p(y_k) )
//! ```
//!
//! by expectation maximization: a mixture of multinomial distributions. K. Nigam, A. McCallum, S. Thrun, T. Mitchell, *Text
//! classification from labeled and unlabeled documents using EM*, Machine Learning 39, 2000. Several partitions compete:
//! clusters of normal distributions, shells around the median, and the nearest to some random runs. They are fitted to every
//! other datum of the runs, and the best is that which explains most of the other half. Where none explains any of it, as in
//! a random numbering, the clusters of normal distributions are taken as they are.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::density::{costs, masses};
use super::grid::{Corners, Grid};
use crate::data::range::median;
use crate::data::{Data, DataModel, Gaussian, Initial};
use crate::error::Result;
use crate::sweep::results;

const RUN: usize = 8;
const MAX_RUNS: usize = 2048;
const RANDOM_PARTITIONS: usize = 8;
const TRIAL_STEPS: usize = 15;
const FINAL_STEPS: usize = 30;

/// A partition has to explain more than this of the other half, in nats per datum.
const MIN_GAIN: f64 = 0.01;

/// Runs of data, in which vertices of positive weight are adjacent in the numbering.
pub struct Samples {
    data: Data,
    /// Relative to their mean.
    weight: Vec<f64>,
}

impl Samples {
    /// Evenly distributed over the data with positive weight.
    pub fn draw(data: &Data, weights: &[f64]) -> Self {
        let used: Vec<usize> = (0..weights.len()).filter(|&k| weights[k] > 0.0).collect();
        let runs: Vec<&[usize]> = used.chunks(RUN).collect();
        let n = runs.len().min(MAX_RUNS);
        let (mut values, mut weight) = (Vec::new(), Vec::new());
        for &k in (0..n).flat_map(|i| runs[i * runs.len() / n]) {
            values.extend(data.at(k));
            weight.push(weights[k]);
        }
        let mean = weight.iter().sum::<f64>() / weight.len() as f64;
        weight.iter_mut().for_each(|w| *w /= mean);
        Samples { data: Data { dimension: data.dimension, values }, weight }
    }

    /// Masses of the bins for each of m regions, the largest first.
    ///
    /// # Errors
    /// Those of the mixture of normal distributions.
    pub fn clustered(&self, grid: &Grid, m: usize, rng: &mut Pcg64) -> Result<Vec<Vec<f64>>> {
        let corners = (0..self.weight.len()).map(|k| grid.corners(self.data.at(k))).collect();
        let runs = Runs { grid, corners, weight: &self.weight, m };
        let normal = self.normal(m, rng)?;
        let mut partitions = vec![runs.of_labels(&normal), runs.of_labels(&self.shells(grid, m))];
        partitions.extend((0..RANDOM_PARTITIONS).map(|_| runs.nearest_to_random_runs(rng)));
        let tried = results(partitions, |posterior| {
            let mixture = runs.improved(posterior, EVEN, TRIAL_STEPS);
            (runs.gain(&mixture), mixture)
        });
        // In case of ties the first, so that rounding does not decide.
        let better =
            |a: (f64, Mixture), b: (f64, Mixture)| if b.0 > a.0 + MIN_GAIN { b } else { a };
        let (gain, best) = tried.into_iter().reduce(better).expect("there are partitions");
        let mut counts = if gain > MIN_GAIN {
            runs.improved(runs.posterior(&best, EVEN), ALL, FINAL_STEPS).counts
        } else {
            runs.counts(ALL, |k, p| f64::from(u8::from(normal[k] == p)))
        };
        // The largest first: their order otherwise depends on the partition.
        counts.sort_by(|a, b| b.iter().sum::<f64>().total_cmp(&a.iter().sum()));
        Ok(counts.into_iter().map(|counts| runs.or_all(counts)).collect())
    }

    /// The most likely of m normal distributions for each datum.
    fn normal(&self, m: usize, rng: &mut Pcg64) -> Result<Vec<usize>> {
        let model = Gaussian::new(&self.data)?;
        let mu = model.start(Initial::KMeans, m, &self.weight, rng)?;
        let (cost, mut s) = (model.cost(&mu), vec![0.0; m]);
        let cheapest = |k: usize| {
            cost(k, &mut s);
            (0..m).min_by(|&a, &b| s[a].total_cmp(&s[b])).expect("there are regions")
        };
        Ok((0..self.weight.len()).map(cheapest).collect())
    }

    /// m shells of equal weight around the median, in bins.
    fn shells(&self, grid: &Grid, m: usize) -> Vec<usize> {
        let n = self.weight.len();
        let middle: Vec<f64> =
            (0..self.data.dimension).map(|i| median(&self.data.column(i), &self.weight)).collect();
        let mut order: Vec<(f64, usize)> =
            (0..n).map(|k| (grid.squared_distance(self.data.at(k), &middle), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut labels = vec![0; n];
        let mut passed = 0.0;
        for (_, k) in order {
            labels[k] = ((passed / n as f64 * m as f64) as usize).min(m - 1);
            passed += self.weight[k];
        }
        labels
    }
}

/// Which data of a run are used: the first, the third, ...; the others; all.
type Part = fn(usize) -> bool;
const EVEN: Part = |k| k % 2 == 0;
const ODD: Part = |k| k % 2 == 1;
const ALL: Part = |_| true;

/// The mixture of m regions for runs.
struct Runs<'a> {
    grid: &'a Grid,
    corners: Vec<Corners>,
    weight: &'a [f64],
    m: usize,
}

/// The masses of the bins of each region, and its share pi_p.
struct Mixture {
    counts: Vec<Vec<f64>>,
    share: Vec<f64>,
}

impl Runs<'_> {
    fn runs(&self) -> usize {
        self.weight.len().div_ceil(RUN)
    }

    fn members(&self, g: usize, part: Part) -> impl Iterator<Item = usize> {
        (g * RUN..self.weight.len().min((g + 1) * RUN)).filter(move |&k| part(k))
    }

    /// The masses of the bins if datum k is in region p with the given probability.
    fn counts(&self, part: Part, probability: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
        let mut counts = vec![vec![0.0; self.grid.len()]; self.m];
        for k in (0..self.weight.len()).filter(|&k| part(k)) {
            for (p, counts) in counts.iter_mut().enumerate() {
                let w = self.weight[k] * probability(k, p);
                self.corners[k].iter().for_each(|(b, share)| counts[b] += w * share);
            }
        }
        counts
    }

    /// An empty region is like all data.
    fn or_all(&self, counts: Vec<f64>) -> Vec<f64> {
        if counts.iter().any(|&w| w > 0.0) {
            return counts;
        }
        self.counts(ALL, |_, p| f64::from(u8::from(p == 0))).swap_remove(0)
    }

    /// The part of each run that has each label, m numbers per run.
    fn of_labels(&self, labels: &[usize]) -> Vec<f64> {
        let mut posterior = vec![0.0; self.runs() * self.m];
        for g in 0..self.runs() {
            let total: f64 = self.members(g, ALL).map(|k| self.weight[k]).sum();
            self.members(g, ALL)
                .for_each(|k| posterior[g * self.m + labels[k]] += self.weight[k] / total);
        }
        posterior
    }

    /// Each random run stands for a region; half of its data are from anywhere.
    fn nearest_to_random_runs(&self, rng: &mut Pcg64) -> Vec<f64> {
        let m = self.m;
        let chosen: Vec<usize> = (0..m).map(|_| rng.random_range(0..self.runs())).collect();
        let anywhere = RUN as f64 / self.weight.len() as f64;
        let own = |k: usize, p: usize| f64::from(u8::from(k / RUN == chosen[p]));
        let counts = self.counts(EVEN, |k, p| own(k, p) + anywhere);
        self.posterior(&Mixture { counts, share: vec![1.0 / m as f64; m] }, EVEN)
    }

    fn costs(&self, counts: &[f64]) -> Vec<f64> {
        costs(self.grid, &masses(self.grid, self.or_all(counts.to_vec())))
    }

    /// The cost of a run for the costs of the bins.
    fn cost(&self, g: usize, part: Part, costs: &[f64]) -> f64 {
        let cost =
            |k: usize| self.corners[k].iter().map(|(b, share)| share * costs[b]).sum::<f64>();
        self.members(g, part).map(|k| self.weight[k] * cost(k)).sum()
    }

    /// The probabilities of the regions for each run.
    fn posterior(&self, mixture: &Mixture, part: Part) -> Vec<f64> {
        let costs: Vec<Vec<f64>> = mixture.counts.iter().map(|counts| self.costs(counts)).collect();
        let mut posterior = Vec::with_capacity(self.runs() * self.m);
        for g in 0..self.runs() {
            let log = |(costs, share): (&Vec<f64>, &f64)| share.ln() - self.cost(g, part, costs);
            let logs: Vec<f64> = costs.iter().zip(&mixture.share).map(log).collect();
            let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let total: f64 = logs.iter().map(|log| (log - largest).exp()).sum();
            posterior.extend(logs.iter().map(|log| (log - largest).exp() / total));
        }
        posterior
    }

    /// The mixture after the given number of steps of EM.
    fn improved(&self, mut posterior: Vec<f64>, part: Part, steps: usize) -> Mixture {
        let m = self.m;
        for step in 0.. {
            let counts = self.counts(part, |k, p| posterior[k / RUN * m + p]);
            let share =
                |p: usize| posterior[p..].iter().step_by(m).sum::<f64>() / self.runs() as f64;
            let mixture = Mixture { counts, share: (0..m).map(share).collect() };
            if step == steps {
                return mixture;
            }
            posterior = self.posterior(&mixture, part);
        }
        unreachable!("the loop returns")
    }

    /// What a mixture of the even data explains of the odd ones: the mean decrease of their costs when each run has the
    /// most likely region for its even data, relative to one region.
    fn gain(&self, mixture: &Mixture) -> f64 {
        let one = self.counts(EVEN, |_, p| f64::from(u8::from(p == 0))).swap_remove(0);
        let one = self.costs(&one);
        let costs: Vec<Vec<f64>> = mixture.counts.iter().map(|counts| self.costs(counts)).collect();
        let posterior = self.posterior(mixture, EVEN);
        let gain = |(g, row): (usize, &[f64])| {
            let p = (0..self.m).max_by(|&a, &b| row[a].total_cmp(&row[b])).expect("regions");
            self.cost(g, ODD, &one) - self.cost(g, ODD, &costs[p])
        };
        let total: f64 = posterior.chunks(self.m).enumerate().map(gain).sum();
        let odd = (0..self.weight.len()).filter(|&k| ODD(k)).map(|k| self.weight[k]).sum::<f64>();
        if odd > 0.0 { total / odd } else { 0.0 }
    }
}
