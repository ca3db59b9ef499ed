//! Rows of a picture, and candidate views, in parallel. Each is computed alone, so that the number of threads
//! changes no bit.

use crate::sweep;

/// Fewer pixels than this are not worth a thread.
const PIXELS_A_THREAD: usize = 1 << 16;

/// Calls `row(y, pixels)` for every row of `width` entries.
pub fn for_each_row<T: Send>(pixels: &mut [T], width: usize, row: impl Fn(usize, &mut [T]) + Sync) {
    for_each_band(pixels, width, |first, band| {
        for (i, line) in band.chunks_mut(width).enumerate() {
            row(first + i, line);
        }
    });
}

/// Calls `fill(first row, pixels)` for bands of consecutive rows, one a thread.
pub fn for_each_band<T: Send>(
    pixels: &mut [T],
    width: usize,
    fill: impl Fn(usize, &mut [T]) + Sync,
) {
    let rows = (pixels.len() / width).div_ceil(sweep::threads());
    let rows = rows.max(PIXELS_A_THREAD / width).max(1);
    let bands: Vec<_> = pixels.chunks_mut(rows * width).enumerate().collect();
    sweep::each(bands, &|(i, band)| fill(i * rows, band));
}
