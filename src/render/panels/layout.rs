//! The grid of panels: the number of columns, and the scale of each mesh.
//!
//! All views of a mesh are from one distance and have one scale: pixels per unit of length at its center. The views of a
//! panel lie side by side or below each other. Of all grids, that with the largest scale is taken; panels that its last
//! row lacks count against it, since they leave a gap.

use super::page::MILLIMETER;

/// The space between columns, between rows, and between the views of a panel.
pub(super) const GAP: f64 = 3.0 * MILLIMETER;
pub(super) const ROW_GAP: f64 = 4.0 * MILLIMETER;
pub(super) const VIEW_GAP: f64 = 2.0 * MILLIMETER;
/// Empty pixels around each view.
pub(super) const MARGIN: f64 = 2.0;
/// The largest height of all pictures together, as a share of the width of the page: if the number of columns is
/// free, and if it is given.
const MAX_HEIGHT: [f64; 2] = [0.6, 1.3];

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub columns: usize,
    /// Whether the views of a panel are below each other.
    pub stacked: bool,
    /// In pixels.
    pub column_width: f64,
    /// Pixels per unit of length for each surface.
    pub scales: Vec<f64>,
}

impl Layout {
    /// The best grid of `count` panels within a page of `width` pixels, of which headings take `heading`. `sizes` has
    /// the sizes of the views of each surface in units of length. Surfaces with equal sizes have equal scales.
    pub fn new(
        sizes: &[Vec<[f64; 2]>],
        count: usize,
        columns: Option<usize>,
        width: f64,
        heading: f64,
    ) -> Self {
        let candidates = match columns {
            Some(columns) => columns..=columns,
            None => 1..=count,
        };
        let max_height = width * MAX_HEIGHT[usize::from(columns.is_some())];
        let mut best: Option<(f64, Layout)> = None;
        for (columns, stacked) in candidates.rev().flat_map(|n| [(n, false), (n, true)]) {
            let rows = count.div_ceil(columns);
            let gaps = GAP * (columns - 1) as f64;
            let column_width = (width - heading - gaps) / columns as f64;
            let room = [column_width, max_height / rows as f64];
            let scales: Vec<f64> = sizes.iter().map(|views| scale(views, room, stacked)).collect();
            let full = count as f64 / (rows * columns) as f64;
            let score = scales.iter().copied().fold(f64::INFINITY, f64::min) * full * full;
            // Rounding must not decide between equals.
            if best.as_ref().is_none_or(|(other, _)| score > 1.000_001 * other) {
                best = Some((score, Layout { columns, stacked, column_width, scales }));
            }
        }
        best.expect("at least one column").1
    }
}

/// The largest scale with which the views fit into a panel.
fn scale(views: &[[f64; 2]], room: [f64; 2], stacked: bool) -> f64 {
    let along = usize::from(stacked);
    let count = views.len() as f64;
    let sum: f64 = views.iter().map(|size| size[along]).sum();
    let largest = views.iter().map(|size| size[1 - along]).fold(0.0, f64::max);
    // A size is rounded up to whole pixels.
    let border = 2.0 * MARGIN + 1.0;
    let fits = |room: f64, taken: f64, size: f64| (room - taken).max(1.0) / size.max(1e-9);
    let first = fits(room[along], count * border + (count - 1.0) * VIEW_GAP, sum);
    first.min(fits(room[1 - along], border, largest))
}
