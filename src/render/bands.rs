//! Rows of a picture, and candidate views, in parallel. Each is computed alone, so that the number of threads
//! changes no bit.

use std::thread;

/// Fewer pixels than this are not worth a thread.
const PIXELS_A_THREAD: usize = 1 << 16;

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
    let rows = (pixels.len() / width).div_ceil(threads());
    let rows = rows.max(PIXELS_A_THREAD / width);
    if rows * width >= pixels.len() {
        return fill(0, pixels);
    }
    thread::scope(|scope| {
        for (i, band) in pixels.chunks_mut(rows * width).enumerate() {
            let fill = &fill;
            scope.spawn(move || fill(i * rows, band));
        }
    });
}

/// The values of a costly function, in order.
pub(super) fn map<S: Sync, T: Send>(items: &[S], value: impl Fn(&S) -> T + Sync) -> Vec<T> {
    let share = items.len().div_ceil(threads()).max(1);
    thread::scope(|scope| {
        let value = &value;
        let running: Vec<_> = items
            .chunks(share)
            .map(|chunk| scope.spawn(move || chunk.iter().map(value).collect::<Vec<T>>()))
            .collect();
        let joined = running.into_iter().map(|thread| thread.join());
        joined.flat_map(|values| values.expect("the function does not panic")).collect()
    })
}

fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
