//! The quadrature of the data term and the metric of the gradient flow: full and lumped mass matrices.
//!
//! ```text
//! M_ij = int phi_i phi_j      per face  A_j / 12 (1 + delta_ij)          consistent
//! a_k  = sum_{j at k} A_j / 3                                            barycentric lumping
//! a_k  = area of the mixed Voronoi cell of x_k                           Voronoi lumping
//! ```
//!
//! Mixed cells are used because plain Voronoi areas are negative on obtuse faces: M. Meyer, M. Desbrun, P. Schröder, A.
//! H. Barr, *Discrete differential-geometry operators for triangulated 2-manifolds*, 2003.

use sprs::{CsMat, TriMat};
use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use super::Cholesky;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::{barycentric_areas, mixed_voronoi_areas};
use crate::sweep::collect;

/// How pointwise costs s are integrated to f.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Mass {
    /// Lumped: a third of the area of each face at the vertex. The default of the program.
    Barycentric,
    /// Lumped: the mixed Voronoi cell of the vertex.
    Voronoi,
    /// The full mass matrix, exact for costs that are linear on each face.
    Consistent,
}

impl Mass {
    /// The quadrature on a mesh.
    pub fn on(self, mesh: &Mesh) -> Quadrature<'_> {
        match self {
            Mass::Barycentric => Quadrature::Lumped(barycentric_areas(mesh)),
            Mass::Voronoi => Quadrature::Lumped(mixed_voronoi_areas(mesh)),
            Mass::Consistent => Quadrature::Consistent(mesh),
        }
    }

    /// int phi_k: the weight of vertex k in an integral of nodal values, V numbers in squared units of length. The row
    /// sums of the consistent matrix are the barycentric areas.
    pub fn weights(self, mesh: &Mesh) -> Vec<f64> {
        match self {
            Mass::Barycentric | Mass::Consistent => barycentric_areas(mesh),
            Mass::Voronoi => mixed_voronoi_areas(mesh),
        }
    }
}

/// M of one mesh.
pub enum Quadrature<'a> {
    /// Its diagonal.
    Lumped(Vec<f64>),
    /// Applied face by face.
    Consistent(&'a Mesh),
}

impl Quadrature<'_> {
    /// f = M s, with pointwise costs s, V rows.
    pub fn integrate<const M: usize>(&self, s: &[Row<M>]) -> Vec<Row<M>> {
        match self {
            Quadrature::Lumped(area) => collect(
                area.len(),
                #[inline(always)]
                |v| s[v] * area[v],
            ),
            Quadrature::Consistent(mesh) => {
                let mut f = vec![Row::ZERO; s.len()];
                for (j, corners) in mesh.faces.iter().enumerate() {
                    let corners = corners.map(|k| k as usize);
                    let sum = s[corners[0]] + s[corners[1]] + s[corners[2]];
                    for k in corners {
                        f[k] += (sum + s[k]) * (mesh.face_area(j) / 12.0);
                    }
                }
                f
            }
        }
    }
}

/// The consistent mass matrix, V x V, symmetric; rows of unreferenced vertices are empty.
pub fn consistent_matrix(mesh: &Mesh) -> CsMat<f64> {
    let mut m = TriMat::new((mesh.vertices.len(), mesh.vertices.len()));
    for (j, corners) in mesh.faces.iter().enumerate() {
        let corners = corners.map(|k| k as usize);
        for a in corners {
            for b in corners {
                let share = if a == b { 2.0 } else { 1.0 };
                m.add_triplet(a, b, share * mesh.face_area(j) / 12.0);
            }
        }
    }
    m.to_csr()
}

/// M^-1, factored once. At vertices without area, on which nothing depends, the diagonal of M is set to 1.
pub(crate) fn consistent_inverse(mesh: &Mesh) -> Cholesky {
    let m = consistent_matrix(mesh);
    let mut padded = TriMat::new(m.shape());
    for (row, values) in m.outer_iterator().enumerate() {
        if values.nnz() == 0 {
            padded.add_triplet(row, row, 1.0);
        }
        values.iter().for_each(|(col, &value)| padded.add_triplet(row, col, value));
    }
    Cholesky::new(&padded.to_csr()).expect("masses are positive definite")
}
