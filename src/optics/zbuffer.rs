//! The z-buffer of a calibrated camera: the nearest face at each sample of a grid on the image plane.
//!
//! ```text
//! beta_a = (l_a / z_a) / sum_b (l_b / z_b)        l: barycentric coordinates in the image
//! ```
//!
//! 1/z is linear in the image, and beta are the barycentric coordinates on the face. A pixel has S x S samples in a
//! square grid, so that a sample is a pixel center of the same camera at S times the resolution.
//!
//! `visibility.rs` serves pictures: eight samples at fixed offsets, in single precision. Here every sample is a
//! quadrature point, its weights must sum to 1 in double precision, and no point may fall between two faces.

use std::ops::Range;

use super::edge::{Edge, Projected, edges};
use super::pinhole::Pinhole;
use crate::mesh::Mesh;
use crate::sweep::vectorized;

/// No face. Face j is stored as j + 1, so that an empty image is zeroed memory as the system provides it.
const NO_FACE: u32 = 0;

/// The nearest faces. Samples are numbered row by row.
pub struct ZBuffer<'a> {
    mesh: &'a Mesh,
    projected: Vec<Projected>,
    /// The first row of samples, 0 for a whole image.
    first: usize,
    /// Samples in a row, and rows.
    pub width: usize,
    pub height: usize,
    /// 1/z at each sample; 0 without a face.
    pub nearness: Vec<f64>,
    faces: Vec<u32>,
    /// Faces of which a corner is not in front of the camera; they are left out.
    pub behind: usize,
}

impl<'a> ZBuffer<'a> {
    /// The z-buffer of an image of the given size in pixels (width, height), with S x S samples in each.
    pub fn new(mesh: &'a Mesh, camera: &Pinhole, [width, height]: [usize; 2], s: usize) -> Self {
        ZBuffer::of_rows(mesh, camera, width, 0..height, s)
    }

    /// The same for some rows of the pixels. Samples are numbered from their first row, and coordinates are those of the
    /// image.
    pub fn of_rows(
        mesh: &'a Mesh,
        camera: &Pinhole,
        width: usize,
        rows: Range<usize>,
        s: usize,
    ) -> Self {
        let camera = camera.scaled(s as f64);
        let projected = mesh.vertices.iter().map(|&x| camera.project(x)).collect();
        let (width, height) = (width * s, rows.len() * s);
        let mut found = ZBuffer {
            mesh,
            projected,
            first: rows.start * s,
            width,
            height,
            nearness: vec![0.0; width * height],
            faces: vec![NO_FACE; width * height],
            behind: 0,
        };
        vectorized(
            #[inline(always)]
            || (0..mesh.faces.len()).for_each(|j| found.rasterize(j)),
        );
        found
    }

    /// The nearest face at a sample.
    #[inline(always)]
    pub fn face(&self, sample: usize) -> Option<usize> {
        match self.faces[sample] {
            NO_FACE => None,
            face => Some(face as usize - 1),
        }
    }

    #[inline(always)]
    fn corners(&self, j: usize) -> [Projected; 3] {
        self.mesh.faces[j].map(|k| self.projected[k as usize])
    }

    /// beta, the barycentric coordinates on face j of what the sample in this column and row sees of it; `None` if it
    /// sees the back.
    #[inline(always)]
    pub fn front(&self, j: usize, column: usize, row: usize) -> Option<[f64; 3]> {
        let (beta, area) = self.seen(j, column, row);
        // The y axis of an image points down: a face that is counterclockwise from outside has a negative area.
        if area > 0.0 { None } else { Some(beta) }
    }

    /// beta, whichever side of face j the sample sees.
    #[inline(always)]
    pub fn on_face(&self, j: usize, column: usize, row: usize) -> [f64; 3] {
        self.seen(j, column, row).0
    }

    /// beta, and twice the signed area of face j in the image.
    #[inline(always)]
    fn seen(&self, j: usize, column: usize, row: usize) -> ([f64; 3], f64) {
        let corners = self.corners(j);
        let (edges, area) = edges(&corners);
        let (x, y) = (column as f64, row as f64);
        let weights = [0, 1, 2].map(|a| edges[a].at(x, y) * corners[a].w);
        let sum = weights[0] + weights[1] + weights[2];
        (weights.map(|weight| weight / sum), area)
    }

    /// beta_a / z on face j, linear in the image.
    #[inline(always)]
    pub fn planes(&self, j: usize) -> Planes {
        let corners = self.corners(j);
        let (edges, area) = edges(&corners);
        let Projected { x, y, .. } = corners[0];
        let plane = |a: usize| {
            let w = corners[a].w / area;
            [edges[a].at(x, y) * w, -edges[a].dy * w, edges[a].dx * w]
        };
        Planes { origin: [x, y], planes: [plane(0), plane(1), plane(2)] }
    }

