//! Triangle meshes: a polyhedral surface X with vertices x_k and faces S_j.
//!
//! All triangle meshes are legal: with boundaries, several components, flipped faces, non-manifold edges, unreferenced
//! vertices. Operators only need every face to have an area, see [`Mesh::without_degenerate_faces`].

pub mod charts;
pub mod coarsen;
pub mod contrast;
pub mod curvature;
pub(crate) mod disjoint_sets;
pub mod distance;
pub mod dual;
pub(crate) mod extent;
pub mod geometry;
pub(crate) mod incidence;
pub mod io;
mod materials;
mod normalize;
pub mod order;
pub mod orient;
mod resolution;
pub mod shapes;
pub(crate) mod sides;
mod source;
mod split;
mod statistics;
mod subdivide;
mod texels;
pub(crate) mod tree;
mod triangle;
pub mod weld;

use std::borrow::Cow;

use nalgebra::{Point3, Vector3};

use crate::sweep;

pub use extent::BoundingBox;
pub(crate) use incidence::Incidence;
pub use materials::{Image, Material, Materials, Placement, is_position};
pub use normalize::Normalize;
pub use resolution::resolution;
pub use shapes::Shape;
pub use source::{Source, source};
pub use split::Split;
pub use statistics::Statistics;
pub use texels::TooFine;
pub use weld::Weld;

/// A triangle mesh, with the colors, texture coordinates and materials of its file.
///
/// Vertices and faces are in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// x_k, V points, in the units of the file.
    pub vertices: Vec<Point3<f64>>,
    /// F triples of vertex indices, each below V.
    pub faces: Vec<[u32; 3]>,
    /// RGB in [0, 1] per vertex, if the file has it; NaN where it has none.
    pub colors: Option<Vec<[f64; 3]>>,
    /// RGB in [0, 1] per face, if the file has it; NaN where it has none.
    pub face_colors: Option<Vec<[f64; 3]>>,
    /// Texture coordinates per face corner (so that seams split no vertex), v upwards, if the file has them; NaN
    /// at the corners that have none.
    pub uv: Option<Vec<[[f64; 2]; 3]>>,
    /// The materials of the faces, if the file has any.
    pub materials: Option<Materials>,
}

impl Mesh {
    /// A mesh without colors, texture coordinates and materials. Panics if a face refers to a vertex that does not
    /// exist.
    pub fn new(vertices: Vec<Point3<f64>>, faces: Vec<[u32; 3]>) -> Self {
        assert!(faces.iter().flatten().all(|&k| (k as usize) < vertices.len()));
        Mesh { vertices, faces, ..Mesh::default() }
    }

    /// The corners x_{j,1}, x_{j,2}, x_{j,3} of face j.
    #[inline(always)]
    pub fn corners(&self, j: usize) -> [Point3<f64>; 3] {
        self.faces[j].map(|k| self.vertices[k as usize])
    }

    /// The area vector of face j: its length is A_j, its direction the normal.
    #[inline(always)]
    pub fn area_vector(&self, j: usize) -> Vector3<f64> {
        let [x1, x2, x3] = self.corners(j);
        0.5 * (x2 - x1).cross(&(x3 - x1))
    }

    /// A_j, in squared units of the mesh.
    #[inline(always)]
    pub fn face_area(&self, j: usize) -> f64 {
        self.area_vector(j).norm()
    }

    /// Sum of A_j, in squared units of the mesh.
    pub fn area(&self) -> f64 {
        sweep::sum(
            self.faces.len(),
            #[inline(always)]
            |j| self.face_area(j),
        )
    }

    /// Whether face j has no area: a repeated corner, or an area within the rounding error of its own edges.
    #[inline(always)]
    pub fn is_degenerate(&self, j: usize) -> bool {
        let [x1, x2, x3] = self.corners(j);
        let longest =
            [x2 - x1, x3 - x2, x1 - x3].iter().map(Vector3::norm_squared).fold(0.0, f64::max);
        let area = self.face_area(j);
        !(area.is_normal() && area > 4.0 * f64::EPSILON * longest)
    }

    /// The mesh without its degenerate faces, and the number of these. The vertices are kept.
    pub fn without_degenerate_faces(&self) -> (Cow<'_, Self>, usize) {
        let keep = sweep::collect(
            self.faces.len(),
            #[inline(always)]
            |j| !self.is_degenerate(j),
        );
        let dropped = keep.iter().filter(|&&kept| !kept).count();
        if dropped == 0 {
            return (Cow::Borrowed(self), 0);
        }
        let mut mesh = self.clone();
        mesh.retain_faces(&keep);
        (Cow::Owned(mesh), dropped)
    }

    /// Keeps the marked faces with their colors, texture coordinates and materials. The vertices are kept.
    pub fn retain_faces(&mut self, keep: &[bool]) {
        fn retain<T>(keep: &[bool], faces: &mut Vec<T>) {
            let mut kept = keep.iter();
            faces.retain(|_| *kept.next().unwrap());
        }
        assert_eq!(keep.len(), self.faces.len());
        retain(keep, &mut self.faces);
        self.face_colors.iter_mut().for_each(|colors| retain(keep, colors));
        self.uv.iter_mut().for_each(|uv| retain(keep, uv));
        self.materials.iter_mut().for_each(|materials| retain(keep, &mut materials.of_faces));
    }

    /// The mesh with every coordinate multiplied by c. The energies then relate as lambda -> lambda / c.
    pub fn scaled(mut self, c: f64) -> Self {
        for x in &mut self.vertices {
            *x *= c;
        }
        self
    }
}
