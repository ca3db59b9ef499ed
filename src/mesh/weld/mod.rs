//! Welding of coincident vertices. Exporters often duplicate vertices along the seams of texture charts or at every
//! corner. This cuts the surface: there is no gradient across such seams, so that cuts along them are free. A weld
//! merges the vertices
//!
//! ```text
//! v ~ w   if   |x_v - x_w| <= tolerance   and whatever follows by transitivity;   tolerance 0: x_v = x_w, -0 = 0
//! ```
//!
//! onto the first of each class. Unreferenced vertices are not merged. `equal` and `near` find the vertices, `means`
//! averages their values, `seams` and `sheets` detect defects of the mesh before and after a weld.

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

/// A mesh whose coincident vertices are merged, and the map from the original vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Weld {
    /// For each vertex of the original mesh, its index in the welded one.
    pub of: Vec<u32>,
    /// Vertices in the order of their first appearance, with the mean colors of merged vertices; all faces with their
    /// colors, texture coordinates and materials, including those that collapsed.
    pub mesh: Mesh,
    /// The number of vertices that were merged onto others.
    pub merged: usize,
    /// The number of vertices that they were merged onto.
    pub onto: usize,
    /// Edges that have more than two faces only since the weld: sheets that lie on each other or touch.
    pub new_non_manifold_edges: usize,
    /// Areas of the barycentric cells of the original mesh.
    areas: Vec<f64>,
}

impl Weld {
    /// Merges the vertices at equal positions; `None` if no two coincide.
    pub fn exact(mesh: &Mesh) -> Option<Self> {
        firsts(mesh).map(|first| Weld::onto(mesh, &first))
    }

    /// Merges the vertices within a tolerance, a length; `None` if there are no such two. Panics if the tolerance is
    /// negative or not finite.
    pub fn within(mesh: &Mesh, tolerance: f64) -> Option<Self> {
        assert!(tolerance >= 0.0 && tolerance.is_finite());
        let exact = firsts(mesh);
        if tolerance == 0.0 {
            return exact.map(|first| Weld::onto(mesh, &first));
        }
        let first = near(mesh, exact, tolerance);
        (moved(&first) > 0).then(|| Weld::onto(mesh, &first))
    }

    /// Merges every vertex v onto `first[v]`, which is not after v and is merged onto itself.
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
