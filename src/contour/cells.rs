//! Every face of a mesh divided into the cells of U, with nodes that neighbors share.

use std::collections::HashMap;

use nalgebra::Point3;
use ndarray::{Array2, ArrayView2, CowArray, Ix2};

use crate::mesh::Mesh;
use crate::sweep::{collect, results};

use super::face::{BITS, Cell, Partition};

/// Marks a face with several cells.
pub const SEVERAL: u8 = u8::MAX;
/// Number of faces that a thread divides at a time.
const BAND: usize = 4096;

/// Every face of a mesh divided into the cells of U.
pub struct Cells<'a> {
    pub(super) mesh: &'a Mesh,
    m: usize,
    /// For each vertex a bit for each region that is the largest there.
    pub(super) largest: Vec<u64>,
    /// The region of each face that has only one, else `SEVERAL`.
    pub(super) whole: Vec<u8>,
    /// The faces with several cells, ascending.
    pub(super) divided: Vec<DividedFace>,
    /// The nodes that are not vertices; they have the indices from V on.
    pub(super) points: Vec<Point3<f64>>,
}

/// A face with several cells.
pub struct DividedFace {
    pub face: usize,
    pub nodes: Vec<FaceNode>,
    pub cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
pub struct FaceNode {
    /// A vertex, or V plus the index of a point.
    pub id: u32,
    pub barycentric: [f64; 3],
}

impl<'a> Cells<'a> {
    /// The cells of U, V x m with rows in the simplex; for two regions and a threshold t, {u_0 >= t} and {u_0 < t}.
    ///
    /// Panics if U has not V rows or not 1 to 64 columns, if a threshold is given for other than two regions, or if more
    /// than 2^32 - 1 nodes would be needed.
    pub fn new(mesh: &'a Mesh, u: ArrayView2<'_, f64>, threshold: Option<f64>) -> Self {
        let m = u.ncols();
        assert!(u.nrows() == mesh.vertices.len() && (1..=64).contains(&m));
        assert!(threshold.is_none() || m == 2);
        let u = compared_rows(u, threshold);
        let value = |v: usize, p: usize| integer(u[[v, p]]);
        let largest = collect(mesh.vertices.len(), |v| {
            let (mut most, mut bits) = (i64::MIN, 0);
            for p in 0..m {
                let value = value(v, p);
                if value > most {
                    (most, bits) = (value, 0);
                }
                bits |= u64::from(value == most) << p;
            }
            bits
        });
        // A region that is the largest at all corners is the largest everywhere.
        let whole = collect(mesh.faces.len(), |j| {
            let [a, b, c] = mesh.faces[j].map(|v| largest[v as usize]);
            let common = a & b & c;
            if common == 0 { SEVERAL } else { common.trailing_zeros() as u8 }
        });
        let bands = (0..mesh.faces.len()).step_by(BAND).collect();
        let partitions = results(bands, |first: usize| {
            let band = first..(first + BAND).min(whole.len());
            let divided = band.filter(|&j| whole[j] == SEVERAL);
            let partition =
                |j: usize| (j, Partition::new(m, |i, p| value(mesh.faces[j][i] as usize, p)));
            divided.map(partition).collect::<Vec<_>>()
        });
        let mut cells = Cells { mesh, m, largest, whole, divided: Vec::new(), points: Vec::new() };
        let mut on_edges = HashMap::new();
        for (face, partition) in partitions.into_iter().flatten() {
            cells.add(face, partition, &mut on_edges);
        }
        cells
    }

    /// Adds a face; nodes on its edges are shared with the faces before.
    fn add(
        &mut self,
        face: usize,
        partition: Partition,
        on_edges: &mut HashMap<[(u32, i128); 2], u32>,
    ) {
        let (vertices, x) = (self.mesh.faces[face], self.mesh.corners(face));
        let node = |w: [i128; 3]| {
            let sum = w.iter().sum::<i128>() as f64;
            let barycentric = w.map(|w| w as f64 / sum);
            let mut create = || {
                let point = (0..3).fold(nalgebra::Vector3::zeros(), |point, i| {
                    if w[i] == 0 { point } else { point + barycentric[i] * x[i].coords }
                });
                self.points.push(point.into());
                u32::try_from(self.mesh.vertices.len() + self.points.len() - 1)
                    .expect("at most 2^32 - 1 vertices")
            };
            let mut at = (0..3).filter(|&i| w[i] != 0).map(|i| (vertices[i], w[i]));
            let id = match (at.next(), at.next(), at.next()) {
                (Some((v, _)), None, _) => v,
                (Some(a), Some(b), None) => {
                    *on_edges.entry(if a < b { [a, b] } else { [b, a] }).or_insert_with(create)
                }
                _ => create(),
            };
            FaceNode { id, barycentric }
        };
        let nodes = partition.nodes.into_iter().map(node).collect();
        self.divided.push(DividedFace { face, nodes, cells: partition.cells });
    }

    /// The area of each region, m numbers in squared units of the mesh.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.m];
        let of_faces = collect(self.whole.len(), |j| self.mesh.face_area(j));
        for (&p, area) in self.whole.iter().zip(&of_faces).filter(|&(&p, _)| p != SEVERAL) {
            areas[usize::from(p)] += area;
        }
        for face in &self.divided {
            for cell in &face.cells {
                areas[cell.region] += of_faces[face.face] * share(&face.polygon(cell));
            }
        }
        areas
    }

    pub(super) fn point(&self, id: u32) -> Point3<f64> {
        let (id, count) = (id as usize, self.mesh.vertices.len());
        if id < count { self.mesh.vertices[id] } else { self.points[id - count] }
    }
}

impl DividedFace {
    /// The corners of a cell in barycentric coordinates.
    pub fn polygon(&self, cell: &Cell) -> Vec<[f64; 3]> {
        cell.corners.iter().map(|&(n, _)| self.nodes[n].barycentric).collect()
    }
}

/// The rows whose largest entries are the regions: those of U, or (u_0, t) for two regions and a threshold t.
pub fn compared_rows(u: ArrayView2<'_, f64>, threshold: Option<f64>) -> CowArray<'_, f64, Ix2> {
    match threshold {
        Some(t) => {
            Array2::from_shape_fn(u.dim(), |(v, p)| if p == 0 { u[[v, 0]] } else { t }).into()
        }
        None => u.into(),
    }
}

/// u as an integer.
fn integer(u: f64) -> i64 {
    (u.clamp(0.0, 1.0) * (1_u64 << BITS) as f64).round() as i64
}

/// The share of the area of a face that a polygon has, by the shoelace formula.
pub fn share(polygon: &[[f64; 3]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a[1] * b[2] - a[2] * b[1]).sum()
}
