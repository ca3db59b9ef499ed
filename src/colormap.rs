//! Colors for scalars and for region indices, as sRGB values in [0, 1].

/// Matplotlib's viridis (N. Smith, S. van der Walt, E. Firing, 2015; CC0) at 18 equidistant points, accurate
/// to 0.02 under linear interpolation.
const VIRIDIS: [[f64; 3]; 18] = [
    [0.267, 0.005, 0.329],
    [0.282, 0.090, 0.412],
    [0.280, 0.166, 0.476],
    [0.264, 0.238, 0.519],
    [0.237, 0.305, 0.542],
    [0.209, 0.368, 0.553],
    [0.182, 0.426, 0.557],
    [0.159, 0.482, 0.558],
    [0.138, 0.537, 0.555],
    [0.121, 0.593, 0.545],
    [0.128, 0.648, 0.523],
    [0.181, 0.701, 0.488],
    [0.274, 0.752, 0.437],
    [0.395, 0.797, 0.368],
    [0.536, 0.836, 0.282],
    [0.689, 0.865, 0.183],
    [0.846, 0.887, 0.100],
    [0.993, 0.906, 0.144],
];

/// The qualitative palette of M. Okabe, K. Ito, *Color Universal Design*, 2008, without black and with the
/// colors ordered by contrast between neighbors.
const OKABE_ITO: [[u8; 3]; 7] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
];

/// The perceptually uniform color of t, clamped to [0, 1]; medium gray for NaN.
pub fn sequential(t: f64) -> [f64; 3] {
    if t.is_nan() {
        return [0.5; 3];
    }
    let position = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let before = (position as usize).min(VIRIDIS.len() - 2);
    let s = position - before as f64;
    let (a, b) = (VIRIDIS[before], VIRIDIS[before + 1]);
    [0, 1, 2].map(|c| a[c] + s * (b[c] - a[c]))
}

/// The color of region p: first those of Okabe and Ito, then hues spaced by the golden ratio at four pairs of
/// saturation and value, so that the colors of up to 64 regions differ.
pub fn categorical(p: usize) -> [f64; 3] {
    if let Some(color) = OKABE_ITO.get(p) {
        return color.map(|value| f64::from(value) / 255.0);
    }
    let i = p - OKABE_ITO.len();
    let hue = (i as f64 * 0.618_033_988_749_895).fract();
    let [saturation, value] = [[0.55, 0.95], [0.85, 0.70], [0.40, 0.75], [0.75, 0.45]][i % 4];
    hsv(hue, saturation, value)
}

/// sRGB from HSV, all in [0, 1]. A. R. Smith, *Color gamut transform pairs*, SIGGRAPH 1978.
fn hsv(hue: f64, saturation: f64, value: f64) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|n| {
        let k = (n + 6.0 * hue) % 6.0;
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequential_map_interpolates_its_table_and_brightens_monotonically() {
        assert_eq!(sequential(0.0), VIRIDIS[0]);
        assert_eq!(sequential(1.0), VIRIDIS[17]);
        assert_eq!(sequential(-3.0), VIRIDIS[0]);
        assert_eq!(sequential(f64::INFINITY), VIRIDIS[17]);
        let luma = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        for i in 0..100 {
            let t = f64::from(i) / 100.0;
            assert!(luma(sequential(t + 0.01)) > luma(sequential(t)));
        }
    }

    #[test]
    fn sixty_four_regions_have_distinct_colors() {
        let colors: Vec<_> = (0..64).map(categorical).collect();
        for (p, a) in colors.iter().enumerate() {
            assert!(a.iter().all(|c| (0.0..=1.0).contains(c)));
            for b in &colors[..p] {
                let distance: f64 = a.iter().zip(b).map(|(s, t)| (s - t).abs()).sum();
                assert!(distance > 0.04, "{a:?} {b:?}");
            }
        }
    }
}
