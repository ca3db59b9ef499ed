//! The z-buffer: the visible face at each of eight samples of every pixel, and its depth.
//!
//! The samples of a pixel lie in different eighths along both axes, so that edges of any slope get eight levels of
//! coverage.

use std::sync::atomic::{AtomicBool, Ordering};

use pulp::Arch;

use super::bands::for_each_band;
use super::camera::Camera;
use super::edge::{Edge, Projected, edges};
use crate::mesh::Mesh;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::sweep;

/// No face. Face j is stored as j + 1, so that an empty picture is zeroed memory as the system provides it.
const NO_FACE: u32 = 0;

/// Scanlines that a thread searches at a time for visible faces.
const BAND_HEIGHT: usize = 64;

/// Samples per pixel.
pub const SAMPLES: usize = 8;

/// Offsets of the samples from the center of the pixel; the first sample is the nearest to it.
const SAMPLE_X: [f32; SAMPLES] =
    [0.0625, -0.0625, 0.3125, -0.1875, -0.3125, -0.4375, 0.1875, 0.4375];
const SAMPLE_Y: [f32; SAMPLES] =
    [-0.1875, 0.1875, 0.0625, -0.3125, 0.3125, -0.0625, 0.4375, -0.4375];

/// One cache line: the bits of the reciprocal distances of the samples, and their faces.
type Pixel = [[u32; SAMPLES]; 2];

/// The part of a pixel in which one face is visible.
pub struct Fragment {
    pub face: usize,
    /// Its samples, one bit each.
    pub samples: u8,
}

/// The visible faces in ascending order, and for each face of the mesh its index among them, if it is visible.
pub struct VisibleFaces {
    pub faces: Vec<u32>,
    pub index: Vec<u32>,
}

/// The mesh as a camera sees it. `component` holds a representative of each vertex's connected component.
pub struct Visibility<'a> {
    pub width: usize,
    pub height: usize,
    mesh: &'a Mesh,
    camera: &'a Camera,
    projected: Vec<Projected>,
    component: &'a [u32],
    pixels: Vec<Pixel>,
}

/// The differences between the values of an edge function at the samples of a pixel and at its center.
#[inline(always)]
fn offsets(edge: &Edge) -> [f32; SAMPLES] {
    let (dx, dy) = (edge.dx as f32, edge.dy as f32);
    std::array::from_fn(|s| dx * SAMPLE_Y[s] - dy * SAMPLE_X[s])
}

