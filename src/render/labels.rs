//! The segmentation as the picture sees it: the region at each pixel, and the cut between regions.
//!
//! Inside a face the field is interpolated linearly and the region is its argmax, so that the cut is a smooth
//! curve instead of a chain of edges. The cut passes between two neighboring pixels iff they see the same sheet
//! of the surface and different regions.
//!
//! The line along the cut is thinner where a region is: it covers no more than half of it. How wide a region is
//! at a pixel is the shortest of its runs through that pixel in eight directions, or through one a step further.

use std::ops::Range;

use crate::mesh::Mesh;
use crate::optics::bands::{for_each_band, for_each_row};
use crate::optics::visibility::Visibility;
use crate::sweep;

/// No surface.
pub(super) const NOWHERE: u32 = u32::MAX;
/// The width of the line, in pixels.
pub(super) const LINE: f64 = 3.0;
/// A line as wide as that is thinned by regions that are narrower than this.
const WIDE: usize = 7;
/// Rows that a thread takes at once to look for the cut.
const BAND: usize = 128;

/// U with its regions at the vertices.
pub(super) struct LabelField<'a> {
    mesh: &'a Mesh,
    u: &'a [f64],
    m: usize,
    /// The argmax at each vertex.
    region: Vec<u32>,
}

/// Where the cut crosses the step from pixel `from` to a neighbor.
pub(super) struct Crossing {
    from: usize,
    x: f64,
    y: f64,
    /// Half of the width of the line there.
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

    /// How many regions there may be.
    pub fn regions(&self) -> usize {
        self.m
    }

    /// U at vertex v.
    pub fn row(&self, v: usize) -> &[f64] {
        &self.u[v * self.m..(v + 1) * self.m]
    }

    /// Region p's interpolated value on face j.
    fn value(&self, j: usize, barycentric: &[f64; 3], p: usize) -> f64 {
        let corners = self.mesh.faces[j].iter().zip(barycentric);
        corners.map(|(&v, b)| b * self.u[v as usize * self.m + p]).sum()
    }

    /// The region of all of face j, if its corners agree.
    pub fn whole(&self, j: usize) -> Option<u32> {
        let [a, b, c] = self.mesh.faces[j].map(|v| self.region[v as usize]);
        (a == b && b == c).then_some(a)
    }

    /// The region at a point of face j.
    pub fn at(&self, j: usize, barycentric: &[f64; 3]) -> u32 {
        argmax((0..self.m).map(|p| self.value(j, barycentric, p)))
    }

    /// The region that stands for every pixel.
    pub fn seen(&self, visibility: &Visibility) -> Vec<u32> {
        let width = visibility.width;
        let mut regions = vec![NOWHERE; width * visibility.height];
        for_each_row(&mut regions, width, |y, line| {
            for (x, region) in line.iter_mut().enumerate() {
                if let Some((j, place)) = visibility.front(y * width + x) {
                    let at = || self.at(j, &visibility.barycentric(j, place));
                    *region = self.whole(j).unwrap_or_else(at);
                }
            }
        });
        regions
    }

    /// How often a step to the right or down crosses the visible cut.
    pub fn count_crossings(&self, visibility: &Visibility, regions: &[u32]) -> usize {
        steps(visibility, regions, 0..regions.len()).count()
    }

    /// The visible cut, one crossing for each step to the right or down that changes the region.
    pub fn crossings(&self, visibility: &Visibility, regions: &[u32]) -> Vec<Crossing> {
        let size = [visibility.width, visibility.height];
        let bands = (0..visibility.height).step_by(BAND).collect();
        let found = sweep::results(bands, |first: usize| {
            let rows = first * size[0]..(first + BAND).min(size[1]) * size[0];
            // A step leads a row down, and `Breadths::at` two rows further.
            let (above, below) = (2 * size[0], 3 * size[0]);
            let known = rows.start.saturating_sub(above)..(rows.end + below).min(regions.len());
            let (start, known) = (known.start, vec![0.0; known.len()]);
            let mut breadths = Breadths { regions, size, start, known };
            let crossing = |(i, k): (usize, usize)| {
                let place = |i: usize| visibility.front(i).map_or([0.0; 2], |(_, place)| place);
                let places = [place(i), place(k)];
                let t = self.fraction(visibility, [i, k], [regions[i], regions[k]]);
                let [x, y] = [0, 1].map(|c| places[0][c] + t * (places[1][c] - places[0][c]));
                let width = f64::from(breadths.at(i).min(breadths.at(k)));
                Crossing { from: i, x, y, radius: (width / 4.0).min(LINE / 2.0) }
            };
            steps(visibility, regions, rows).map(crossing).collect::<Vec<_>>()
        });
        found.into_iter().flatten().collect()
    }

