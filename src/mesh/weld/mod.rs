//! Vertices that lie in one place but are not shared, as exporters leave them along the seams of texture charts or
//! at every corner, cut a surface apart: across them there is no gradient, so that cuts are free. A weld merges
//! the vertices
//!
//! ```text
//! v ~ w   if   |x_v - x_w| <= tolerance   and whatever follows by transitivity;   tolerance 0: x_v = x_w, -0 = 0
//! ```
//!
//! onto the first of each class. Vertices in no face stay apart. Which vertices these are say `equal` and `near`, what
//! becomes of their values `means`, what a mesh with or without them suffers from `seams` and `sheets`.

mod equal;
mod means;
mod merged;
mod near;
mod seams;
mod sheets;
mod table;
#[cfg(test)]
mod tests;

use self::equal::firsts;
use self::merged::{moved, referenced};
use self::near::near;
use self::sheets::new_non_manifold_edges;
use super::Mesh;
use super::geometry::barycentric_areas;
use crate::sweep;

pub use self::seams::{coincident, free_cuts, is_shattered, mending_tolerance, nearly_coincident};

/// A mesh whose coincident vertices are merged, and where each vertex went.
#[derive(Clone, Debug, PartialEq)]
pub struct Weld {
    /// For each vertex of the mesh as it was, its number in the welded one.
    pub of: Vec<u32>,
    /// Vertices in the order of their first appearance, with the mean colors of what was merged; faces as they
    /// were, with all that belongs to them. Faces that collapsed are still there.
    pub mesh: Mesh,
    /// How many vertices are gone.
    pub merged: usize,
    /// How many vertices these were merged onto.
    pub onto: usize,
    /// Edges with more than two faces, no side of which had more before: sheets that lie on each other or touch.
    pub new_non_manifold_edges: usize,
    /// The barycentric cells of the mesh as it was.
    areas: Vec<f64>,
}

impl Weld {
    /// Merges the vertices at equal positions; none if there are no two.
    pub fn exact(mesh: &Mesh) -> Option<Self> {
        firsts(mesh).map(|first| Weld::onto(mesh, &first))
    }

    /// Merges the vertices within a tolerance, a length; none if there are no two. Panics if it is negative or
    /// not finite.
    pub fn within(mesh: &Mesh, tolerance: f64) -> Option<Self> {
        assert!(tolerance >= 0.0 && tolerance.is_finite());
        let exact = firsts(mesh);
        if tolerance == 0.0 {
            return exact.map(|first| Weld::onto(mesh, &first));
        }
        let first = near(mesh, exact, tolerance);
        (moved(&first) > 0).then(|| Weld::onto(mesh, &first))
    }

    /// Merges every vertex onto the one that it has in `first`, which comes no later and stays itself.
    fn onto(mesh: &Mesh, first: &[u32]) -> Self {
        let mut of = Vec::with_capacity(first.len());
        let mut vertices = Vec::new();
        let mut merged_onto = vec![false; first.len()];
        for (v, &first) in first.iter().enumerate() {
            if first as usize == v {
                of.push(vertices.len() as u32);
                vertices.push(mesh.vertices[v]);
            } else {
                of.push(of[first as usize]);
                merged_onto[first as usize] = true;
            }
        }
        let faces = sweep::collect(
            mesh.faces.len(),
            #[inline(always)]
            |j| mesh.faces[j].map(|v| of[v as usize]),
        );
        let mut weld = Weld {
            merged: of.len() - vertices.len(),
            onto: merged_onto.iter().filter(|&&onto| onto).count(),
            new_non_manifold_edges: new_non_manifold_edges(mesh, &of, first, &merged_onto),
            areas: barycentric_areas(mesh),
            mesh: Mesh {
                vertices,
                faces,
                colors: None,
                face_colors: mesh.face_colors.clone(),
                uv: mesh.uv.clone(),
                materials: mesh.materials.clone(),
            },
            of,
        };
        weld.mesh.colors = mesh.colors.as_ref().map(|colors| {
            let means = weld.means(colors.as_flattened(), 3);
            means.as_chunks::<3>().0.to_vec()
        });
        weld
    }
}
