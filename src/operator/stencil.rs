//! K as three numbers per face, or one per edge: the fast implementation.
//!
//! With the frame of face j along its edge 12, L = |x2 - x1|, s = <x3 - x1, e1> and area A:
//!
//! ```text
//! (K u)_j = ( c1 ua, c2 ua + c3 ub ),   ua = u2 - u1, ub = u3 - u1,
//! c1 = A / L,  c2 = -s / 2,  c3 = L / 2.
//! ```
//!
//! On the faces of a mesh instead of its vertices, K has one row per pair of faces j, k that share an edge:
//!
//! ```text
//! (K u)_e = ( w_e (u_k - u_j), 0 )     c1 = w_e, c2 = c3 = 0, the corners are j, k, k
//! ```
//!
//! No square root of a difference is taken, so needles are harmless (in the E, F, G form of the paper's equation (6),
//! rounding can make the radicand negative on them).

use std::sync::OnceLock;

use nalgebra::Point3;
use pulp::Arch;

use super::norms::{Norms, product};
use super::{Adjoint, Face, Operator};
use crate::field::{Row, Tangent};
use crate::mesh::dual::Dual;
use crate::mesh::{Incidence, Mesh};
use crate::relaxation::{DualSet, Relaxation};
use crate::sweep;

/// K of one mesh as three weights per face: the operator that solvers run on.
pub struct Stencil {
    corners: Vec<[u32; 3]>,
    vertices: usize,
    /// c1, c2, c3 of each face.
    weights: Vec<[f64; 3]>,
    /// A_j where it does not follow from the weights: with factors, and for edges a third of their two faces.
    areas: Option<Vec<f64>>,
    /// K^T, assembled on first use.
    incidence: OnceLock<ColumnsAtVertices>,
}

/// K^T of a stencil.
pub struct ColumnsAtVertices {
    /// A copy of the columns of each face: computing them from the weights would cost a sixth of a vertex sweep.
    columns: Vec<[f64; 2]>,
    /// The corners at each vertex: 3 j + i for corner i of face j, which is also the index of its column.
    around: Incidence<u32>,
}

impl Stencil {
    /// K of a mesh. Panics if a face has no area: see [`Mesh::without_degenerate_faces`].
    pub fn new(mesh: &Mesh) -> Self {
        let weights = sweep::collect(
            mesh.faces.len(),
            #[inline(always)]
            |j| face_weights(mesh.corners(j)),
        );
        let has_area = |j: usize| weights[j][0] > 0.0;
        assert!(sweep::all(weights.len(), has_area), "a face has no area");
        let corners = sweep::copy(&mesh.faces);
        let (vertices, incidence) = (mesh.vertices.len(), OnceLock::new());
        Stencil { corners, vertices, weights, areas: None, incidence }
    }

    /// K with each (K u)_j multiplied by a positive factor.
    pub fn weighted(mesh: &Mesh, factors: &[f64]) -> Self {
        let mut stencil = Stencil::new(mesh);
        let areas = sweep::collect(factors.len(), |j| stencil.area(j));
        sweep::sweep((&mut stencil.weights[..], factors), |_, (weights, w)| {
            *weights = weights.map(|c| c * w);
        });
        Stencil { areas: Some(areas), ..stencil }
    }

    /// K on the faces of a mesh, with jumps across edges in place of gradients.
    pub fn across_edges(dual: &Dual) -> Self {
        let weights = sweep::collect(dual.weights.len(), |e| [dual.weights[e], 0.0, 0.0]);
        let areas = dual.areas_at_pairs();
        let (vertices, incidence) = (dual.areas.len(), OnceLock::new());
        Stencil { corners: dual.corners(), vertices, weights, areas: Some(areas), incidence }
    }

    /// The three vertices of each face.
    pub fn corners(&self) -> &[[u32; 3]] {
        &self.corners
    }

    /// c1, c2, c3 of each face, in units of length.
    pub fn weights(&self) -> &[[f64; 3]] {
        &self.weights
    }
}

#[inline(always)]
fn face_weights([x1, x2, x3]: [Point3<f64>; 3]) -> [f64; 3] {
    let (e12, e13) = (x2 - x1, x3 - x1);
    let length = e12.norm();
    let area = 0.5 * e12.cross(&e13).norm();
    [area / length, -0.5 * e13.dot(&e12) / length, 0.5 * length]
}

#[inline(always)]
fn columns([c1, c2, c3]: [f64; 3]) -> [[f64; 2]; 3] {
    [[-c1, -c2 - c3], [c1, c2], [0.0, c3]]
}

impl Operator for Stencil {
    type Adjoint<'a> = &'a ColumnsAtVertices;

    fn faces(&self) -> usize {
        self.corners.len()
    }

    fn vertices(&self) -> usize {
        self.vertices
    }

    #[inline(always)]
    fn area(&self, j: usize) -> f64 {
        match &self.areas {
            Some(areas) => areas[j],
            None => {
                let [c1, _, c3] = self.weights[j];
                2.0 * c1 * c3
            }
        }
    }

    fn adjoint(&self) -> &ColumnsAtVertices {
        // Assembled outside of `get_or_init`: a thread that waits there for others may be given a task that requests
        // K^T again.
        if self.incidence.get().is_none() {
            let columns = sweep::collect(
                self.weights.len(),
                #[inline(always)]
                |j| columns(self.weights[j]),
            )
            .into_flattened();
            let ranges = sweep::ranges(self.vertices);
            let around = Incidence::in_ranges(&ranges, &self.corners, |j, i| (3 * j + i) as u32);
            // Another thread may have been faster, with the same result.
            let _ = self.incidence.set(ColumnsAtVertices { columns, around });
        }
        self.incidence.get().expect("it was assembled above")
    }

    #[inline(always)]
    fn face(&self, j: usize) -> Face {
        Face { corners: self.corners[j].map(|v| v as usize), columns: columns(self.weights[j]) }
    }

    #[inline(always)]
    fn at<const M: usize>(&self, u: &[Row<M>], j: usize) -> Tangent<M> {
        product(self.corners[j], self.weights[j], u)
    }

    fn norms<const M: usize>(
        &self,
        set: impl DualSet,
        u: &[Row<M>],
        first: usize,
        norms: &mut [f64],
    ) {
        let (corners, weights) = (&self.corners, &self.weights);
        match set.relaxation() {
            Relaxation::Frobenius => {
                Arch::new().dispatch(Norms::<false, M> { corners, weights, u, first, norms });
            }
            Relaxation::Separate => {
                Arch::new().dispatch(Norms::<true, M> { corners, weights, u, first, norms });
            }
            Relaxation::Envelope | Relaxation::Metric(_) => {
                for (norm, j) in norms.iter_mut().zip(first..) {
                    *norm = set.support(self.at(u, j));
                }
            }
        }
    }
}

impl Adjoint for &ColumnsAtVertices {
    #[inline(always)]
    fn at<const M: usize>(self, q: &[Tangent<M>], v: usize) -> Row<M> {
        let ColumnsAtVertices { columns, around } = self;
        let mut sum = Row::ZERO;
        for &corner in around.at(v) {
            let [a, b] = columns[corner as usize];
            let Tangent([q1, q2]) = q[corner as usize / 3];
            sum += q1 * a + q2 * b;
        }
        sum
    }
}
