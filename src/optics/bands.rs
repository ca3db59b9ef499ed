//! Scanlines of a picture in parallel. Each scanline is computed independently, so that the result does not depend
//! on the number of threads.

use crate::sweep;

/// Smaller bands are not worth a thread of their own.
const MIN_PIXELS_PER_THREAD: usize = 1 << 16;

/// Calls `fill(y, pixels)` for every scanline of `width` entries.
pub fn for_each_scanline<T: Send>(
    pixels: &mut [T],
    width: usize,
    fill: impl Fn(usize, &mut [T]) + Sync,
) {
    for_each_band(pixels, width, |first, band| {
        for (i, scanline) in band.chunks_mut(width).enumerate() {
            fill(first + i, scanline);
        }
    });
}

/// Calls `fill(first scanline, pixels)` for bands of consecutive scanlines, one per thread.
pub fn for_each_band<T: Send>(
    pixels: &mut [T],
    width: usize,
    fill: impl Fn(usize, &mut [T]) + Sync,
) {
    let rows = (pixels.len() / width).div_ceil(sweep::threads());
    let rows = rows.max(MIN_PIXELS_PER_THREAD / width).max(1);
    let bands: Vec<_> = pixels.chunks_mut(rows * width).enumerate().collect();
    sweep::each(bands, &|(i, band)| fill(i * rows, band));
}
