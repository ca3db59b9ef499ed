//! The faces near given points of an image, in bins of 8 x 8 pixels.

use crate::optics::edge::{Projected, edges};

/// Pixels along the side of a bin.
const BIN: usize = 8;

/// The end of a list.
const NONE: u32 = u32::MAX;

/// A list of faces for each bin that has a point.
pub struct Bins<'a> {
    projected: &'a [Projected],
    faces: &'a [[u32; 3]],
    columns: usize,
    /// The first entry of the list of each bin.
    first: Vec<u32>,
    /// A face, and the next entry.
    entries: Vec<[u32; 2]>,
}

/// A face that the ray of a point meets.
#[derive(Clone, Copy, Debug)]
pub struct Met {
    /// j.
    pub face: usize,
    /// The barycentric coordinates on the face.
    pub beta: [f64; 3],
    /// 1/z.
    pub nearness: f64,
}

impl<'a> Bins<'a> {
    /// The bins of an image of the given size for these points of it; faces that reach behind the camera are left out.
    pub fn new(
        [width, height]: [usize; 2],
        projected: &'a [Projected],
        faces: &'a [[u32; 3]],
        points: impl Iterator<Item = [f64; 2]>,
    ) -> Self {
        let [columns, rows] = [width, height].map(|n| n.div_ceil(BIN));
        let mut wanted = vec![false; columns * rows];
        for [x, y] in points {
            wanted[bin(y, rows) * columns + bin(x, columns)] = true;
        }
        let mut bins = Bins {
            projected,
            faces,
            columns,
            first: vec![NONE; columns * rows],
            entries: Vec::new(),
        };
        for (j, face) in faces.iter().enumerate() {
            let corners = face.map(|k| projected[k as usize]);
            if !corners.iter().all(|corner| corner.w > 0.0) {
                continue;
            }
            let [x, y] = [corners.map(|p| p.x), corners.map(|p| p.y)];
            let range = |[a, b, c]: [f64; 3], n: usize| {
                let (low, high) = (a.min(b).min(c), a.max(b).max(c));
                let inside = high >= -0.5 && low < (n * BIN) as f64;
                if inside { bin(low, n)..bin(high, n) + 1 } else { 0..0 }
            };
            for row in range(y, rows) {
                for column in range(x, columns) {
                    let bin = row * columns + column;
                    if wanted[bin] {
                        bins.entries.push([j as u32, bins.first[bin]]);
                        bins.first[bin] = bins.entries.len() as u32 - 1;
                    }
                }
            }
        }
        bins
    }

    /// The nearest face at a point whose `skip` is false and that is no nearer than `limit`, which is 1/z; `Err` if one is
    /// nearer, and thus hides the point.
    pub fn behind(
        &self,
        [x, y]: [f64; 2],
        limit: f64,
        skip: impl Fn(usize) -> bool,
    ) -> Result<Option<Met>, Hidden> {
        let rows = self.first.len() / self.columns;
        let mut entry = self.first[bin(y, rows) * self.columns + bin(x, self.columns)];
        let mut nearest: Option<Met> = None;
        while entry != NONE {
            let [j, next] = self.entries[entry as usize];
            entry = next;
            let j = j as usize;
            if skip(j) {
                continue;
            }
            let Some(met) = self.meets(j, [x, y]) else { continue };
            if met.nearness > limit {
                return Err(Hidden);
            }
            if nearest.is_none_or(|nearest| met.nearness > nearest.nearness) {
                nearest = Some(met);
            }
        }
        Ok(nearest)
    }

    #[inline(always)]
    fn meets(&self, j: usize, [x, y]: [f64; 2]) -> Option<Met> {
        let corners = self.faces[j].map(|k| self.projected[k as usize]);
        let [a, b, c] = &corners;
        let apart = |a: f64, b: f64, c: f64, at: f64| {
            (at < a && at < b && at < c) || (at > a && at > b && at > c)
        };
        if apart(a.x, b.x, c.x, x) || apart(a.y, b.y, c.y, y) {
            return None;
        }
        let (edges, area) = edges(&corners);
        if area == 0.0 {
            return None;
        }
        let l = [0, 1, 2].map(|a| edges[a].at(x, y) / area);
        if l.iter().any(|l| *l < 0.0) {
            return None;
        }
        let over_z = [0, 1, 2].map(|a| l[a] * corners[a].w);
        let nearness = over_z[0] + over_z[1] + over_z[2];
        Some(Met { face: j, beta: over_z.map(|value| value / nearness), nearness })
    }
}

/// Something is in front of the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hidden;

/// The bin of a coordinate, of n in a row or column; those at the ends have what is outside as well.
#[inline(always)]
fn bin(at: f64, n: usize) -> usize {
    (((at + 0.5) / BIN as f64).max(0.0) as usize).min(n - 1)
}
