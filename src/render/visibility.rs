//! The z-buffer: which face every sample of the picture sees, and how near.

use super::bands::for_each_band;
use super::camera::{Camera, Projected, half_slope};
use crate::mesh::Mesh;

/// No face.
const EMPTY: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Hit {
    face: u32,
    w: f32,
}

/// The nearest face at each of size x size samples, which lie at half-integer coordinates. `component` names
/// the connected component of each vertex.
pub(super) struct Visibility<'a> {
    pub size: usize,
    mesh: &'a Mesh,
    projected: Vec<Projected>,
    component: &'a [u32],
    hits: Vec<Hit>,
}

/// The edge function of a line a b: at (x, y), twice the signed area of that triangle. Bitwise antisymmetric in
/// a and b, so that no sample on a shared edge falls between its two faces.
struct Edge {
    start: Projected,
    dx: f64,
    dy: f64,
}

impl Edge {
    fn new(a: &Projected, b: &Projected) -> Self {
        // Both directions start from the same end; (dx, dy) keeps the sign.
        let start = if (a.x, a.y) < (b.x, b.y) { *a } else { *b };
        Edge { start, dx: b.x - a.x, dy: b.y - a.y }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        self.on_row(self.row(y), x)
    }

    /// The part of the value that is constant on a row.
    fn row(&self, y: f64) -> f64 {
        self.dx * (y - self.start.y)
    }

    /// The value at x on the row of that part.
    fn on_row(&self, row: f64, x: f64) -> f64 {
        row - self.dy * (x - self.start.x)
    }

    /// The same line, positive inside a face of this signed area.
    fn oriented(self, area: f64) -> Self {
        let sign = area.signum();
        Edge { start: self.start, dx: sign * self.dx, dy: sign * self.dy }
    }
}

/// The edges opposite to the three corners, and twice the signed area.
fn edges([a, b, c]: &[Projected; 3]) -> ([Edge; 3], f64) {
    let edges = [Edge::new(b, c), Edge::new(c, a), Edge::new(a, b)];
    let area = edges[2].at(c.x, c.y);
    (edges, area)
}

impl<'a> Visibility<'a> {
    pub fn new(mesh: &'a Mesh, component: &'a [u32], camera: &Camera, size: usize) -> Self {
        let projected: Vec<Projected> =
            mesh.vertices.iter().map(|&point| camera.project(point, size)).collect();
        let empty = Hit { face: EMPTY, w: 0.0 };
        let mut hits = vec![empty; size * size];
        for_each_band(&mut hits, size, |first, band| {
            for (j, face) in mesh.faces.iter().enumerate() {
                let corners = face.map(|k| projected[k as usize]);
                rasterize(j as u32, &corners, first, size, band);
            }
        });
        Visibility { size, mesh, projected, component, hits }
    }

    /// The face seen by sample i (row-major).
    pub fn face(&self, i: usize) -> Option<usize> {
        let face = self.hits[i].face;
        (face != EMPTY).then_some(face as usize)
    }

    /// How many samples see the surface.
    pub fn surface(&self) -> usize {
        self.hits.iter().filter(|hit| hit.face != EMPTY).count()
    }

    fn corners(&self, j: usize) -> [Projected; 3] {
        self.mesh.faces[j].map(|k| self.projected[k as usize])
    }

    /// The barycentric coordinates, on face j, of the surface point seen by sample i.
    pub fn barycentric(&self, j: usize, i: usize) -> [f64; 3] {
        let corners = self.corners(j);
        let (x, y) = self.center(i);
        let (edges, _) = edges(&corners);
        let weight = [0, 1, 2].map(|c| edges[c].at(x, y) * corners[c].w);
        let sum: f64 = weight.iter().sum();
        weight.map(|value| value / sum)
    }

    fn center(&self, i: usize) -> (f64, f64) {
        let (row, column) = (i / self.size, i % self.size);
        (column as f64 + 0.5, row as f64 + 0.5)
    }

    /// How much w may change per sample along the surface seen by i: its slope there, and the width of a sample.
    fn slope(&self, j: usize, i: usize) -> f64 {
        let [a, b, c] = self.corners(j);
        let (_, area) = edges(&[a, b, c]);
        let (bw, cw) = (b.w - a.w, c.w - a.w);
        let dx = (bw * (c.y - a.y) - cw * (b.y - a.y)) / area;
        let dy = (cw * (b.x - a.x) - bw * (c.x - a.x)) / area;
        let w = f64::from(self.hits[i].w);
        dx.hypot(dy) + 2.0 * half_slope() * w / self.size as f64
    }

    /// Whether samples i and k, `distance` samples apart, see the same sheet of the surface: the same face,
    /// neighbors at a corner, or one component at depths that differ by no more than the gentler slope explains.
    pub fn connected(&self, i: usize, k: usize, distance: f64) -> bool {
        let (Some(a), Some(b)) = (self.face(i), self.face(k)) else {
            return false;
        };
        if self.mesh.faces[a].iter().any(|v| self.mesh.faces[b].contains(v)) {
            return true;
        }
        let [p, q] = [a, b].map(|j| self.component[self.mesh.faces[j][0] as usize]);
        if p != q {
            return false;
        }
        let slope = self.slope(a, i).min(self.slope(b, k));
        let step = f64::from(self.hits[i].w - self.hits[k].w).abs();
        step <= 2.0 * slope * distance
    }
}

/// A representative vertex of the connected component of each vertex (union-find with path halving).
pub(super) fn components(mesh: &Mesh) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for &[a, b, c] in &mesh.faces {
        for k in [b, c] {
            let (p, q) = (root(&mut parent, a), root(&mut parent, k));
            parent[p.max(q) as usize] = p.min(q);
        }
    }
    (0..parent.len() as u32).map(|v| root(&mut parent, v)).collect()
}

/// Draws one face into a band of rows that starts at row `first`. Samples on an edge belong to both faces,
/// and equal depths to the first, so that the surface has no cracks and the order of faces decides ties.
fn rasterize(j: u32, corners: &[Projected; 3], first: usize, size: usize, band: &mut [Hit]) {
    let rows = samples(corners.map(|p| p.y), first, first + band.len() / size);
    let columns = samples(corners.map(|p| p.x), 0, size);
    if rows.is_empty() || columns.is_empty() {
        return;
    }
    let (edges, area) = edges(corners);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let inside = edges.map(|edge| edge.oriented(area));
    let w = corners.map(|p| p.w / area.abs());
    for row in rows {
        let y = row as f64 + 0.5;
        let line = &mut band[(row - first) * size..][..size];
        let level = inside.each_ref().map(|edge| edge.row(y));
        for column in columns.clone() {
            let x = column as f64 + 0.5;
            let a = inside[0].on_row(level[0], x);
            let b = inside[1].on_row(level[1], x);
            let c = inside[2].on_row(level[2], x);
            if a >= 0.0 && b >= 0.0 && c >= 0.0 {
                let w = (a * w[0] + b * w[1] + c * w[2]) as f32;
                let hit = &mut line[column];
                if w > hit.w {
                    *hit = Hit { face: j, w };
                }
            }
        }
    }
}

/// The samples whose centers lie between the least and the largest coordinate, within [low, high).
fn samples(coordinates: [f64; 3], low: usize, high: usize) -> std::ops::Range<usize> {
    let [a, b, c] = coordinates;
    let from = (a.min(b).min(c) - 0.5).max(low as f64);
    let floor = from as usize;
    let least = floor + usize::from(from > floor as f64);
    let past = (a.max(b).max(c) + 0.5).clamp(0.0, high as f64) as usize;
    least..past.max(least)
}
