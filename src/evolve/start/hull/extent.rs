//! A box around the visual hull.
//!
//! A box of the scene whose image, enlarged to a rectangle of pixels, has none of the silhouette in some view contains no
//! point of the hull. The first box reaches from the point at which the cameras look to the nearest camera; then the box
//! around the cells of a grid that may contain a point of the hull is divided again, until it hardly shrinks.

use nalgebra::{Point3, Vector3};

use crate::error::{Error, Result};
use crate::evolve::silhouette::Silhouette;
use crate::evolve::start::gaze::convergence;
use crate::mesh::tree::Bounds;
use crate::sweep;

/// Cells along each side.
const CELLS: usize = 20;

/// The box is divided again if its longest side became shorter than this share.
const SHRINKS: f64 = 0.95;

/// The smallest box that was found.
///
/// # Errors
/// There are no silhouettes or one of them is empty, the cameras look in the same direction, or no point is inside all
/// silhouettes.
pub fn extent(silhouettes: &[Silhouette]) -> Result<Bounds> {
    if let Some(i) = silhouettes.iter().position(|one| !one.inside.contains(&true)) {
        return Err(Error::unsuitable(format!(
            "the silhouette of view {} is empty; leave the view out, or check its mask",
            i + 1
        )));
    }
    let cameras: Vec<_> = silhouettes.iter().map(|one| (one.camera, one.size)).collect();
    let center = convergence(&cameras)?;
    let nearest = cameras.iter().map(|(camera, _)| (camera.center() - center).norm());
    let half = Vector3::repeat(nearest.fold(f64::INFINITY, f64::min));
    let mut bounds = Bounds { low: center - half, high: center + half };
    let counts: Vec<Counts> = silhouettes.iter().map(Counts::of).collect();
    loop {
        let Some(smaller) = occupied(&bounds, silhouettes, &counts) else {
            return Err(Error::unsuitable(
                "no point lies inside the silhouettes of all views; check the masks and the cameras",
            ));
        };
        let [before, after] = [bounds, smaller].map(|Bounds { low, high }| (high - low).max());
        bounds = smaller;
        if after > SHRINKS * before {
            return Ok(bounds);
        }
    }
}

/// The box around the cells that may contain a point of the hull.
fn occupied(bounds: &Bounds, silhouettes: &[Silhouette], counts: &[Counts]) -> Option<Bounds> {
    let side = (bounds.high - bounds.low) / CELLS as f64;
    let cell = |i: usize| {
        let at = [i % CELLS, i / CELLS % CELLS, i / (CELLS * CELLS)].map(|c| c as f64);
        let low = bounds.low + side.component_mul(&Vector3::from(at));
        Bounds { low, high: low + side }
    };
    let may_contain = sweep::collect(CELLS * CELLS * CELLS, |i| {
        let cell = cell(i);
        silhouettes.iter().zip(counts).all(|(one, counts)| counts.may_contain(one, &cell))
    });
    let cells = (0..may_contain.len()).filter(|&i| may_contain[i]).map(cell);
    cells.reduce(|a, b| Bounds { low: a.low.inf(&b.low), high: a.high.sup(&b.high) })
}

/// Numbers of pixels of a silhouette in the rectangles from the first pixel: (width + 1) x (height + 1).
struct Counts(Vec<u32>);

impl Counts {
    fn of(silhouette: &Silhouette) -> Self {
        let [width, height] = silhouette.size;
        let mut sums = vec![0; (width + 1) * (height + 1)];
        for row in 0..height {
            let mut on_row = 0;
            for column in 0..width {
                on_row += u32::from(silhouette.inside[row * width + column]);
                let at = (row + 1) * (width + 1) + column + 1;
                sums[at] = sums[at - width - 1] + on_row;
            }
        }
        Counts(sums)
    }

    /// Whether the rectangle of pixels around the image of a box has a pixel of the silhouette, or a corner of the box is
    /// behind the camera. Beyond the image count the pixels at its border.
    fn may_contain(&self, silhouette: &Silhouette, cell: &Bounds) -> bool {
        let [width, height] = silhouette.size;
        let ends = [cell.low, cell.high];
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        let mut in_front = 0;
        for corner in 0..8 {
            let x = Point3::new(ends[corner & 1].x, ends[corner >> 1 & 1].y, ends[corner >> 2].z);
            let at = silhouette.camera.project(x);
            in_front += u32::from(at.w > 0.0);
            for (i, c) in [at.x, at.y].into_iter().enumerate() {
                low[i] = low[i].min(c);
                high[i] = high[i].max(c);
            }
        }
        if in_front < 8 {
            return in_front > 0;
        }
        // Up to the next pixel centers, as values between these are interpolated.
        let pixels = |i: usize, n: usize| {
            let last = (n - 1) as f64;
            let [first, last] =
                [low[i].floor(), high[i].ceil()].map(|c| c.clamp(0.0, last) as usize);
            (first, last + 1)
        };
        let ((left, right), (top, bottom)) = (pixels(0, width), pixels(1, height));
        let sum = |column: usize, row: usize| self.0[row * (width + 1) + column];
        // In this order no difference is negative.
        sum(right, bottom) + sum(left, top) > sum(left, bottom) + sum(right, top)
    }
}
