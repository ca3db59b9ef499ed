//! Colors of data with any number of columns: a color per vertex, and a caption that explains it.
//!
//! Three columns within [0, 1] are colors. Any other three columns are shown as red, green and blue over a common
//! range, one column from dark to bright. Two columns, or more than three, are shown by their first principal
//! components, all on the scale of the first one, so that components that vary little look uniform. Ranges exclude the
//! extreme 2 % at each end.

use nalgebra::{DMatrix, DVector};

use super::Data;
use super::range::robust_unit_range;
use crate::colormap::sequential;
use crate::sweep;

/// Principal components are estimated from at most this many vertices.
const MAX_SAMPLED_VERTICES: usize = 20_000;

/// A color per vertex, RGB in [0, 1], NaN where the data are unknown. `area` has the V areas of the vertices.
pub fn colors(data: &Data, area: &[f64]) -> Vec<[f64; 3]> {
    match data.dimension {
        1 => scaled(data.values.clone(), area).0.into_iter().map(one).collect(),
        3 if are_colors(data) => {
            (0..data.len()).map(|k| [0, 1, 2].map(|i| data.at(k)[i])).collect()
        }
        3 => {
            let [low, high] = common_range(data, area);
            // The middle of the range in two unused channels; NaN stays.
            let unit = |x: f64| {
                if high > low || x.is_nan() { (x - low) / (high - low) } else { 0.5 }
            };
            (0..data.len()).map(|k| [0, 1, 2].map(|i| clamped(unit(data.at(k)[i])))).collect()
        }
        _ => principal(data, area),
    }
}

/// The caption of [`colors`] for data with the given name; `range` has the values that were mapped to 0 and 1, and are
/// drawn dark and bright, if any were, and `unit` is their unit, if they have one.
pub fn words(
    data: &Data,
    name: &str,
    range: Option<[f64; 2]>,
    unit: Option<&str>,
    area: &[f64],
) -> String {
    let from_to = |[low, high]: [f64; 2], dark: &str, bright: &str| {
        format!("{name}, from {} ({dark}) to {} ({bright})", short(low), short(high))
    };
    match data.dimension {
        1 => {
            let shown = range.unwrap_or_else(|| scaled(data.values.clone(), area).1);
            match (unit, shown.map(short)) {
                // Short enough for the width of a picture.
                (Some(unit), [low, high]) => format!("{name}: {low} to {high} in {unit}"),
                (None, _) => from_to(shown, "dark", "bright"),
            }
        }
        3 if are_colors(data) => name.to_owned(),
        3 => from_to(common_range(data, area), "black", "white") + ", as red, green, blue",
        2 => format!("{name}: 2 principal components as red and blue"),
        d => format!("{name}: 3 principal components of {d} as red, green, blue"),
    }
}

fn are_colors(data: &Data) -> bool {
    data.values.iter().all(|x| x.is_nan() || (0.0..=1.0).contains(x))
}

fn one(t: f64) -> [f64; 3] {
    if t.is_nan() { [f64::NAN; 3] } else { sequential(t) }
}

/// Clamps to [0, 1]; NaN stays.
fn clamped(t: f64) -> f64 {
    t.clamp(0.0, 1.0)
}

fn short(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let digits = (2 - x.abs().max(1e-3).log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{x:.digits$}");
        let short =
            if digits > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        short.to_owned()
    } else {
        format!("{x:.2e}")
    }
}

/// [`robust_unit_range`] of the known values.
fn scaled(values: Vec<f64>, area: &[f64]) -> (Vec<f64>, [f64; 2]) {
    let known: Vec<usize> = (0..values.len()).filter(|&k| !values[k].is_nan()).collect();
    let pick = |from: &[f64]| -> Vec<f64> { known.iter().map(|&k| from[k]).collect() };
    let (unit, range) = robust_unit_range(&pick(&values), &pick(area));
    let mut all = vec![f64::NAN; values.len()];
    for (&k, unit) in known.iter().zip(unit) {
        all[k] = unit;
    }
    (all, range)
}

/// The widest of the ranges of three columns.
fn common_range(data: &Data, area: &[f64]) -> [f64; 2] {
    let range = |i: usize| {
        let column = data.values.iter().skip(i).step_by(data.dimension).copied().collect();
        scaled(column, area).1
    };
    let ranges = sweep::results(vec![0, 1, 2], range);
    [
        ranges.iter().fold(f64::INFINITY, |a, range| a.min(range[0])),
        ranges.iter().fold(f64::NEG_INFINITY, |a, range| a.max(range[1])),
    ]
}

