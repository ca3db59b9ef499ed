//! Statistics of a mesh: sizes, topology, defects.
//!
//! The topology is that of the simplicial complex of the proper faces, those with three different corners: its vertices
//! are their corners, its edges their sides, and chi = V - E + F.

use serde::Serialize;

use super::Mesh;
use super::disjoint_sets::DisjointSets;
use super::extent::{BoundingBox, bounding_box, components};
use super::weld::{coincident, nearly_coincident};

/// The numbers that `meshseg mesh info` prints. Sides, edges and components are those of proper faces, see above.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// V, including unreferenced vertices.
    pub vertices: usize,
    /// F, including degenerate and duplicate faces.
    pub faces: usize,
    /// Sum of A_j, in squared units of the mesh.
    pub area: f64,
    /// Different sides of proper faces.
    pub edges: usize,
    /// Edges with exactly one proper face.
    pub boundary_edges: usize,
    /// Connected components of the graph of boundary edges: closed curves if the mesh is a manifold. Curves that touch
    /// at a vertex count as one.
    pub boundary_loops: usize,
    /// Components of the proper faces, connected through shared vertices.
    pub components: usize,
    /// chi = V - E + F of the proper faces with their vertices and edges.
    pub euler_characteristic: i64,
    /// Edges with more than two proper faces.
    pub non_manifold_edges: usize,
    /// Edges with two proper faces that traverse it in the same direction, so that one of them is flipped.
    pub inconsistent_edges: usize,
    /// Faces without area, see [`Mesh::is_degenerate`].
    pub degenerate_faces: usize,
    /// Faces with the same set of corners as an earlier face.
    pub duplicate_faces: usize,
    /// Vertices in no face.
    pub unreferenced_vertices: usize,
    /// Referenced vertices at the position of an earlier one.
    pub coincident_vertices: usize,
    /// Further referenced vertices within a millionth of the bounding box's diagonal of an earlier one.
    pub nearly_coincident_vertices: usize,
    /// The bounding box of all vertices; `None` if there are none.
    pub bounding_box: Option<BoundingBox>,
    /// Whether vertices have colors.
    pub has_colors: bool,
    /// Whether faces have colors.
    pub has_face_colors: bool,
    /// Whether corners of faces have texture coordinates.
    pub has_uv: bool,
    /// Number of materials.
    pub materials: usize,
    /// Number of materials with an image.
    pub materials_with_images: usize,
}

impl Statistics {
    /// Computes the statistics in O(F log F) time.
    pub fn of(mesh: &Mesh) -> Self {
        let vertices = mesh.vertices.len();
        let edges = Edges::of(mesh);
        let corners = count(&marked(vertices, proper(mesh)));
        let materials = mesh.materials.as_ref().map_or(&[][..], |materials| &materials.all);
        Statistics {
            vertices,
            faces: mesh.faces.len(),
            area: mesh.area(),
            edges: edges.all,
            boundary_edges: edges.boundary,
            boundary_loops: edges.boundary_loops,
            components: components(mesh),
            euler_characteristic: corners as i64 - edges.all as i64 + proper(mesh).count() as i64,
            non_manifold_edges: edges.non_manifold,
            inconsistent_edges: edges.inconsistent,
            degenerate_faces: (0..mesh.faces.len()).filter(|&j| mesh.is_degenerate(j)).count(),
            duplicate_faces: duplicates(&mesh.faces),
            unreferenced_vertices: vertices - count(&marked(vertices, mesh.faces.iter())),
            coincident_vertices: coincident(mesh),
            nearly_coincident_vertices: nearly_coincident(mesh).0,
            bounding_box: bounding_box(mesh),
            has_colors: mesh.colors.is_some(),
            has_face_colors: mesh.face_colors.is_some(),
            has_uv: mesh.uv.is_some(),
            materials: materials.len(),
            materials_with_images: materials.iter().filter(|m| m.image.is_some()).count(),
        }
    }
}

/// The faces with three different corners.
fn proper(mesh: &Mesh) -> impl Iterator<Item = &[u32; 3]> {
    mesh.faces.iter().filter(|[a, b, c]| a != b && b != c && c != a)
}

/// Numbers of edges of each kind.
#[derive(Default)]
struct Edges {
    all: usize,
    boundary: usize,
    boundary_loops: usize,
    non_manifold: usize,
    inconsistent: usize,
}

