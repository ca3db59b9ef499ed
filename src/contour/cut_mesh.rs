//! The mesh divided along the contour, so that each face has one label.

use nalgebra::Point3;

use super::cells::{Cells, SEVERAL};
use crate::mesh::Mesh;

impl Cells<'_> {
    /// The mesh with each face divided into triangles within its cells, and the region of each of its faces.
    ///
    /// The vertices of the mesh keep their indices; the crossings of the cut with edges, and the points where it branches
    /// within faces, follow. Faces on both sides of an edge share its points, so that the surface is as closed as before.
    /// The order and orientation of the faces are kept. The result has no colors, texture coordinates and materials.
    pub fn cut_mesh(&self) -> (Mesh, Vec<u8>) {
        let vertices: Vec<Point3<f64>> =
            self.mesh.vertices.iter().chain(&self.points).copied().collect();
        let (mut faces, mut labels) = (Vec::new(), Vec::new());
        let mut divided = self.divided.iter();
        for (&face, &p) in self.mesh.faces.iter().zip(&self.whole) {
            if p != SEVERAL {
                faces.push(face);
                labels.push(p);
                continue;
            }
            let divided = divided.next().expect("it has several cells");
            for cell in &divided.cells {
                let polygon = cell.corners.iter().map(|&(n, _)| divided.nodes[n].id).collect();
                triangulate(polygon, &vertices, &mut faces);
                labels.resize(faces.len(), cell.region as u8);
            }
        }
        (Mesh::new(vertices, faces), labels)
    }
}

/// Divides a convex polygon: cuts off the corner with the shortest diagonal until a triangle is left.
fn triangulate(mut polygon: Vec<u32>, vertices: &[Point3<f64>], faces: &mut Vec<[u32; 3]>) {
    while polygon.len() >= 3 {
        let count = polygon.len();
        let around = |i: usize| [(i + count - 1) % count, i, (i + 1) % count].map(|i| polygon[i]);
        let diagonal = |i: usize| {
            let [a, _, b] = around(i);
            (vertices[b as usize] - vertices[a as usize]).norm_squared()
        };
        let shorter = |best: usize, i: usize| if diagonal(i) < diagonal(best) { i } else { best };
        let ear = (1..count).fold(0, shorter);
        faces.push(around(ear));
        if count == 3 {
            break;
        }
        polygon.remove(ear);
    }
}
