//! Graphs whose cuts cost about lambda |(K U)_j|, summed over the faces, for one-hot U.
//!
//! A curve costs sqrt(2) lambda times its length. An edge ij opposite to corner k of a face j weighs sqrt(2) lambda
//! times
//!
//! ```text
//! exact        (l_i + l_j - l_k) / 4
//! cotangent    cot(alpha_k) l_k / 2
//! crofton      (g_i + g_j) / (4 l_k),      g_i = alpha_i / 2  2 pi a_i / Theta_i
//! ```
//!
//! and the weights of its faces are summed. l_i is the length of the edge opposite to corner i, alpha_i the angle at
//! it, Theta_i the sum of the angles at its vertex, and a_i the barycentric area of its vertex.
//!
//! * `exact`: where a face has at most two labels, the cut costs lambda |(K U)_j|, see `labels.rs`; with the relaxation
//!   `separate` for all labels.
//! * `cotangent`: the length of the dual edge between the circumcenters of the two faces, 0 where it is negative.
//! * `crofton`: the edges at a vertex as lines of an integral over all lines that cross a curve. Each stands for the
//!   directions halfway to its neighbors, and for a strip of the width a_i / l_k. Reference: Y. Boykov, V. Kolmogorov,
//!   *Computing geodesics and minimal surfaces via graph cuts*, ICCV 2003.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::domain::Domain;
use crate::mesh::Mesh;
use crate::mesh::geometry::{barycentric_areas, cotangents, opposite_edges};
use crate::mesh::incidence::Incidence;

/// How edges are weighted.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum EdgeWeights {
    /// Exact where a face has at most two labels.
    Exact,
    /// Lengths of dual edges.
    Cotangent,
    /// From the Cauchy-Crofton formula.
    Crofton,
}

/// The edges of a mesh with their weights.
pub struct Graph {
    /// The neighbors of vertex v are `neighbors[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    /// Neighbors, and the weights of the edges to them.
    neighbors: Vec<(u32, f64)>,
}

impl Graph {
    /// The graph of a mesh without degenerate faces; with factors, or of its faces, all weights are the exact ones.
    pub fn new(domain: Domain<'_>, weights: EdgeWeights, lambda: f64) -> Self {
        match domain {
            Domain::Vertices(mesh) => Self::of_vertices(mesh, weights, lambda),
            Domain::Weighted(..) | Domain::Faces(_) => {
                let weights = |j| exact(domain.lengths(j as usize), lambda);
                Self::weighted(domain, weights)
            }
        }
    }

    fn of_vertices(mesh: &Mesh, weights: EdgeWeights, lambda: f64) -> Self {
        let lines: Vec<f64> = match weights {
            EdgeWeights::Crofton => {
                let around = Incidence::new(mesh, |j, i| (j as u32, i as u8));
                let areas = barycentric_areas(mesh);
                let total = |v: usize| {
                    let angles = around.at(v).iter().map(|&(j, i)| angles(mesh, j)[usize::from(i)]);
                    angles.sum::<f64>()
                };
                (0..mesh.vertices.len()).map(|v| 0.5 * TAU * areas[v] / total(v)).collect()
            }
            EdgeWeights::Exact | EdgeWeights::Cotangent => Vec::new(),
        };
        let face_weights = |j: u32| match weights {
            EdgeWeights::Exact => exact(lengths(mesh, j), lambda),
            EdgeWeights::Cotangent => {
                let (l, cot) = (lengths(mesh, j), cotangents(mesh, j as usize));
                [0, 1, 2].map(|k| FRAC_1_SQRT_2 * lambda * cot[k] * l[k])
            }
            EdgeWeights::Crofton => {
                let (l, angles, face) = (lengths(mesh, j), angles(mesh, j), mesh.faces[j as usize]);
                let g = [0, 1, 2].map(|i| angles[i] * lines[face[i] as usize]);
                let pair = |i: usize, j: usize| SQRT_2 * lambda * (g[i] + g[j]) / 4.0;
                [pair(1, 2) / l[0], pair(2, 0) / l[1], pair(0, 1) / l[2]]
            }
        };
        Self::weighted(mesh.into(), face_weights)
    }

    /// The graph with the given weights of the edges opposite to the corners of each face.
    fn weighted(domain: Domain<'_>, weights: impl Fn(u32) -> [f64; 3]) -> Self {
        let around = domain.around(|j, i| (j as u32, i as u8));
        let mut graph = Graph { start: vec![0], neighbors: Vec::new() };
        for v in 0..domain.unknowns() {
            let begin = graph.neighbors.len();
            for &(j, corner) in around.at(v) {
                let corners = domain.corners(j as usize);
                add_edges(corners, corner, weights(j), begin, &mut graph.neighbors);
            }
            // An edge whose dual edge has a negative length costs nothing.
            graph.neighbors[begin..].iter_mut().for_each(|(_, weight)| *weight = weight.max(0.0));
            graph.start.push(graph.neighbors.len() as u32);
        }
        graph
    }

    /// The neighbors of a vertex, and the weights of the edges to them.
    pub fn neighbors(&self, v: u32) -> &[(u32, f64)] {
        let [begin, end] = [v, v + 1].map(|v| self.start[v as usize] as usize);
        &self.neighbors[begin..end]
    }
}

/// Adds the weights of the two edges at a corner of a face to the neighbors found since `begin`.
pub fn add_edges(
    face: [u32; 3],
    corner: u8,
    weights: [f64; 3],
    begin: usize,
    neighbors: &mut Vec<(u32, f64)>,
) {
    // The edge to one of the other corners is opposite to the third.
    let [i, k] = [1, 2].map(|step| (usize::from(corner) + step) % 3);
    for (w, weight) in [(face[i], weights[k]), (face[k], weights[i])] {
        if w == face[usize::from(corner)] {
            continue;
        }
        match neighbors[begin..].iter_mut().find(|(other, _)| *other == w) {
            Some((_, sum)) => *sum += weight,
            None => neighbors.push((w, weight)),
        }
    }
}

/// The exact weights of the edges opposite to the corners of a face with these lengths.
pub fn exact([l0, l1, l2]: [f64; 3], lambda: f64) -> [f64; 3] {
    // Rounding may violate the triangle inequality.
    [l1 + l2 - l0, l2 + l0 - l1, l0 + l1 - l2]
        .map(|twice| 0.5 * FRAC_1_SQRT_2 * lambda * twice.max(0.0))
}

/// The lengths of the edges opposite to the corners of face j.
fn lengths(mesh: &Mesh, j: u32) -> [f64; 3] {
    opposite_edges(mesh, j as usize).map(|edge| edge.norm())
}

/// The angles at the corners of face j.
fn angles(mesh: &Mesh, j: u32) -> [f64; 3] {
    cotangents(mesh, j as usize).map(|cot| 1.0_f64.atan2(cot))
}
