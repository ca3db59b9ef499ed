//! The segmentation in the picture: the region at each pixel, and the cut between regions.
//!
//! Inside a face U is interpolated linearly and the region is its argmax, so that the cut is a smooth curve instead
//! of a chain of edges. The cut passes between two neighboring pixels iff they show the same sheet of the surface and
//! different regions.
//!
//! The line along the cut is thinner in narrow regions: it covers at most half of a region's breadth. The breadth of a
//! region at a pixel is its shortest run through that pixel in eight directions, or through a pixel two steps away.

use std::ops::Range;

use crate::mesh::Mesh;
use crate::optics::bands::{for_each_band, for_each_scanline};
use crate::optics::visibility::Visibility;
use crate::sweep;

/// The region of a pixel without surface.
pub(super) const NO_REGION: u32 = u32::MAX;
/// The full width of the line, in pixels.
pub(super) const LINE_WIDTH: f64 = 3.0;
/// Breadths are measured up to this many pixels; regions this wide do not thin the line.
const MAX_BREADTH: usize = 7;
/// Scanlines that a thread searches for the cut at a time.
const BAND_HEIGHT: usize = 128;

/// U, and the region at each vertex.
pub(super) struct LabelField<'a> {
    mesh: &'a Mesh,
    u: &'a [f64],
    m: usize,
    /// The argmax at each vertex.
    region: Vec<u32>,
}

/// The point where the cut crosses the step from pixel `from` to a neighbor.
pub(super) struct Crossing {
    from: usize,
    x: f64,
    y: f64,
    /// Half the width of the line there.
    radius: f64,
}

impl<'a> LabelField<'a> {
    pub fn new(mesh: &'a Mesh, u: &'a [f64], m: usize) -> Self {
        let region = u.chunks_exact(m).map(|row| argmax(row.iter().copied()));
        LabelField { mesh, u, m, region: region.collect() }
    }

    /// The region of vertex v.
    pub fn region(&self, v: usize) -> usize {
        self.region[v] as usize
    }

    /// The number of columns of U.
    pub fn region_count(&self) -> usize {
        self.m
    }

    /// U at vertex v.
    pub fn row(&self, v: usize) -> &[f64] {
        &self.u[v * self.m..(v + 1) * self.m]
    }

    /// The interpolated value of region p on face j.
    fn value(&self, j: usize, barycentric: &[f64; 3], p: usize) -> f64 {
        let corners = self.mesh.faces[j].iter().zip(barycentric);
        corners.map(|(&v, b)| b * self.u[v as usize * self.m + p]).sum()
    }

    /// The region of face j, if its corners agree.
    pub fn face_region(&self, j: usize) -> Option<u32> {
        let [a, b, c] = self.mesh.faces[j].map(|v| self.region[v as usize]);
        (a == b && b == c).then_some(a)
    }

    /// The region at a point of face j.
    pub fn region_at(&self, j: usize, barycentric: &[f64; 3]) -> u32 {
        argmax((0..self.m).map(|p| self.value(j, barycentric, p)))
    }

    /// The region of every pixel, at its representative sample.
    pub fn pixel_regions(&self, visibility: &Visibility) -> Vec<u32> {
        let width = visibility.width;
        let mut regions = vec![NO_REGION; width * visibility.height];
        for_each_scanline(&mut regions, width, |y, scanline| {
            for (x, region) in scanline.iter_mut().enumerate() {
                if let Some((j, position)) = visibility.first_hit(y * width + x) {
                    let interpolated = || self.region_at(j, &visibility.barycentric(j, position));
                    *region = self.face_region(j).unwrap_or_else(interpolated);
                }
            }
        });
        regions
    }

    /// The number of steps to the right or down that cross the visible cut.
    pub fn count_crossings(&self, visibility: &Visibility, regions: &[u32]) -> usize {
        cut_steps(visibility, regions, 0..regions.len()).count()
    }

    /// The visible cut, one crossing for each step to the right or down that changes the region.
    pub fn crossings(&self, visibility: &Visibility, regions: &[u32]) -> Vec<Crossing> {
        let size = [visibility.width, visibility.height];
        let bands = (0..visibility.height).step_by(BAND_HEIGHT).collect();
        let found = sweep::results(bands, |first: usize| {
            let pixels = first * size[0]..(first + BAND_HEIGHT).min(size[1]) * size[0];
            // A step goes one scanline down, and `Breadths::at` goes two further.
            let (above, below) = (2 * size[0], 3 * size[0]);
            let cached =
                pixels.start.saturating_sub(above)..(pixels.end + below).min(regions.len());
            let (start, cache) = (cached.start, vec![0.0; cached.len()]);
            let mut breadths = Breadths { regions, size, start, cache };
            let crossing = |(i, k): (usize, usize)| {
                let position =
                    |i: usize| visibility.first_hit(i).map_or([0.0; 2], |(_, position)| position);
                let ends = [position(i), position(k)];
                let t = self.fraction(visibility, [i, k], [regions[i], regions[k]]);
                let [x, y] = [0, 1].map(|c| ends[0][c] + t * (ends[1][c] - ends[0][c]));
                let width = f64::from(breadths.at(i).min(breadths.at(k)));
                Crossing { from: i, x, y, radius: (width / 4.0).min(LINE_WIDTH / 2.0) }
            };
            cut_steps(visibility, regions, pixels).map(crossing).collect::<Vec<_>>()
        });
        found.into_iter().flatten().collect()
    }