/// The first principal components, centered and on the scale of the first one.
fn principal(data: &Data, area: &[f64]) -> Vec<[f64; 3]> {
    let d = data.dimension;
    let known = |k: usize| data.at(k).iter().all(|x| !x.is_nan());
    let step = data.len().div_ceil(MAX_SAMPLED_VERTICES).max(1);
    let sample: Vec<usize> =
        (0..data.len()).step_by(step).filter(|&k| known(k) && area[k] > 0.0).collect();
    let total: f64 = sample.iter().map(|&k| area[k]).sum();
    // Scaled, so that products of columns do not overflow.
    let largest = sample.iter().flat_map(|&k| data.at(k)).fold(0.0_f64, |a, x| a.max(x.abs()));
    let unit = if largest > 0.0 { 1.0 / largest } else { 1.0 };
    let row = |k: usize| DVector::from_iterator(d, data.at(k).iter().map(|x| x * unit));
    let mut mean = DVector::zeros(d);
    for &k in &sample {
        mean += row(k) * (area[k] / total);
    }
    let mut covariance = DMatrix::zeros(d, d);
    for &k in &sample {
        let offset = row(k) - &mean;
        covariance.ger(area[k] / total, &offset, &offset, 1.0);
    }
    let eigen = covariance.symmetric_eigen();
    let mut order: Vec<usize> = (0..d).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let shown = d.min(3);
    let components: Vec<Vec<f64>> = order[..shown]
        .iter()
        .map(|&i| {
            let direction = eigen.eigenvectors.column(i);
            // A fixed choice of the sign, so that the same data always look the same.
            let sign = direction.iter().find(|x| x.abs() > 1e-6).map_or(1.0, |x| x.signum());
            let at = |k: usize| sign * (row(k) - &mean).dot(&direction);
            (0..data.len()).map(|k| if known(k) { at(k) } else { f64::NAN }).collect()
        })
        .collect();
    let ranges: Vec<[f64; 2]> =
        sweep::results(components.iter().collect(), |component| scaled(component.clone(), area).1);
    let width = ranges[0][1] - ranges[0][0];
    let value = |i: usize, k: usize| {
        let [low, high] = ranges[i];
        let offset = components[i][k] - (low + high) / 2.0;
        clamped(if width > 0.0 { 0.5 + offset / width } else { 0.5 + 0.0 * offset })
    };
    let color = |k: usize| match shown {
        2 => {
            let (red, blue) = (value(0, k), value(1, k));
            [red, (red + blue) / 2.0, blue]
        }
        _ => [value(0, k), value(1, k), value(2, k)],
    };
    (0..data.len()).map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(dimension: usize, values: &[f64]) -> Data {
        Data { dimension, values: values.to_vec() }
    }

    #[test]
    fn three_columns_within_the_unit_range_are_colors() {
        let colored = data(3, &[0.1, 0.2, 0.3, 1.0, 0.0, 0.5]);
        assert_eq!(colors(&colored, &[1.0; 2]), [[0.1, 0.2, 0.3], [1.0, 0.0, 0.5]]);
        assert_eq!(words(&colored, "colors", None, None, &[1.0; 2]), "colors");
    }

    /// Data that differ only in the second or third column look different.
    #[test]
    fn every_column_counts() {
        for dimension in [2, 3, 4, 7] {
            for column in 0..dimension {
                let mut values = vec![5.0; 10 * dimension];
                for k in 5..10 {
                    values[k * dimension + column] = -20.0;
                }
                let colors = colors(&data(dimension, &values), &[1.0; 10]);
                let distance: f64 =
                    colors[0].iter().zip(&colors[9]).map(|(a, b)| (a - b).abs()).sum();
                assert!(distance > 0.5, "{dimension} {column} {colors:?}");
                assert_eq!(colors[0], colors[4]);
            }
        }
    }

    #[test]
    fn columns_out_of_range_share_one_range() {
        let normals = data(3, &[-1.0, 0.0, 1.0, 1.0, -1.0, 0.0]);
        assert_eq!(colors(&normals, &[1.0; 2]), [[0.0, 0.5, 1.0], [1.0, 0.0, 0.5]]);
        let text = words(&normals, "N.npy", None, None, &[1.0; 2]);
        assert_eq!(text, "N.npy, from -1 (black) to 1 (white), as red, green, blue");
    }

    #[test]
    fn one_column_names_its_ends_in_the_units_before_any_map() {
        let ramp = data(1, &[0.0, 0.5, 1.0]);
        let text = |unit| words(&ramp, "mean curvature", Some([-30.0, 50.0]), unit, &[1.0; 3]);
        assert_eq!(text(None), "mean curvature, from -30 (dark) to 50 (bright)");
        assert_eq!(text(Some("1/length")), "mean curvature: -30 to 50 in 1/length");
    }

    #[test]
    fn unknown_rows_have_no_color_and_no_influence() {
        for dimension in [1, 2, 3, 5] {
            let mut values = vec![f64::NAN; 3 * dimension];
            values[..2 * dimension].iter_mut().enumerate().for_each(|(i, x)| *x = i as f64);
            let colors = colors(&data(dimension, &values), &[1.0, 1.0, 1e9]);
            assert!(colors[2].iter().all(|c| c.is_nan()));
            assert!(colors[..2].iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{colors:?}");
            assert_ne!(colors[0], colors[1]);
        }
    }

    #[test]
    fn constant_data_of_any_size_look_even() {
        for dimension in [1, 2, 3, 5] {
            for size in [0.0, 7.0, 1e300] {
                let colors = colors(&data(dimension, &vec![size; 4 * dimension]), &[1.0; 4]);
                assert!(colors.iter().all(|color| *color == colors[0]), "{dimension} {size}");
                assert!(colors[0].iter().all(|c| (0.0..=1.0).contains(c)), "{dimension} {size}");
            }
        }
    }
}