    /// Where u_p - u_q vanishes between two pixels of the regions p and q.
    fn fraction(&self, visibility: &Visibility, pixels: [usize; 2], [p, q]: [u32; 2]) -> f64 {
        let [before, after] = pixels.map(|i| {
            visibility.front(i).map_or(0.0, |(j, place)| {
                let barycentric = visibility.barycentric(j, place);
                self.value(j, &barycentric, p as usize) - self.value(j, &barycentric, q as usize)
            })
        });
        let t = before / (before - after);
        if (0.0..=1.0).contains(&t) { t } else { 0.5 }
    }
}

/// The pairs of neighboring pixels that the cut parts, the first one among some.
fn steps<'a>(
    visibility: &'a Visibility,
    regions: &'a [u32],
    pixels: Range<usize>,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let width = visibility.width;
    let count = regions.len();
    pixels.flat_map(move |i| {
        let right = ((i + 1) % width != 0).then_some(i + 1);
        let below = (i + width < count).then_some(i + width);
        let parted = move |k: &usize| {
            regions[i] != regions[*k]
                && regions[i] != NOWHERE
                && regions[*k] != NOWHERE
                && visibility.connected(i, *k, 1.0)
        };
        right.into_iter().chain(below).filter(parted).map(move |k| (i, k))
    })
}

/// How wide regions are around pixels.
struct Breadths<'a> {
    regions: &'a [u32],
    size: [usize; 2],
    /// The lengths of the shortest runs from pixel `start` on, 0 where none was asked for.
    start: usize,
    known: Vec<f32>,
}

impl Breadths<'_> {
    /// At the corners of a region it is as wide as a little further inside.
    fn at(&mut self, i: usize) -> f32 {
        let [width, height] = self.size.map(|length| length as isize);
        let (x, y) = (i as isize % width, i as isize / width);
        let mut broadest = self.thickness(i);
        for (dx, dy) in [(2, 0), (0, 2), (-2, 0), (0, -2), (2, 2), (-2, 2), (2, -2), (-2, -2)] {
            let (x, y) = (x + dx, y + dy);
            if broadest < WIDE as f32 && (0..width).contains(&x) && (0..height).contains(&y) {
                let k = (y * width + x) as usize;
                if self.regions[k] == self.regions[i] {
                    broadest = broadest.max(self.thickness(k));
                }
            }
        }
        broadest
    }

    /// The length of the shortest run of one region through pixel i, in eight directions; at most `WIDE`.
    fn thickness(&mut self, i: usize) -> f32 {
        if self.known[i - self.start] == 0.0 {
            let run = |(dx, dy, step)| step * self.run(i, dx, dy) as f32;
            let diagonal = std::f32::consts::SQRT_2;
            let lines = [(1, 0, 1.0), (0, 1, 1.0), (1, 1, diagonal), (1, -1, diagonal)];
            self.known[i - self.start] = lines.into_iter().map(run).fold(WIDE as f32, f32::min);
        }
        self.known[i - self.start]
    }

    /// How many pixels of one region lie ahead of and behind pixel i, itself included.
    fn run(&self, i: usize, dx: isize, dy: isize) -> usize {
        let [width, height] = self.size.map(|length| length as isize);
        let (x, y) = (i as isize % width, i as isize / width);
        let same = |n: isize| {
            let (x, y) = (x + n * dx, y + n * dy);
            (0..width).contains(&x)
                && (0..height).contains(&y)
                && self.regions[(y * width + x) as usize] == self.regions[i]
        };
        let ahead = (1..WIDE as isize).take_while(|&n| same(n)).count();
        let behind = (1..(WIDE - ahead) as isize).take_while(|&n| same(-n)).count();
        1 + ahead + behind
    }
}

/// The index of the largest value, the first of equals.
fn argmax(values: impl Iterator<Item = f64>) -> u32 {
    let mut best = (0, f64::NEG_INFINITY);
    for (p, value) in values.enumerate() {
        if value > best.1 {
            best = (p as u32, value);
        }
    }
    best.0
}

/// How much of every pixel the line along the cut covers, on the cut's own sheet of the surface; 255 is all of
/// it. The edge of the line is a ramp one pixel wide, and what is thinner than a pixel is faint.
pub(super) fn line(visibility: &Visibility, cut: &[Crossing]) -> Vec<u8> {
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
                    let most = (2.0 * radius).min(1.0);
                    let covered = (255.0 * (radius + 0.5 - distance).clamp(0.0, most)) as u8;
                    let covers = &mut band[i - first * width];
                    if covered > *covers && visibility.connected(*from, i, distance.max(1.0)) {
                        *covers = covered;
                    }
                }
            }
        }
    });
    coverage
}