    /// The fraction of the step between two pixels, of the regions p and q, at which u_p - u_q vanishes.
    fn fraction(&self, visibility: &Visibility, pixels: [usize; 2], [p, q]: [u32; 2]) -> f64 {
        let [before, after] = pixels.map(|i| {
            visibility.first_hit(i).map_or(0.0, |(j, position)| {
                let barycentric = visibility.barycentric(j, position);
                self.value(j, &barycentric, p as usize) - self.value(j, &barycentric, q as usize)
            })
        });
        let t = before / (before - after);
        if (0.0..=1.0).contains(&t) { t } else { 0.5 }
    }
}

/// The pairs of neighboring pixels that the cut separates, with the first one in `pixels`.
fn cut_steps<'a>(
    visibility: &'a Visibility,
    regions: &'a [u32],
    pixels: Range<usize>,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let width = visibility.width;
    let count = regions.len();
    pixels.flat_map(move |i| {
        let right = ((i + 1) % width != 0).then_some(i + 1);
        let below = (i + width < count).then_some(i + width);
        let separated = move |k: &usize| {
            regions[i] != regions[*k]
                && regions[i] != NO_REGION
                && regions[*k] != NO_REGION
                && visibility.connected(i, *k, 1.0)
        };
        right.into_iter().chain(below).filter(separated).map(move |k| (i, k))
    })
}

/// The breadths of regions at pixels.
struct Breadths<'a> {
    regions: &'a [u32],
    size: [usize; 2],
    /// The first pixel in the cache.
    start: usize,
    /// The lengths of the shortest runs, 0 where not computed yet.
    cache: Vec<f32>,
}

impl Breadths<'_> {
    /// The breadth at pixel i: the largest thickness there and two pixels away, so that it does not drop at the corners
    /// of a region.
    fn at(&mut self, i: usize) -> f32 {
        let [width, height] = self.size.map(|length| length as isize);
        let (x, y) = (i as isize % width, i as isize / width);
        let mut breadth = self.thickness(i);
        for (dx, dy) in [(2, 0), (0, 2), (-2, 0), (0, -2), (2, 2), (-2, 2), (2, -2), (-2, -2)] {
            let (x, y) = (x + dx, y + dy);
            if breadth < MAX_BREADTH as f32 && (0..width).contains(&x) && (0..height).contains(&y) {
                let k = (y * width + x) as usize;
                if self.regions[k] == self.regions[i] {
                    breadth = breadth.max(self.thickness(k));
                }
            }
        }
        breadth
    }

    /// The length of the shortest run of one region through pixel i, in eight directions; at most `MAX_BREADTH`.
    fn thickness(&mut self, i: usize) -> f32 {
        if self.cache[i - self.start] == 0.0 {
            let run = |(dx, dy, step)| step * self.run(i, dx, dy) as f32;
            let diagonal = std::f32::consts::SQRT_2;
            let lines = [(1, 0, 1.0), (0, 1, 1.0), (1, 1, diagonal), (1, -1, diagonal)];
            self.cache[i - self.start] =
                lines.into_iter().map(run).fold(MAX_BREADTH as f32, f32::min);
        }
        self.cache[i - self.start]
    }

    /// The number of pixels in the run of one region through pixel i along (dx, dy).
    fn run(&self, i: usize, dx: isize, dy: isize) -> usize {
        let [width, height] = self.size.map(|length| length as isize);
        let (x, y) = (i as isize % width, i as isize / width);
        let same = |n: isize| {
            let (x, y) = (x + n * dx, y + n * dy);
            (0..width).contains(&x)
                && (0..height).contains(&y)
                && self.regions[(y * width + x) as usize] == self.regions[i]
        };
        let ahead = (1..MAX_BREADTH as isize).take_while(|&n| same(n)).count();
        let behind = (1..(MAX_BREADTH - ahead) as isize).take_while(|&n| same(-n)).count();
        1 + ahead + behind
    }
}

/// The index of the largest value, the first of equal ones.
fn argmax(values: impl Iterator<Item = f64>) -> u32 {
    let mut best = (0, f64::NEG_INFINITY);
    for (p, value) in values.enumerate() {
        if value > best.1 {
            best = (p as u32, value);
        }
    }
    best.0
}

/// The coverage of every pixel by the line along the cut, on the cut's own sheet of the surface; 255 is full coverage.
/// The edge of the line is a ramp one pixel wide, and a line thinner than a pixel is faint.
pub(super) fn line_coverage(visibility: &Visibility, cut: &[Crossing]) -> Vec<u8> {
    let (width, height) = (visibility.width, visibility.height);
    let mut coverage = vec![0; width * height];
    let range = |center: f64, radius: f64, low: usize, high: usize| {
        let first = (center - radius - 1.0).ceil().max(low as f64) as usize;
        let past = (center + radius + 1.0).floor().max(low as f64) as usize;
        first..past.min(high)
    };
    for_each_band(&mut coverage, width, |first, band| {
        let rows = first..first + band.len() / width;
        for Crossing { from, x, y, radius } in cut {
            for row in range(*y, *radius, rows.start, rows.end) {
                for column in range(*x, *radius, 0, width) {
                    let i = row * width + column;
                    let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                    let distance = (dx * dx + dy * dy).sqrt();
                    let full = (2.0 * radius).min(1.0);
                    let covered = (255.0 * (radius + 0.5 - distance).clamp(0.0, full)) as u8;
                    let pixel = &mut band[i - first * width];
                    if covered > *pixel && visibility.connected(*from, i, distance.max(1.0)) {
                        *pixel = covered;
                    }
                }
            }
        }
    });
    coverage
}
