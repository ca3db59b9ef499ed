//! The distance to the contour of a silhouette in its image.
//!
//! ```text
//! d(w) = min over the pixels v on the other side of |w - v|, minus 1/2        positive inside, negative outside
//! ```
//!
//! Computed for all pixels in linear time, along columns first and then along rows. Reference: P. F. Felzenszwalb,
//! D. P. Huttenlocher, *Distance transforms of sampled functions*, Theory of Computing 8, 2012.

use crate::evolve::silhouette::Silhouette;

/// d at the pixels of an image.
pub struct SignedDistance {
    width: usize,
    height: usize,
    /// Row by row.
    values: Vec<f64>,
}

impl SignedDistance {
    pub fn of(silhouette: &Silhouette) -> Self {
        let [width, height] = silhouette.size;
        let to =
            |side: bool| squared_distances(width, height, |pixel| silhouette.inside[pixel] == side);
        let (inside, outside) = (to(true), to(false));
        let signed = |(&inside, &outside): (&f64, &f64)| {
            if inside == 0.0 { outside.sqrt() - 0.5 } else { 0.5 - inside.sqrt() }
        };
        SignedDistance { width, height, values: inside.iter().zip(&outside).map(signed).collect() }
    }

    /// d at a point of the image, interpolated between pixels. Beyond the image the silhouette continues as at its
    /// border: one that is cut off there has no contour at that place.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (inner_x, left, right) = between(x, self.width);
        let (inner_y, top, bottom) = between(y, self.height);
        let value = |column: usize, row: usize| self.values[row * self.width + column];
        let on_row = |row: usize| {
            (1.0 - inner_x.fract()) * value(left, row) + inner_x.fract() * value(right, row)
        };
        let d = (1.0 - inner_y.fract()) * on_row(top) + inner_y.fract() * on_row(bottom);
        if d > 0.0 { d } else { d - (x - inner_x).hypot(y - inner_y) }
    }
}

/// A coordinate within the pixel centers, and the pixels on both sides of it.
fn between(x: f64, n: usize) -> (f64, usize, usize) {
    let inner = x.clamp(0.0, (n - 1) as f64);
    let left = inner as usize;
    (inner, left, (left + 1).min(n - 1))
}

/// The squared distance of each pixel to the nearest pixel of a set; that of the size of the image if the set is empty.
fn squared_distances(width: usize, height: usize, is_in: impl Fn(usize) -> bool) -> Vec<f64> {
    let farthest = (width + height) as f64;
    let mut values = vec![0.0; width * height];
    for column in 0..width {
        // The distance to the last pixel of the set, from above and from below.
        let mut distance = farthest;
        for row in 0..height {
            let pixel = row * width + column;
            distance = if is_in(pixel) { 0.0 } else { (distance + 1.0).min(farthest) };
            values[pixel] = distance;
        }
        distance = farthest;
        for row in (0..height).rev() {
            let pixel = row * width + column;
            distance = if is_in(pixel) { 0.0 } else { (distance + 1.0).min(farthest) };
            values[pixel] = distance.min(values[pixel]).powi(2);
        }
    }
    let mut result = vec![0.0; width];
    for row in values.chunks_mut(width) {
        lower_envelope(row, &mut result);
        row.copy_from_slice(&result);
    }
    values
}

/// result(x) = min_y heights(y) + (x - y)^2: the lower envelope of parabolas.
fn lower_envelope(heights: &[f64], result: &mut [f64]) {
    // The vertices of the parabolas of the envelope, and where each begins.
    let mut parabolas: Vec<(usize, f64)> = Vec::with_capacity(heights.len());
    let crossing = |a: usize, b: usize| {
        let value = |x: usize| heights[x] + (x * x) as f64;
        (value(b) - value(a)) / (2 * (b - a)) as f64
    };
    for b in 0..heights.len() {
        let begins = loop {
            let Some(&(a, start)) = parabolas.last() else { break f64::NEG_INFINITY };
            let at = crossing(a, b);
            if at > start {
                break at;
            }
            parabolas.pop();
        };
        parabolas.push((b, begins));
    }
    let mut i = 0;
    for (x, result) in result.iter_mut().enumerate() {
        while parabolas.get(i + 1).is_some_and(|&(_, start)| start <= x as f64) {
            i += 1;
        }
        let at = parabolas[i].0;
        *result = heights[at] + x.abs_diff(at).pow(2) as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::rng;
    use rand::RngExt;

    #[test]
    fn squared_distances_are_those_of_all_pairs() {
        let mut rng = rng(12);
        for (width, height, share) in [(17, 11, 0.05), (1, 9, 0.3), (20, 1, 0.2), (13, 13, 0.7)] {
            let set: Vec<bool> = (0..width * height).map(|_| rng.random_bool(share)).collect();
            let found = squared_distances(width, height, |pixel| set[pixel]);
            for (pixel, found) in found.into_iter().enumerate() {
                let squared = |other: usize| {
                    (pixel % width).abs_diff(other % width).pow(2)
                        + (pixel / width).abs_diff(other / width).pow(2)
                };
                let exact = (0..set.len()).filter(|&i| set[i]).map(squared).min();
                if let Some(exact) = exact {
                    assert_eq!(found, exact as f64);
                }
            }
        }
    }
}