impl Edges {
    fn of(mesh: &Mesh) -> Self {
        // Sides as (smaller end, larger end, whether the face runs from the larger to the smaller).
        let mut sides: Vec<(u32, u32, bool)> = proper(mesh)
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b), a > b))
            .collect();
        sides.sort_unstable();

        let mut edges = Edges::default();
        let mut boundary_joined = DisjointSets::new(mesh.vertices.len());
        let mut on_boundary = vec![false; mesh.vertices.len()];
        for edge in sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
            let (a, b, downwards) = edge[0];
            edges.all += 1;
            match edge.len() {
                1 => {
                    edges.boundary += 1;
                    boundary_joined.join(a, b);
                    on_boundary[a as usize] = true;
                    on_boundary[b as usize] = true;
                }
                2 => edges.inconsistent += usize::from(edge[1].2 == downwards),
                _ => edges.non_manifold += 1,
            }
        }
        edges.boundary_loops = boundary_joined.count(&on_boundary);
        edges
    }
}

/// Which vertices are corners of the faces.
fn marked<'a>(vertices: usize, faces: impl Iterator<Item = &'a [u32; 3]>) -> Vec<bool> {
    let mut marked = vec![false; vertices];
    faces.flatten().for_each(|&k| marked[k as usize] = true);
    marked
}

/// The number of faces with the corners of an earlier one.
fn duplicates(faces: &[[u32; 3]]) -> usize {
    let mut corner_sets = faces.to_vec();
    corner_sets.iter_mut().for_each(|face| face.sort_unstable());
    corner_sets.sort_unstable();
    corner_sets.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

fn count(marked: &[bool]) -> usize {
    marked.iter().filter(|&&marked| marked).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Shape;
    use nalgebra::Point3;

    fn mesh(vertices: usize, faces: &[[u32; 3]]) -> Mesh {
        // No three points of a moment curve are collinear.
        let points = (0..vertices).map(|k| {
            let t = k as f64;
            Point3::new(t, t * t, t * t * t)
        });
        Mesh::new(points.collect(), faces.to_vec())
    }

    #[test]
    fn torus_is_closed_with_euler_characteristic_0() {
        let s = Statistics::of(&Shape::Torus { nu: 20, nv: 11 }.mesh());
        assert_eq!((s.vertices, s.faces, s.edges), (220, 440, 660));
        assert_eq!((s.euler_characteristic, s.components), (0, 1));
        assert_eq!((s.boundary_edges, s.boundary_loops), (0, 0));
        assert_eq!((s.inconsistent_edges, s.non_manifold_edges), (0, 0));
        assert_eq!((s.degenerate_faces, s.duplicate_faces), (0, 0));
    }

    #[test]
    fn grid_has_one_boundary_loop() {
        let s = Statistics::of(&Shape::Grid { nx: 7, ny: 4 }.mesh());
        assert_eq!((s.boundary_edges, s.boundary_loops), (22, 1));
        assert_eq!((s.euler_characteristic, s.inconsistent_edges), (1, 0));
        let expected = BoundingBox { min: [0.0; 3], max: [1.0, 4.0 / 7.0, 0.0] };
        assert_eq!(s.bounding_box, Some(expected));
    }

    /// Every hole that does not touch another decreases chi by one and adds a loop.
    #[test]
    fn each_hole_is_a_boundary_loop() {
        let mut sphere = Shape::Sphere { level: 3 }.mesh();
        for (holes, j) in [0, 500, 900].into_iter().enumerate() {
            sphere.faces.remove(j);
            let s = Statistics::of(&sphere);
            assert_eq!(s.boundary_loops, holes + 1);
            assert_eq!(s.euler_characteristic, 1 - holes as i64);
        }
    }

    #[test]
    fn flipped_face_is_inconsistent_with_its_three_neighbors() {
        let mut sphere = Shape::Sphere { level: 1 }.mesh();
        sphere.faces[17].swap(0, 1);
        assert_eq!(Statistics::of(&sphere).inconsistent_edges, 3);
    }

    #[test]
    fn components_share_vertices() {
        // A bow tie is one component; vertex 8 is in no component.
        let s = Statistics::of(&mesh(9, &[[0, 1, 2], [2, 3, 4], [5, 6, 7]]));
        assert_eq!(s.components, 2);
        assert_eq!(s.unreferenced_vertices, 1);
        assert_eq!(s.boundary_loops, 2);
        assert_eq!(s.euler_characteristic, 2);
    }

    #[test]
    fn defects_are_counted() {
        let s = Statistics::of(&mesh(6, &[[0, 1, 2], [1, 2, 0], [2, 1, 0], [3, 3, 4], [5, 5, 5]]));
        assert_eq!(s.duplicate_faces, 2);
        assert_eq!(s.degenerate_faces, 2);
        assert_eq!(s.non_manifold_edges, 3);
        assert_eq!((s.edges, s.components, s.unreferenced_vertices), (3, 1, 0));
    }

    #[test]
    fn empty_mesh() {
        let s = Statistics::of(&Mesh::default());
        assert_eq!((s.vertices, s.components, s.area), (0, 0, 0.0));
        assert_eq!(s.bounding_box, None);
    }
}