impl<'a> Visibility<'a> {
    pub fn new(mesh: &'a Mesh, component: &'a [u32], camera: &'a Camera) -> Self {
        let [width, height] = camera.size();
        let nowhere = Projected { x: 0.0, y: 0.0, w: 0.0 };
        let mut projected = vec![nowhere; mesh.vertices.len()];
        for_each_band(&mut projected, 1, |first, band| {
            for (to, &point) in band.iter_mut().zip(&mesh.vertices[first..]) {
                *to = camera.project(point);
            }
        });
        let mut pixels = vec![[[0; SAMPLES], [NO_FACE; SAMPLES]]; width * height];
        for_each_band(&mut pixels, width, |first, band| {
            // With the widest vectors that the processor has; the results are bitwise equal.
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for (j, face) in mesh.faces.iter().enumerate() {
                        let corners = face.map(|k| projected[k as usize]);
                        rasterize(j as u32 + 1, &corners, first, width, band);
                    }
                },
            );
        });
        Visibility { width, height, mesh, camera, projected, component, pixels }
    }

    pub fn camera(&self) -> &Camera {
        self.camera
    }

    /// Calls `visit` for each face visible in pixel i (row-major), ordered by first sample.
    #[inline(always)]
    pub fn fragments(&self, i: usize, mut visit: impl FnMut(Fragment)) {
        let [_, faces] = &self.pixels[i];
        if faces.iter().fold(0, |differ, face| differ | (face ^ faces[0])) == 0 {
            if faces[0] != NO_FACE {
                visit(Fragment { face: faces[0] as usize - 1, samples: u8::MAX });
            }
            return;
        }
        let mut left = 0_u8;
        for (s, &face) in faces.iter().enumerate() {
            left |= u8::from(face != NO_FACE) << s;
        }
        while left != 0 {
            let face = faces[left.trailing_zeros() as usize];
            let mut samples = 0_u8;
            for (s, &other) in faces.iter().enumerate() {
                samples |= u8::from(other == face) << s;
            }
            visit(Fragment { face: face as usize - 1, samples });
            left &= !samples;
        }
    }

    /// The centroid of the given samples of pixel i.
    #[inline(always)]
    pub fn centroid(&self, i: usize, samples: u8) -> [f64; 2] {
        let [mut x, mut y] = [0.0; 2];
        // The centroid of all samples is the center of the pixel.
        for s in (0..SAMPLES).filter(|_| samples != u8::MAX).filter(|s| samples >> s & 1 == 1) {
            x += SAMPLE_X[s];
            y += SAMPLE_Y[s];
        }
        let count = f64::from(samples.count_ones());
        [
            (i % self.width) as f64 + 0.5 + f64::from(x) / count,
            (i / self.width) as f64 + 0.5 + f64::from(y) / count,
        ]
    }

    /// The sample that represents pixel i: the first one that shows the surface.
    fn first_sample(&self, i: usize) -> Option<usize> {
        self.pixels[i][1].iter().position(|&face| face != NO_FACE)
    }

    /// The face at sample s of pixel i.
    fn face(&self, i: usize, s: usize) -> usize {
        self.pixels[i][1][s] as usize - 1
    }

    /// The face that represents pixel i, and the position of its sample.
    pub fn first_hit(&self, i: usize) -> Option<(usize, [f64; 2])> {
        let s = self.first_sample(i)?;
        Some((self.face(i, s), self.centroid(i, 1 << s)))
    }

    /// Whether all of the surface visible in the pixel of vertex v is nearer than v by more than `pixels` pixels.
    pub fn is_occluded(&self, v: usize, pixels: f64) -> bool {
        let Projected { x, y, w } = self.projected[v];
        let (x, y) = (x as usize, y as usize);
        let i = y.min(self.height - 1) * self.width + x.min(self.width - 1);
        let farthest = self.pixels[i][0].iter().filter(|&&bits| bits > 0).min();
        farthest.is_some_and(|&bits| {
            f64::from(f32::from_bits(bits)) > w + pixels * self.camera.depth_per_pixel(w)
        })
    }

    fn corners(&self, j: usize) -> [Projected; 3] {
        self.mesh.faces[j].map(|k| self.projected[k as usize])
    }

    /// The barycentric coordinates, on face j, of the surface point at a position in the picture.
    pub fn barycentric(&self, j: usize, [x, y]: [f64; 2]) -> [f64; 3] {
        let corners = self.corners(j);
        let (edges, _) = edges(&corners);
        let weight = [0, 1, 2].map(|c| edges[c].at(x, y) * corners[c].w);
        let sum: f64 = weight.iter().sum();
        weight.map(|value| value / sum)
    }

    /// The change of w per pixel that face j explains: the slope of its plane plus that of a surface inclined by 45
    /// degrees.
    fn slope(&self, j: usize, w: f64) -> f64 {
        let [a, b, c] = self.corners(j);
        let (_, area) = edges(&[a, b, c]);
        let (bw, cw) = (b.w - a.w, c.w - a.w);
        let dx = (bw * (c.y - a.y) - cw * (b.y - a.y)) / area;
        let dy = (cw * (b.x - a.x) - bw * (c.x - a.x)) / area;
        dx.hypot(dy) + self.camera.depth_per_pixel(w)
    }

    /// Whether pixels i and k, `distance` pixels apart, show the same sheet of the surface: the same face, faces that
    /// share a corner, or one component at depths that differ by no more than the smaller slope explains.
    pub fn connected(&self, i: usize, k: usize, distance: f64) -> bool {
        let (Some(s), Some(t)) = (self.first_sample(i), self.first_sample(k)) else {
            return false;
        };
        let [a, b] = [self.face(i, s), self.face(k, t)];
        if self.mesh.faces[a].iter().any(|v| self.mesh.faces[b].contains(v)) {
            return true;
        }
        let [p, q] = [a, b].map(|j| self.component[self.mesh.faces[j][0] as usize]);
        if p != q {
            return false;
        }
        let [v, w] = [self.pixels[i][0][s], self.pixels[k][0][t]]
            .map(|bits| f64::from(f32::from_bits(bits)));
        (v - w).abs() <= 2.0 * self.slope(a, v).min(self.slope(b, w)) * distance
    }

    /// The faces visible at some sample.
    pub fn visible_faces(&self) -> VisibleFaces {
        let count = self.mesh.faces.len();
        let mut seen = Vec::with_capacity(count);
        seen.resize_with(count, AtomicBool::default);
        let bands = self.pixels.chunks(BAND_HEIGHT * self.width).collect();
        sweep::each(bands, &|band: &[Pixel]| {
            let mut last = NO_FACE;
            for &face in band.iter().flat_map(|[_, faces]| faces) {
                if face != last && face != NO_FACE {
                    seen[face as usize - 1].store(true, Ordering::Relaxed);
                }
                last = face;
            }
        });
        let mut visible = VisibleFaces { faces: Vec::new(), index: vec![0; count] };
        for (j, _) in seen.iter().enumerate().filter(|(_, seen)| seen.load(Ordering::Relaxed)) {
            visible.index[j] = visible.faces.len() as u32;
            visible.faces.push(j as u32);
        }
        visible
    }

    /// The perspective-correct barycentric coordinates on face j, up to a factor, as functions of the position.
    pub fn planes(&self, j: usize) -> Planes {
        let corners = self.corners(j);
        let [a, ..] = corners;
        let (edges, area) = edges(&corners);
        let plane = |c: usize| {
            let (edge, w) = (&edges[c], corners[c].w / area);
            let level = edge.at(a.x, a.y);
            [-edge.dy * w, edge.dx * w, level * w].map(|x| x as f32)
        };
        Planes { origin: [a.x, a.y], planes: [plane(0), plane(1), plane(2)] }
    }
}

