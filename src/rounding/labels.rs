//! Labels and their energy, which is local.
//!
//! ```text
//! R(labels) = sum_v f_v,label(v) + lambda sum_j n_j
//! n_j = |(K U)_j| for one-hot U:   l_k / sqrt(2)                       corner k differs from the two others
//!                                  sqrt(l_1^2 + l_2^2 + l_3^2) / 2     three different labels, in the relaxation of the paper
//!                                  (l_1 + l_2 + l_3) / (2 sqrt(2))     the same, of regions taken separately
//!                                  (d_1 + d_2 + d_3) / sqrt(2)         the same, of the envelope
//!                                  see `relaxation/transport.rs`       the same, of a metric on the labels
//! ```
//!
//! l_i is the length of the edge opposite to corner i, and d_i the distance of corner i from the Fermat point. The first
//! case is a cut of a graph whose edge between the corners i and j of a face, opposite to corner k, weighs
//! lambda (l_i + l_j - l_k) / (2 sqrt(2)) (`graph.rs`). So is the third; the second costs 1 to 1.2247 times less, and the
//! last 1 to 1.1547 times more. With a metric, the first case and the edges of the graph cost d(a, b) times as much.

use std::f64::consts::FRAC_1_SQRT_2;

use super::graph::{add_edges, exact};
use crate::domain::Domain;
use crate::mesh::incidence::Incidence;
use crate::problem::FORBIDDEN_COST;
use crate::relaxation::{Relaxation, transport};

/// One label per vertex, for given costs; on faces, "vertices" are faces and "faces" are edges, see `domain.rs`.
pub struct Labels<'a> {
    domain: Domain<'a>,
    /// The faces around each vertex.
    around: Incidence<u32>,
    /// f, rows of `length` numbers of which the first m count.
    costs: &'a [f64],
    length: usize,
    pub m: usize,
    lambda: f64,
    relaxation: Relaxation,
    pub labels: Vec<u8>,
}

/// What labels cost, in addition to their costs at vertices.
#[derive(Clone, Copy)]
pub struct Cuts {
    pub lambda: f64,
    pub relaxation: Relaxation,
}

impl<'a> Labels<'a> {
    pub fn new(
        domain: Domain<'a>,
        costs: &'a [f64],
        m: usize,
        cuts: Cuts,
        labels: Vec<u8>,
    ) -> Self {
        let Cuts { lambda, relaxation } = cuts;
        let length = costs.len() / labels.len();
        let around = domain.around(|j, _| j as u32);
        Labels { domain, around, costs, length, m, lambda, relaxation, labels }
    }

    pub fn domain(&self) -> Domain<'a> {
        self.domain
    }

    pub fn vertices(&self) -> usize {
        self.labels.len()
    }

    pub fn faces_at(&self, v: usize) -> &[u32] {
        self.around.at(v)
    }

    pub fn face(&self, j: u32) -> [u32; 3] {
        self.domain.corners(j as usize)
    }

    /// f_vp.
    pub fn cost(&self, v: usize, p: u8) -> f64 {
        self.costs[v * self.length + usize::from(p)]
    }

    pub fn is_allowed(&self, v: usize, p: u8) -> bool {
        self.cost(v, p) != FORBIDDEN_COST
    }

    /// lambda n_j for given labels of the corners.
    pub fn face_cost(&self, j: u32, labels: [u8; 3]) -> f64 {
        let [a, b, c] = labels;
        if a == b && b == c {
            return 0.0;
        }
        let l = self.domain.lengths(j as usize);
        let n = if b == c {
            self.distance(a, b) * l[0] * FRAC_1_SQRT_2
        } else if a == c {
            self.distance(b, a) * l[1] * FRAC_1_SQRT_2
        } else if a == b {
            self.distance(c, a) * l[2] * FRAC_1_SQRT_2
        } else {
            match self.relaxation {
                Relaxation::Frobenius => 0.5 * l.iter().map(|l| l * l).sum::<f64>().sqrt(),
                Relaxation::Separate => 0.5 * FRAC_1_SQRT_2 * l.iter().sum::<f64>(),
                Relaxation::Envelope => {
                    FRAC_1_SQRT_2 * steiner_length(l, self.domain.triangle_area(j as usize))
                }
                Relaxation::Metric(metric) => {
                    FRAC_1_SQRT_2 * transport::of_regions(&labels, &closed(l), metric)
                }
            }
        };
        self.lambda * n
    }

    /// d(a, b).
    pub fn distance(&self, a: u8, b: u8) -> f64 {
        self.relaxation.label_metric().distance(a.into(), b.into())
    }

    pub fn face_labels(&self, j: u32) -> [u8; 3] {
        self.face(j).map(|v| self.labels[v as usize])
    }

    /// Whether each vertex is in a face with different labels.
    pub fn at_cuts(&self) -> Vec<bool> {
        let mut is_at_cut = vec![false; self.vertices()];
        for face in (0..self.domain.terms() as u32).map(|j| self.face(j)) {
            let [a, b, c] = face.map(|v| self.labels[v as usize]);
            if a != b || b != c {
                face.iter().for_each(|&v| is_at_cut[v as usize] = true);
            }
        }
        is_at_cut
    }

    /// Appends the neighbors of a vertex and the weights of the edges to them, in the order of the faces.
    pub fn add_neighbors(&self, v: usize, found: &mut Vec<(u32, f64)>) {
        let begin = found.len();
        for &j in self.faces_at(v) {
            let face = self.face(j);
            let corner = (0..3).find(|&i| face[usize::from(i)] as usize == v);
            let corner = corner.expect("the face is at v");
            let weights = exact(self.domain.lengths(j as usize), self.lambda);
            add_edges(face, corner, weights, begin, found);
        }
    }

    /// R after vertices change to label p, minus R, and a bound of its rounding error. `is_changed` tells which vertices
    /// these are.
    pub fn change(&self, changed: &[u32], p: u8, is_changed: &dyn Fn(u32) -> bool) -> [f64; 2] {
        let (mut sum, mut size) = (0.0, 0.0);
        let mut add = |new: f64, old: f64| {
            sum += new - old;
            size += new.abs() + old.abs();
        };
        for &v in changed {
            let v_index = v as usize;
            add(self.cost(v_index, p), self.cost(v_index, self.labels[v_index]));
            for &j in self.faces_at(v_index) {
                let face = self.face(j);
                // Each face once, at the first of its changed corners.
                if face.iter().find(|&&w| is_changed(w)) == Some(&v) {
                    let old = self.face_labels(j);
                    let new = std::array::from_fn(|i| if is_changed(face[i]) { p } else { old[i] });
                    add(self.face_cost(j, new), self.face_cost(j, old));
                }
            }
        }
        [sum, 8.0 * f64::EPSILON * size]
    }
}

/// Three vectors of these lengths that sum to zero.
fn closed([a, b, c]: [f64; 3]) -> [[f64; 2]; 3] {
    // <x, y> for the first two, by the law of cosines.
    let along = 0.5 * (c * c - a * a - b * b) / a;
    let across = (b * b - along * along).max(0.0).sqrt();
    [[a, 0.0], [along, across], [-a - along, -across]]
}

/// The sum of the distances of the corners of a triangle from its Fermat point, which is the corner of an angle of 120 degrees
/// or more.
fn steiner_length(mut sides: [f64; 3], area: f64) -> f64 {
    sides.sort_by(f64::total_cmp);
    let [a, b, c] = sides;
    if c * c >= a * a + b * b + a * b {
        a + b
    } else {
        (0.5 * (a * a + b * b + c * c) + 2.0 * 3.0_f64.sqrt() * area).sqrt()
    }
}
