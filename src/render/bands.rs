//! Rows of a picture in parallel. Every row is computed alone, so that the number of threads changes no bit.

use std::thread;

/// Calls `row(y, pixels)` for every row of `width` entries.
pub(super) fn for_each_row<T: Send>(
    pixels: &mut [T],
    width: usize,
    row: impl Fn(usize, &mut [T]) + Sync,
) {
    for_each_band(pixels, width, |first, band| {
        for (i, line) in band.chunks_mut(width).enumerate() {
            row(first + i, line);
        }
    });
}

/// Calls `fill(first row, pixels)` for bands of consecutive rows, one a thread.
pub(super) fn for_each_band<T: Send>(
    pixels: &mut [T],
    width: usize,
    fill: impl Fn(usize, &mut [T]) + Sync,
) {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let rows = (pixels.len() / width).div_ceil(threads).max(1);
    thread::scope(|scope| {
        for (i, band) in pixels.chunks_mut(rows * width).enumerate() {
            let fill = &fill;
            scope.spawn(move || fill(i * rows, band));
        }
    });
}