/// See [`Visibility::planes`]; relative to a corner, single precision is enough.
#[derive(Clone, Copy, Default)]
pub struct Planes {
    origin: [f64; 2],
    planes: [[f32; 3]; 3],
}

impl Planes {
    #[inline(always)]
    pub fn barycentric(&self, [x, y]: [f64; 2]) -> [f32; 3] {
        let (x, y) = ((x - self.origin[0]) as f32, (y - self.origin[1]) as f32);
        let weights = self.planes.map(|[a, b, c]| a * x + b * y + c);
        let sum = weights[0] + weights[1] + weights[2];
        weights.map(|weight| weight / sum)
    }
}

/// The smallest vertex of the connected component of each vertex.
pub fn components(mesh: &Mesh) -> Vec<u32> {
    let mut joined = DisjointSets::new(mesh.vertices.len());
    for &[a, b, c] in &mesh.faces {
        joined.join(a, b);
        joined.join(a, c);
    }
    (0..mesh.vertices.len() as u32).map(|v| joined.root(v)).collect()
}

/// Draws a face, stored as `id` in the pixels, into a band that starts at scanline `first`. A sample on an edge belongs
/// to both faces, and the first of equal depths wins: the surface has no cracks, and the order of faces decides ties.
#[inline(always)]
fn rasterize(id: u32, corners: &[Projected; 3], first: usize, width: usize, band: &mut [Pixel]) {
    let rows = pixel_range(corners.map(|p| p.y), first, first + band.len() / width);
    if rows.is_empty() {
        return;
    }
    let columns = pixel_range(corners.map(|p| p.x), 0, width);
    let (edges, area) = edges(corners);
    if columns.is_empty() || area == 0.0 || !area.is_finite() {
        return;
    }
    let [a, b, c] = edges.map(|edge| edge.oriented(area));
    let offsets = [offsets(&a), offsets(&b), offsets(&c)];
    // How far a sample can be on the inner side of an edge whose outer side contains the center of its pixel.
    let reach = [&a, &b, &c].map(|edge| ((edge.dx.abs() + edge.dy.abs()) / 2.0) as f32);
    let w = corners.map(|p| (p.w / area.abs()) as f32);
    for row in rows {
        let y = row as f64 + 0.5;
        let scanline = &mut band[(row - first) * width..][..width];
        let level = [a.row_term(y), b.row_term(y), c.row_term(y)];
        for column in columns.clone() {
            let x = column as f64 + 0.5;
            let center = [a.on_row(level[0], x), b.on_row(level[1], x), c.on_row(level[2], x)]
                .map(|value| value as f32);
            if center[0] < -reach[0] || center[1] < -reach[1] || center[2] < -reach[2] {
                continue;
            }
            // On the bit patterns, which every processor can compare in vectors: a negative value is outside, and
            // positive numbers are ordered like their bits.
            let [nearest, face] = &mut scanline[column];
            let at =
                |k: usize| -> [f32; SAMPLES] { std::array::from_fn(|s| center[k] + offsets[k][s]) };
            let (a, b, c) = (at(0), at(1), at(2));
            let depth: [u32; SAMPLES] =
                std::array::from_fn(|s| (a[s] * w[0] + b[s] * w[1] + c[s] * w[2]).to_bits());
            let seen: [u32; SAMPLES] = std::array::from_fn(|s| {
                let outside = a[s].to_bits() | b[s].to_bits() | c[s].to_bits();
                let nearer = nearest[s].wrapping_sub(depth[s]);
                ((nearer & !outside) as i32 >> 31) as u32
            });
            for s in 0..SAMPLES {
                nearest[s] = nearest[s] & !seen[s] | depth[s] & seen[s];
                face[s] = face[s] & !seen[s] | id & seen[s];
            }
        }
    }
}

/// The pixels between the smallest and the largest coordinate, within [low, high).
#[inline(always)]
fn pixel_range(coordinates: [f64; 3], low: usize, high: usize) -> std::ops::Range<usize> {
    let [a, b, c] = coordinates;
    let from = a.min(b).min(c).max(low as f64) as usize;
    let past = (a.max(b).max(c) + 1.0).clamp(0.0, high as f64) as usize;
    from..past.max(from)
}
