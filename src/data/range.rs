//! Scalar measurements as data in [0, 1], robust against a few extreme values due to noise and bad triangles, as in
//! curvature.

/// The fraction of the area that is clipped at each end.
const CLIPPED_SHARE: f64 = 0.02;

/// Values clipped at their area-weighted 2 % and 98 % quantiles, then mapped affinely to [0, 1]; and the two quantiles,
/// so that the map can be inverted. Values that are constant after clipping become 0.5; NaN (unknown) stays NaN. Both
/// slices have V entries.
pub fn robust_unit_range(values: &[f64], area: &[f64]) -> (Vec<f64>, [f64; 2]) {
    let range = robust_range(values, area);
    (unit(values, range), range)
}

/// The area-weighted 2 % and 98 % quantiles of the values that are not NaN; zeros if there are none.
pub fn robust_range(values: &[f64], area: &[f64]) -> [f64; 2] {
    let order = ordered(values, area);
    if order.is_empty() {
        return [0.0; 2];
    }
    let low = quantile(area, order.iter(), CLIPPED_SHARE);
    [low, quantile(area, order.iter().rev(), CLIPPED_SHARE)]
}

/// The area-weighted median of the values that are not NaN; 0 if there are none.
pub fn median(values: &[f64], area: &[f64]) -> f64 {
    let order = ordered(values, area);
    if order.is_empty() { 0.0 } else { quantile(area, order.iter(), 0.5) }
}

/// Clips values to a range and maps it to [0, 1]; 0.5 if its width is zero. NaN stays.
pub fn unit(values: &[f64], [low, high]: [f64; 2]) -> Vec<f64> {
    let mapped = |value: &f64| match low < high {
        _ if value.is_nan() => f64::NAN,
        true => (value.clamp(low, high) - low) / (high - low),
        false => 0.5,
    };
    values.iter().map(mapped).collect()
}

/// The values at vertices with an area, in increasing order, each with its vertex.
fn ordered(values: &[f64], area: &[f64]) -> Vec<(f64, usize)> {
    assert_eq!(values.len(), area.len());
    let vertices = values.iter().copied().zip(0..);
    let mut order: Vec<_> = vertices.filter(|&(x, v)| area[v] > 0.0 && !x.is_nan()).collect();
    order.sort_unstable_by(|(x, v), (y, w)| x.total_cmp(y).then(v.cmp(w)));
    order
}

/// The first of the ordered values up to which the area exceeds a fraction of the total.
fn quantile<'a>(
    area: &[f64],
    order: impl Iterator<Item = &'a (f64, usize)> + Clone,
    share: f64,
) -> f64 {
    let total: f64 = order.clone().map(|&(_, v)| area[v]).sum();
    let mut passed = 0.0;
    let mut last = f64::NAN;
    for &(value, v) in order {
        passed += area[v];
        last = value;
        if passed > share * total {
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
    fn unknown_values_stay_unknown_and_change_nothing() {
        let (unit, range) = robust_unit_range(&[1.0, f64::NAN, 3.0, 2.0], &[1.0; 4]);
        assert_eq!((unit[0], unit[2], unit[3], range), (0.0, 1.0, 0.5, [1.0, 3.0]));
        assert!(unit[1].is_nan());
        assert_eq!(robust_unit_range(&[f64::NAN; 2], &[1.0; 2]).1, [0.0; 2]);
        assert_eq!(median(&[5.0, f64::NAN, 1.0, 2.0], &[1.0, 9.0, 1.0, 1.0]), 2.0);
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
