//! Scalar measurements as data in [0, 1], robust against the few extreme values that noise and bad
//! triangles leave, in curvature above all.

/// The share of the area clipped at each end.
const CLIPPED: f64 = 0.02;

/// Values clipped at their area-weighted 2 % and 98 % quantiles, then mapped affinely to [0, 1]; and the
/// two quantiles, so that the map can be undone. Values that are constant after clipping become 0.5.
/// Both slices have V entries; values must not be NaN.
pub fn robust_unit_range(values: &[f64], area: &[f64]) -> (Vec<f64>, [f64; 2]) {
    assert_eq!(values.len(), area.len());
    assert!(values.iter().all(|value| !value.is_nan()));
    let mut order: Vec<usize> = (0..values.len()).filter(|&v| area[v] > 0.0).collect();
    if order.is_empty() {
        return (vec![0.5; values.len()], [0.0; 2]);
    }
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let low = quantile(values, area, order.iter());
    let high = quantile(values, area, order.iter().rev());
    let unit = values
        .iter()
        .map(|value| if low < high { (value.clamp(low, high) - low) / (high - low) } else { 0.5 })
        .collect();
    (unit, [low, high])
}

/// The first value of the ordered vertices by which more than the clipped share of the area has passed.
fn quantile<'a>(
    values: &[f64],
    area: &[f64],
    order: impl Iterator<Item = &'a usize> + Clone,
) -> f64 {
    let total: f64 = order.clone().map(|&v| area[v]).sum();
    let mut passed = 0.0;
    let mut last = f64::NAN;
    for &v in order {
        passed += area[v];
        last = values[v];
        if passed > CLIPPED * total {
            break;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_of_small_area_do_not_set_the_range() {
        let mut values: Vec<f64> = (0..=100).map(f64::from).collect();
        let mut area = vec![1.0; 101];
        values.extend([1e30, -1e30]);
        area.extend([0.5, 0.5]);
        let (unit, [low, high]) = robust_unit_range(&values, &area);
        assert_eq!([low, high], [1.0, 99.0]);
        assert_eq!(unit[50], 0.5);
        assert_eq!(&unit[101..], [1.0, 0.0]);
        assert!(unit.iter().all(|t| (0.0..=1.0).contains(t)));
    }

    #[test]
    fn the_quantiles_are_weighted_by_area() {
        let values = [0.0, 1.0, 2.0];
        assert_eq!(robust_unit_range(&values, &[0.01, 1.0, 1.0]).1, [1.0, 2.0]);
        assert_eq!(robust_unit_range(&values, &[0.1, 1.0, 0.0]).1, [0.0, 1.0]);
    }

    #[test]
    fn a_constant_is_one_half_and_so_is_a_surface_without_area() {
        assert_eq!(robust_unit_range(&[3.0; 4], &[1.0; 4]).0, vec![0.5; 4]);
        assert_eq!(robust_unit_range(&[3.0, 4.0], &[0.0; 2]).0, vec![0.5; 2]);
        assert!(robust_unit_range(&[], &[]).0.is_empty());
    }

    #[test]
    fn the_range_scales_with_the_values() {
        let values = [0.1, 0.7, -0.4, 0.2];
        let scaled = values.map(|value| value * 1e-9);
        let (a, b) =
            (robust_unit_range(&values, &[1.0; 4]).0, robust_unit_range(&scaled, &[1e8; 4]).0);
        for (s, t) in a.iter().zip(b) {
            assert!((s - t).abs() < 1e-12);
        }
    }
}
