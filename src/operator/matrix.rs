//! K as a sparse matrix, 2F x V with rows 2j and 2j + 1 for face j, or 2E x F for labels of faces: the reference
//! implementation.
//!
//! It is assembled from the gradient in space: A_j grad phi_k = n x e_k / 2, with the unit normal n and the edge e_k
//! opposite to corner k, expressed in the frame (e12 / |e12|, n x e12 / |e12|). Across an edge between two faces, row 2e
//! is the jump w_e (u_k - u_j), and row 2e + 1 is empty.

use sprs::{CsMat, TriMat};

use super::{Adjoint, Face, Operator};
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::dual::Dual;

/// K and K^T of one mesh in compressed rows, with the areas of the faces.
pub struct Matrix {
    corners: Vec<[u32; 3]>,
    areas: Vec<f64>,
    k: CsMat<f64>,
    k_transposed: CsMat<f64>,
}

impl Matrix {
    /// K of a mesh. Panics if a face has no area: see [`Mesh::without_degenerate_faces`].
    pub fn new(mesh: &Mesh) -> Self {
        let shape = (2 * mesh.faces.len(), mesh.vertices.len());
        let mut k = TriMat::with_capacity(shape, 6 * mesh.faces.len());
        for (j, corners) in mesh.faces.iter().enumerate() {
            let x = mesh.corners(j);
            assert!(mesh.face_area(j) > 0.0, "face {j} has no area");
            let normal = mesh.area_vector(j).normalize();
            let first = (x[1] - x[0]).normalize();
            let second = normal.cross(&first);
            for i in 0..3 {
                let opposite = x[(i + 2) % 3] - x[(i + 1) % 3];
                let gradient = 0.5 * normal.cross(&opposite);
                k.add_triplet(2 * j, corners[i] as usize, gradient.dot(&first));
                k.add_triplet(2 * j + 1, corners[i] as usize, gradient.dot(&second));
            }
        }
        let areas = (0..mesh.faces.len()).map(|j| mesh.face_area(j)).collect();
        Self::of(mesh.faces.clone(), areas, k)
    }

    /// K on the faces of a mesh, with jumps across edges in place of gradients.
    pub fn across_edges(dual: &Dual) -> Self {
        let shape = (2 * dual.pairs.len(), dual.areas.len());
        let mut k = TriMat::with_capacity(shape, 2 * dual.pairs.len());
        for (e, (pair, &w)) in dual.pairs.iter().zip(&dual.weights).enumerate() {
            k.add_triplet(2 * e, pair[0] as usize, -w);
            k.add_triplet(2 * e, pair[1] as usize, w);
        }
        Self::of(dual.corners(), dual.areas_at_pairs(), k)
    }

    fn of(corners: Vec<[u32; 3]>, areas: Vec<f64>, k: TriMat<f64>) -> Self {
        let k: CsMat<f64> = k.to_csr();
        Matrix { corners, areas, k_transposed: k.transpose_view().to_csr(), k }
    }

    /// The matrix itself, 2F x V in compressed rows, or 2E x F across edges.
    pub fn csr(&self) -> &CsMat<f64> {
        &self.k
    }

    /// The stiffness matrix of the cotangent Laplacian, K^T A^-1 K: V x V, symmetric, positive semidefinite.
    pub fn laplacian(&self) -> CsMat<f64> {
        let mut scaled = self.k.clone();
        for (row, mut entries) in scaled.outer_iterator_mut().enumerate() {
            for (_, value) in entries.iter_mut() {
                *value /= self.areas[row / 2];
            }
        }
        (&self.k_transposed * &scaled).to_csr()
    }
}

/// The product of one compressed row with a matrix given by its rows.
#[inline(always)]
fn row_times<const M: usize>(
    matrix: &CsMat<f64>,
    row: usize,
    column: impl Fn(usize) -> Row<M>,
) -> Row<M> {
    let range = matrix.indptr().outer_inds_sz(row);
    let mut sum = Row::ZERO;
    for (&index, &value) in matrix.indices()[range.clone()].iter().zip(&matrix.data()[range]) {
        sum += column(index) * value;
    }
    sum
}

impl Operator for Matrix {
    type Adjoint<'a> = Transposed<'a>;

    fn faces(&self) -> usize {
        self.corners.len()
    }

    fn vertices(&self) -> usize {
        self.k.cols()
    }

    fn area(&self, j: usize) -> f64 {
        self.areas[j]
    }

    fn face(&self, j: usize) -> Face {
        let corners = self.corners[j].map(|v| v as usize);
        let entry = |row, v| self.k.get(row, v).copied().unwrap_or(0.0);
        Face { corners, columns: corners.map(|v| [entry(2 * j, v), entry(2 * j + 1, v)]) }
    }

    #[inline(always)]
    fn at<const M: usize>(&self, u: &[Row<M>], j: usize) -> Tangent<M> {
        Tangent([row_times(&self.k, 2 * j, |v| u[v]), row_times(&self.k, 2 * j + 1, |v| u[v])])
    }

    fn adjoint(&self) -> Transposed<'_> {
        Transposed(&self.k_transposed)
    }
}

/// K^T in compressed rows.
#[derive(Clone, Copy)]
pub struct Transposed<'a>(&'a CsMat<f64>);

impl Adjoint for Transposed<'_> {
    #[inline(always)]
    fn at<const M: usize>(self, q: &[Tangent<M>], v: usize) -> Row<M> {
        row_times(self.0, v, |row| q[row / 2].0[row % 2])
    }
}