    /// Calls `visit` for the samples that see a face, in runs of columns of a row with the same face.
    #[inline(always)]
    pub fn runs(&self, mut visit: impl FnMut(Run)) {
        vectorized(
            #[inline(always)]
            || {
                self.faces.chunks(self.width).enumerate().for_each(
                    #[inline(always)]
                    |(row, faces): (usize, &[u32])| {
                        let mut from = 0;
                        while from < faces.len() {
                            let face = faces[from];
                            let length =
                                faces[from..].iter().take_while(|&&other| other == face).count();
                            let to = from + length;
                            if face != NO_FACE {
                                let row = self.first + row;
                                visit(Run { face: face as usize - 1, row, columns: from..to });
                            }
                            from = to;
                        }
                    },
                )
            },
        );
    }

    /// A sample on an edge belongs to both faces, and the first of equal depths wins.
    #[inline(always)]
    fn rasterize(&mut self, j: usize) {
        let corners = self.corners(j);
        if !corners.iter().all(|corner| corner.w > 0.0) {
            self.behind += 1;
            return;
        }
        let rows = samples_between(corners.map(|p| p.y), self.first..self.first + self.height);
        let columns = samples_between(corners.map(|p| p.x), 0..self.width);
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let (edges, area) = edges(&corners);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let [a, b, c] = edges.map(|edge| edge.oriented(area));
        let w = corners.map(|p| p.w / area.abs());
        for row in rows {
            let y = row as f64;
            let level = [a.row_term(y), b.row_term(y), c.row_term(y)];
            let columns = samples_inside([&a, &b, &c], level, columns.clone());
            let from = (row - self.first) * self.width + columns.start;
            let samples = from..from + columns.len();
            let nearness = self.nearness[samples.clone()].iter_mut();
            let first = columns.start as i32;
            for ((nearest, face), i) in nearness.zip(&mut self.faces[samples]).zip(0_i32..) {
                let x = f64::from(first + i);
                let [a, b, c] =
                    [a.on_row(level[0], x), b.on_row(level[1], x), c.on_row(level[2], x)];
                let nearness = a * w[0] + b * w[1] + c * w[2];
                // Without a branch, so that it is compiled to vector instructions.
                let seen = (a >= 0.0) & (b >= 0.0) & (c >= 0.0) & (nearness > *nearest);
                *nearest = if seen { nearness } else { *nearest };
                *face = if seen { j as u32 + 1 } else { *face };
            }
        }
    }
}

/// The samples of a row that can be on the inner sides of three lines, and at most one more at each end; rounding decides
/// about those at the lines.
#[inline(always)]
fn samples_inside(edges: [&Edge; 3], level: [f64; 3], columns: Range<usize>) -> Range<usize> {
    let (mut low, mut high) = (columns.start as f64, columns.end as f64);
    for (edge, level) in edges.into_iter().zip(level) {
        if edge.dy > 0.0 {
            high = high.min(edge.crossing(level) + 2.0);
        } else if edge.dy < 0.0 {
            low = low.max(edge.crossing(level) - 1.0);
        }
    }
    let low = (low as usize).min(columns.end);
    low..(high as usize).clamp(low, columns.end)
}

/// Neighboring samples of a row that see the same face.
pub struct Run {
    pub face: usize,
    pub row: usize,
    pub columns: Range<usize>,
}

/// Three functions of the image that are linear: their values at an origin and their changes per column and per row. Their
/// sum is 1/z.
#[derive(Clone, Copy)]
pub struct Planes {
    origin: [f64; 2],
    planes: [[f64; 3]; 3],
}

impl Planes {
    /// The values at a sample, and their changes per column.
    #[inline(always)]
    pub fn along(&self, column: usize, row: usize) -> [[f64; 2]; 3] {
        let (x, y) = (column as f64 - self.origin[0], row as f64 - self.origin[1]);
        self.planes.map(|[value, dx, dy]| [value + dx * x + dy * y, dx])
    }
}

/// The integers from the smallest to the largest coordinate, within a range.
#[inline(always)]
fn samples_between([a, b, c]: [f64; 3], range: Range<usize>) -> Range<usize> {
    let [start, end] = [range.start as f64, range.end as f64];
    let first = a.min(b).min(c).ceil().max(start) as usize;
    let past = (a.max(b).max(c).floor() + 1.0).clamp(start, end) as usize;
    first..past.max(first)
}
