//! The means of data over the regions, weighted by area.

/// The mean color of the vertices of each of m regions, if any color is known there. `colors` and `area` have V
/// entries, `labels` yields V labels below m.
pub fn mean_colors(
    colors: &[[f64; 3]],
    labels: impl Iterator<Item = usize>,
    area: &[f64],
    m: usize,
) -> Vec<Option<[f64; 3]>> {
    let means = means(labels, area, m, |k| colors[k]);
    means.into_iter().map(|mean| mean.map(|mean| mean.map(|c| c.clamp(0.0, 1.0)))).collect()
}

/// The mean of the numbers at the vertices of each region, if any is known there.
pub(super) fn mean_numbers(
    values: &[f64],
    labels: impl Iterator<Item = usize>,
    area: &[f64],
    m: usize,
) -> Vec<Option<f64>> {
    means(labels, area, m, |k| [values[k]])
        .into_iter()
        .map(|mean| mean.map(|[mean]| mean))
        .collect()
}

fn means<const D: usize>(
    labels: impl Iterator<Item = usize>,
    area: &[f64],
    m: usize,
    value: impl Fn(usize) -> [f64; D],
) -> Vec<Option<[f64; D]>> {
    let mut sums = vec![([0.0; D], 0.0); m];
    for (k, label) in labels.enumerate() {
        let value = value(k);
        if value.iter().all(|c| !c.is_nan()) && area[k] > 0.0 {
            let (sum, total) = &mut sums[label];
            *total += area[k];
            for (sum, c) in sum.iter_mut().zip(value) {
                *sum += area[k] * c;
            }
        }
    }
    let mean = |(sum, total): ([f64; D], f64)| (total > 0.0).then(|| sum.map(|sum| sum / total));
    sums.into_iter().map(mean).collect()
}
