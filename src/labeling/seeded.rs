//! Initial labels from seeds.
//!
//! ```text
//! c_p      = mean of the data at the seeds of region p; for regions without seeds, the centers of k-means that are
//!            left when each region with seeds has taken the nearest one
//! label_k  = that of the seed, else argmin_p |y_k - c_p|
//! ```

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::data::Data;
use crate::data::kmeans::kmeans;
use crate::seeds::Seeds;

/// The labels of the V vertices, for m regions and vertex weights; 0 where the data are unknown.
pub fn initial_labels(
    data: &Data,
    seeds: &Seeds,
    weights: &[f64],
    m: usize,
    rng_seed: u64,
) -> Vec<usize> {
    let mut rng = Pcg64::seed_from_u64(rng_seed);
    let mut left = kmeans(&data.values, data.dimension, &data.known_area(weights), m, &mut rng);
    let of_seeds = means_at_seeds(data, seeds, m);
    for center in of_seeds.iter().flatten() {
        left.remove(nearest(center, &left));
    }
    let mut left = left.into_iter();
    let mut given = |center: Option<Vec<f64>>| center.or_else(|| left.next());
    let centers: Vec<Vec<f64>> = of_seeds.into_iter().filter_map(&mut given).collect();
    let label = |k: usize| data.known(k).map_or(0, |y| nearest(y, &centers));
    (0..data.len()).map(|k| seeds.region(k).unwrap_or_else(|| label(k))).collect()
}

/// `None` for regions without seeds whose data are known.
fn means_at_seeds(data: &Data, seeds: &Seeds, m: usize) -> Vec<Option<Vec<f64>>> {
    let mut sums = vec![vec![0.0; data.dimension]; m];
    let mut counts = vec![0_u32; m];
    for k in 0..data.len() {
        if let (Some(p), Some(y)) = (seeds.region(k), data.known(k)) {
            counts[p] += 1;
            sums[p].iter_mut().zip(y).for_each(|(sum, y)| *sum += y);
        }
    }
    let mean = |sum: Vec<f64>, count: u32| sum.into_iter().map(|y| y / f64::from(count)).collect();
    sums.into_iter().zip(counts).map(|(sum, n)| (n > 0).then(|| mean(sum, n))).collect()
}

/// The first of the nearest centers.
fn nearest(y: &[f64], centers: &[Vec<f64>]) -> usize {
    let squared = |c: &[f64]| y.iter().zip(c).map(|(y, c)| (y - c).powi(2)).sum::<f64>();
    let cost: Vec<f64> = centers.iter().map(|c| squared(c)).collect();
    (1..cost.len()).fold(0, |best, p| if cost[p] < cost[best] { p } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regions are numbered as the seeds say; a region without seeds gets the cluster that is left.
    #[test]
    fn seeds_number_the_clusters() {
        let values = [0.0, 0.1, 5.0, 5.1, 9.0, 9.1];
        let data = Data::new(1, values.to_vec()).unwrap();
        let mut given = vec![None; 6];
        (given[4], given[0]) = (Some(0), Some(2));
        let labels = initial_labels(&data, &Seeds::new(given.clone()), &[1.0; 6], 3, 0);
        assert_eq!(labels, [2, 2, 1, 1, 0, 0]);
        // A seed keeps its region where its datum is far from the others.
        given[2] = Some(2);
        let labels = initial_labels(&data, &Seeds::new(given), &[1.0; 6], 3, 0);
        assert_eq!((labels[2], labels[4]), (2, 0));
    }
}
