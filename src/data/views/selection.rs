//! Which pixels of an image count: those that show one smooth piece of the surface, away from the border.

use super::options::ViewOptions;
use super::picture::Picture;
use crate::optics::zbuffer::ZBuffer;

/// 1/z varies by less than this fraction of its maximum where the depth does not jump.
const NO_JUMP: f64 = 0.05;

/// Why a pixel that shows the surface does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOut {
    Border,
    Masked,
    Mixed,
}

/// The tests that need a pixel alone, not its faces.
pub struct Selection<'a> {
    picture: &'a Picture,
    border: usize,
    /// Whether each pixel is pure; `None` if all count.
    pure: Option<Vec<bool>>,
}

impl<'a> Selection<'a> {
    pub fn new(picture: &'a Picture, zbuffer: &ZBuffer, options: &ViewOptions) -> Self {
        let rings = options.pure - 1;
        let pure = (rings > 0).then(|| pure(picture, zbuffer, options.samples, rings));
        Selection { picture, border: options.border, pure }
    }

    pub fn left_out(&self, column: usize, row: usize) -> Option<LeftOut> {
        let Picture { width, height, .. } = *self.picture;
        let from_border = column.min(row).min(width - 1 - column).min(height - 1 - row);
        let pixel = row * width + column;
        if from_border < self.border {
            Some(LeftOut::Border)
        } else if self.picture.is_masked(pixel) {
            Some(LeftOut::Masked)
        } else if self.pure.as_ref().is_some_and(|pure| !pure[pixel]) {
            Some(LeftOut::Mixed)
        } else {
            None
        }
    }
}

/// Whether all samples of the square of `rings` rings around each pixel hit the surface, and 1/z varies little there.
fn pure(picture: &Picture, zbuffer: &ZBuffer, s: usize, rings: usize) -> Vec<bool> {
    let Picture { width, height, .. } = *picture;
    let mut farthest = vec![f64::INFINITY; width * height];
    let mut nearest = vec![0.0_f64; width * height];
    for (row, samples) in zbuffer.nearness.chunks(zbuffer.width).enumerate() {
        for (column, &w) in samples.iter().enumerate() {
            let pixel = row / s * width + column / s;
            farthest[pixel] = farthest[pixel].min(w);
            nearest[pixel] = nearest[pixel].max(w);
        }
    }
    let farthest = over_squares(&farthest, width, rings, f64::min);
    let nearest = over_squares(&nearest, width, rings, f64::max);
    // 1/z is 0 where there is no surface.
    let pair = farthest.into_iter().zip(nearest);
    pair.map(|(low, high)| low > 0.0 && high - low < NO_JUMP * high).collect()
}

/// The least or greatest value in the square of `rings` rings around each pixel, as far as it is in the image: along the
/// rows, then along the columns.
fn over_squares(
    values: &[f64],
    width: usize,
    rings: usize,
    combine: fn(f64, f64) -> f64,
) -> Vec<f64> {
    let height = values.len() / width;
    let along = |values: &[f64], step: usize, length: usize, at: fn(usize, usize) -> usize| {
        let value = |pixel: usize| {
            let i = at(pixel, width);
            let first = i - i.min(rings);
            let last = (i + rings).min(length - 1);
            let start = pixel - (i - first) * step;
            (1..=last - first).fold(values[start], |a, n| combine(a, values[start + n * step]))
        };
        (0..values.len()).map(value).collect::<Vec<f64>>()
    };
    let rows = along(values, 1, width, |pixel, width| pixel % width);
    along(&rows, width, height, |pixel, width| pixel / width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::rng;
    use rand::RngExt;

    #[test]
    fn squares_are_cut_off_at_the_border() {
        let mut rng = rng(5);
        let (width, height) = (7, 5);
        let values: Vec<f64> = (0..width * height).map(|_| rng.random()).collect();
        for rings in [1, 2, 9] {
            let found = over_squares(&values, width, rings, f64::min);
            for (pixel, &least) in found.iter().enumerate() {
                let near = |other: &usize| {
                    (other % width).abs_diff(pixel % width) <= rings
                        && (other / width).abs_diff(pixel / width) <= rings
                };
                let square = (0..width * height).filter(near);
                assert_eq!(least, square.map(|i| values[i]).fold(f64::INFINITY, f64::min));
            }
        }
    }
}
