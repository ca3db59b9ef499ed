//! Synthetic class probabilities with known labels and noise.
//!
//! ```text
//! y_k = e_{l_k} + sigma n_k,   n_k normal,   p_kp = exp( y_kp / sigma^2 ) / sum_r exp( y_kr / sigma^2 )
//! ```
//!
//! p_kp is the probability that the label l_k is p, given y_k, if all labels are equally likely: the densities of y_k for
//! two labels p and r have the ratio exp( (y_kp - y_kr) / sigma^2 ). So these probabilities are calibrated, as those of a
//! good network are.

use ndarray::Array2;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// The scores y_k / sigma^2 of m classes, whose softmax are the probabilities; one row per label. Panics unless sigma is
/// positive.
pub fn noisy_scores(labels: &[usize], m: usize, sigma: f64, seed: u64) -> Array2<f64> {
    assert!(sigma > 0.0, "without noise there is no probability but 0 and 1");
    let mut rng = Pcg64::seed_from_u64(seed);
    Array2::from_shape_fn((labels.len(), m), |(k, p)| {
        let n: f64 = StandardNormal.sample(&mut rng);
        (f64::from(u8::from(labels[k] == p)) + sigma * n) / (sigma * sigma)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Among the rows that give a class a probability in a range, the share with this label is the mean probability.
    #[test]
    fn probabilities_are_calibrated() {
        let m = 3;
        let labels: Vec<usize> = (0..60_000).map(|k| k % m).collect();
        let scores = noisy_scores(&labels, m, 0.7, 4);
        // Number, right ones, sum of probabilities.
        let mut bins = [[0.0; 3]; 5];
        for (k, y) in scores.outer_iter().enumerate() {
            let largest = y.fold(f64::NEG_INFINITY, |a: f64, &x| a.max(x));
            let total: f64 = y.iter().map(|x| (x - largest).exp()).sum();
            for (p, x) in y.iter().enumerate() {
                let probability = (x - largest).exp() / total;
                let bin = &mut bins[((5.0 * probability) as usize).min(4)];
                bin[0] += 1.0;
                bin[1] += f64::from(u8::from(labels[k] == p));
                bin[2] += probability;
            }
        }
        for [count, right, sum] in bins {
            // Five standard errors of a share.
            let (share, mean) = (right / count, sum / count);
            assert!(count > 1000.0);
            assert!((share - mean).abs() < 5.0 * (0.25 / count).sqrt(), "{share} {mean}");
        }
    }
}
