//! Where labels live: at the vertices of a mesh, where U is linear on each face, or on its faces, where U is constant
//! on each face and jumps across edges.
//!
//! ```text
//!             unknowns u_k            data term                 terms of the total variation
//! vertices    one per vertex          mass matrix of the mesh   faces j:  |A_j grad_j U|
//! faces       one per face            A_j                       edges e:  w_e |u_j - u_k|,   see `mesh/dual.rs`
//! ```
//!
//! Either way K is a [`Stencil`], so that problems, solvers and certificates are the same. The cut of labels costs
//! sqrt(2) lambda times its length: a polyline through faces on vertices, a path along edges on faces. On faces every
//! term has two unknowns, for which the relaxation `separate` is exact.

use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::mesh::Mesh;
use crate::mesh::dual::Dual;
use crate::mesh::geometry::{barycentric_areas, opposite_edges};
use crate::mesh::incidence::Incidence;
use crate::operator::{Mass, Quadrature, Stencil};
use crate::relaxation::Relaxation;
use crate::sweep::{ranges, sum};

/// What has a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Element {
    /// The vertices of a mesh.
    Vertices,
    /// Its faces.
    Faces,
}

impl Element {
    /// How many of them a mesh has.
    pub fn count(self, mesh: &Mesh) -> usize {
        match self {
            Element::Vertices => mesh.vertices.len(),
            Element::Faces => mesh.faces.len(),
        }
    }

    /// The relaxation of a problem that names none: that of the paper, or the one that is exact across edges.
    pub fn relaxation(self) -> Relaxation {
        match self {
            Element::Vertices => Relaxation::Frobenius,
            Element::Faces => Relaxation::Separate,
        }
    }

    /// The noun in the singular and in the plural.
    pub fn nouns(self) -> [&'static str; 2] {
        match self {
            Element::Vertices => ["vertex", "vertices"],
            Element::Faces => ["face", "faces"],
        }
    }
}

/// The unknowns of a problem, and how they are joined.
#[derive(Clone, Copy)]
pub enum Domain<'a> {
    /// The vertices of a mesh, joined by its faces.
    Vertices(&'a Mesh),
    /// The same with a positive factor for each face, by which its term is multiplied.
    Weighted(&'a Mesh, &'a [f64]),
    /// The faces of a mesh, joined by its edges.
    Faces(&'a Dual),
}

impl<'a> From<&'a Mesh> for Domain<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        Domain::Vertices(mesh)
    }
}

impl<'a> From<&'a Dual> for Domain<'a> {
    fn from(dual: &'a Dual) -> Self {
        Domain::Faces(dual)
    }
}

impl<'a> Domain<'a> {
    /// What has a label.
    pub fn element(self) -> Element {
        match self {
            Domain::Vertices(_) | Domain::Weighted(..) => Element::Vertices,
            Domain::Faces(_) => Element::Faces,
        }
    }

    /// The number of unknowns.
    pub fn unknowns(self) -> usize {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mesh.vertices.len(),
            Domain::Faces(dual) => dual.areas.len(),
        }
    }

    /// The number of terms of the total variation.
    pub fn terms(self) -> usize {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mesh.faces.len(),
            Domain::Faces(dual) => dual.pairs.len(),
        }
    }

    /// The unknowns of term j; the second one twice if there are two.
    #[inline(always)]
    pub fn corners(self, j: usize) -> [u32; 3] {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mesh.faces[j],
            Domain::Faces(dual) => {
                let [a, b] = dual.pairs[j];
                [a, b, b]
            }
        }
    }

    /// |l_i|, twice the length of the column of K at each corner: for vertices the edges opposite to the corners.
    #[inline(always)]
    pub fn lengths(self, j: usize) -> [f64; 3] {
        match self {
            Domain::Vertices(mesh) => opposite_edges(mesh, j).map(|edge| edge.norm()),
            Domain::Weighted(mesh, w) => opposite_edges(mesh, j).map(|edge| w[j] * edge.norm()),
            Domain::Faces(dual) => [2.0 * dual.weights[j], 2.0 * dual.weights[j], 0.0],
        }
    }

    /// The area of the triangle with these sides.
    pub fn triangle_area(self, j: usize) -> f64 {
        match self {
            Domain::Vertices(mesh) => mesh.face_area(j),
            Domain::Weighted(mesh, w) => w[j] * w[j] * mesh.face_area(j),
            Domain::Faces(_) => 0.0,
        }
    }

    /// A value for each term at each unknown, from the term and the corner.
    pub fn around<T: Copy + Default + Send>(
        self,
        value: impl Fn(usize, usize) -> T + Sync,
    ) -> Incidence<T> {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => Incidence::new(mesh, value),
            Domain::Faces(dual) => {
                Incidence::in_ranges(&ranges(dual.areas.len()), &dual.pairs, value)
            }
        }
    }

    /// The weight of each unknown in an integral.
    pub fn weights(self, mass: Mass) -> Vec<f64> {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mass.weights(mesh),
            Domain::Faces(dual) => dual.areas.clone(),
        }
    }

    /// The area of the cell of each unknown.
    pub fn cell_areas(self) -> Vec<f64> {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => barycentric_areas(mesh),
            Domain::Faces(dual) => dual.areas.clone(),
        }
    }

    /// How pointwise costs are integrated. On faces all masses are the same.
    pub fn quadrature(self, mass: Mass) -> Quadrature<'a> {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mass.on(mesh),
            Domain::Faces(dual) => Quadrature::Lumped(dual.areas.clone()),
        }
    }

    /// K.
    pub fn stencil(self) -> Stencil {
        match self {
            Domain::Vertices(mesh) => Stencil::new(mesh),
            Domain::Weighted(mesh, w) => Stencil::weighted(mesh, w),
            Domain::Faces(dual) => Stencil::across_edges(dual),
        }
    }

    /// The area of the surface.
    pub fn area(self) -> f64 {
        match self {
            Domain::Vertices(mesh) | Domain::Weighted(mesh, _) => mesh.area(),
            Domain::Faces(dual) => sum(dual.areas.len(), |j| dual.areas[j]),
        }
    }
}
