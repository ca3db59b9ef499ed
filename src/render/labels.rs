//! The segmentation as the picture sees it: the region at each sample, and the cut between regions.
//!
//! Inside a face the field is interpolated linearly and the region is its argmax, so that the cut is a smooth
//! curve instead of a chain of edges. The cut passes between two neighboring samples iff they see the same
//! sheet of the surface and different regions.

use super::bands::for_each_row;
use super::visibility::Visibility;
use crate::mesh::Mesh;

/// U with its faces' regions.
pub(super) struct LabelField<'a> {
    mesh: &'a Mesh,
    u: &'a [f64],
    m: usize,
    /// The argmax at each vertex.
    region: Vec<u32>,
}

/// Where the cut crosses the step from sample `from` to a neighbor, in sample coordinates.
pub(super) struct Crossing {
    pub from: usize,
    pub x: f64,
    pub y: f64,
}

impl<'a> LabelField<'a> {
    pub fn new(mesh: &'a Mesh, u: &'a [f64], m: usize) -> Self {
        let region = u.chunks_exact(m).map(|row| argmax(row.iter().copied()));
        LabelField { mesh, u, m, region: region.collect() }
    }

    /// Region p's interpolated value on face j.
    fn value(&self, j: usize, barycentric: &[f64; 3], p: usize) -> f64 {
        let corners = self.mesh.faces[j].iter().zip(barycentric);
        corners.map(|(&v, b)| b * self.u[v as usize * self.m + p]).sum()
    }

    /// The region at a point of face j. Where the three corners agree, so does the face between them.
    fn region_at(&self, j: usize, barycentric: impl FnOnce() -> [f64; 3]) -> u32 {
        let [a, b, c] = self.mesh.faces[j].map(|v| self.region[v as usize]);
        if a == b && b == c {
            return a;
        }
        let barycentric = barycentric();
        argmax((0..self.m).map(|p| self.value(j, &barycentric, p)))
    }

    /// The region at every sample; 0 where there is no surface.
    pub fn seen(&self, visibility: &Visibility) -> Vec<u32> {
        let size = visibility.size;
        let mut regions = vec![0; size * size];
        for_each_row(&mut regions, size, |y, line| {
            for (x, region) in line.iter_mut().enumerate() {
                let i = y * size + x;
                if let Some(j) = visibility.face(i) {
                    *region = self.region_at(j, || visibility.barycentric(j, i));
                }
            }
        });
        regions
    }

    /// The visible cut, one crossing for each step to the right or down that changes the region.
    pub fn crossings(&self, visibility: &Visibility, regions: &[u32]) -> Vec<Crossing> {
        let size = visibility.size;
        let mut crossings = Vec::new();
        for row in 0..size {
            for column in 0..size {
                let i = row * size + column;
                let steps =
                    [(column + 1 < size, i + 1, 1.0, 0.0), (row + 1 < size, i + size, 0.0, 1.0)];
                for (inside, k, dx, dy) in steps {
                    if inside && regions[i] != regions[k] && visibility.connected(i, k, 1.0) {
                        let pair = [regions[i], regions[k]];
                        let t = self.crossing_fraction(visibility, [i, k], pair);
                        crossings.push(Crossing {
                            from: i,
                            x: column as f64 + 0.5 + t * dx,
                            y: row as f64 + 0.5 + t * dy,
                        });
                    }
                }
            }
        }
        crossings
    }

    /// Where u_p - u_q vanishes between two samples of the regions p and q.
    fn crossing_fraction(
        &self,
        visibility: &Visibility,
        samples: [usize; 2],
        [p, q]: [u32; 2],
    ) -> f64 {
        let [before, after] = samples.map(|i| {
            visibility.face(i).map_or(0.0, |j| {
                let barycentric = visibility.barycentric(j, i);
                self.value(j, &barycentric, p as usize) - self.value(j, &barycentric, q as usize)
            })
        });
        let t = before / (before - after);
        if (0.0..=1.0).contains(&t) { t } else { 0.5 }
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

/// How much of every sample the line covers that follows the cut with `radius` samples to both sides, on the
/// cut's own sheet of the surface; 255 is all of it. The edge of the line is a ramp one sample wide.
pub(super) fn thicken(visibility: &Visibility, cut: &[Crossing], radius: f64) -> Vec<u8> {
    let size = visibility.size;
    let mut coverage = vec![0; size * size];
    let range = |center: f64| {
        let low = (center - radius - 1.0).ceil().max(0.0) as usize;
        let high = (center + radius).floor() as usize;
        low..=high.min(size - 1)
    };
    for crossing in cut {
        for row in range(crossing.y) {
            for column in range(crossing.x) {
                let i = row * size + column;
                let dx = column as f64 + 0.5 - crossing.x;
                let dy = row as f64 + 0.5 - crossing.y;
                let distance = dx.hypot(dy);
                let covered = (255.0 * (radius + 0.5 - distance).clamp(0.0, 1.0)).round() as u8;
                if covered > coverage[i]
                    && visibility.connected(crossing.from, i, distance.max(1.0))
                {
                    coverage[i] = covered;
                }
            }
        }
    }
    coverage
}
