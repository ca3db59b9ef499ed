//! K as three numbers a face, the fast form.
//!
//! With the frame of face j along its edge 12, L = |x2 - x1|, s = <x3 - x1, e1> and area A:
//!
//! ```text
//! (K u)_j = ( c1 ua, c2 ua + c3 ub ),   ua = u2 - u1, ub = u3 - u1,
//! c1 = A / L,  c2 = -s / 2,  c3 = L / 2.
//! ```
//!
//! No square root of a difference is taken, so needles do no harm (the E, F, G form of the paper's
//! equation (6) loses its sign on them).

use nalgebra::Point3;

use super::{Face, Operator};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;

pub struct Stencil {
    corners: Vec<[u32; 3]>,
    /// c1, c2, c3 of each face.
    weights: Vec<[f64; 3]>,
    /// The faces around vertex v are `incident[start[v]..start[v + 1]]`, in their order.
    start: Vec<u32>,
    incident: Vec<Incident>,
}

/// One face around a vertex, with the vertex's column of K there.
#[derive(Clone, Copy)]
struct Incident {
    face: u32,
    column: [f64; 2],
}

impl Stencil {
    /// K of a mesh. Panics if a face has no area: see [`Mesh::without_degenerate_faces`].
    pub fn new(mesh: &Mesh) -> Self {
        let weights: Vec<[f64; 3]> = (0..mesh.faces.len())
            .map(|j| {
                let weights = face_weights(mesh.corners(j));
                assert!(weights[0] > 0.0, "face {j} has no area");
                weights
            })
            .collect();

        let mut start = vec![0; mesh.vertices.len() + 1];
        for &v in mesh.faces.iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..mesh.vertices.len() {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let vacant = Incident { face: 0, column: [0.0; 2] };
        let mut incident = vec![vacant; 3 * mesh.faces.len()];
        for (j, corners) in mesh.faces.iter().enumerate() {
            for (&v, column) in corners.iter().zip(columns(weights[j])) {
                let place = &mut next[v as usize];
                incident[*place as usize] = Incident { face: j as u32, column };
                *place += 1;
            }
        }
        Stencil { corners: mesh.faces.clone(), weights, start, incident }
    }
}

impl Stencil {
    /// The three vertices of each face.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// c1, c2, c3 of each face.
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }
}

fn face_weights([x1, x2, x3]: [Point3<f64>; 3]) -> [f64; 3] {
    let (e12, e13) = (x2 - x1, x3 - x1);
    let length = e12.norm();
    let area = 0.5 * e12.cross(&e13).norm();
    [area / length, -0.5 * e13.dot(&e12) / length, 0.5 * length]
}

fn columns([c1, c2, c3]: [f64; 3]) -> [[f64; 2]; 3] {
    [[-c1, -c2 - c3], [c1, c2], [0.0, c3]]
}

impl Operator for Stencil {
    fn faces(&self) -> usize {
        self.corners.len()
    }

    fn vertices(&self) -> usize {
        self.start.len() - 1
    }

    fn area(&self, j: usize) -> f64 {
        let [c1, _, c3] = self.weights[j];
        2.0 * c1 * c3
    }

    fn stencil(&self) -> Option<&Stencil> {
        Some(self)
    }

    fn face(&self, j: usize) -> Face {
        Face { corners: self.corners[j].map(|v| v as usize), columns: columns(self.weights[j]) }
    }

    #[inline(always)]
    fn at<const M: usize>(&self, u: &[Row<M>], j: usize) -> Tangent<M> {
        let [u1, u2, u3] = self.corners[j].map(|v| u[v as usize]);
        let [c1, c2, c3] = self.weights[j];
        let (ua, ub) = (u2 - u1, u3 - u1);
        Tangent([ua * c1, ua * c2 + ub * c3])
    }

    #[inline(always)]
    fn adjoint_at<const M: usize>(&self, q: &[Tangent<M>], v: usize) -> Row<M> {
        let around = self.start[v] as usize..self.start[v + 1] as usize;
        let mut sum = Row::ZERO;
        for &Incident { face, column } in &self.incident[around] {
            let Tangent([q1, q2]) = q[face as usize];
            sum += q1 * column[0] + q2 * column[1];
        }
        sum
    }
}
