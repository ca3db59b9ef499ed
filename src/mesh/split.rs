//! A mesh whose vertices are divided between the labels of their faces, so that each vertex has one label.

use super::Mesh;
use super::incidence::Incidence;

/// The divided mesh: the same faces, with corners that are vertices of one label.
pub struct Split {
    /// The mesh, without colors, texture coordinates and materials.
    pub mesh: Mesh,
    /// The vertex of the given mesh that each vertex is.
    pub of: Vec<u32>,
    /// The label of each vertex, that of its faces; 0 without faces.
    pub labels: Vec<u16>,
}

impl Mesh {
    /// Divides the vertices between the labels of the faces around them; one label per face. A vertex between n labels
    /// becomes n vertices.
    pub fn split(&self, labels: &[u16]) -> Split {
        assert_eq!(labels.len(), self.faces.len());
        let around = Incidence::new(self, |j, i| (j as u32, i as u8));
        let (mut of, mut of_vertices) = (Vec::new(), Vec::new());
        let mut faces = self.faces.clone();
        for v in 0..self.vertices.len() {
            let first = of.len();
            let mut add = |label: u16| {
                if !of_vertices[first..].contains(&label) {
                    of.push(v as u32);
                    of_vertices.push(label);
                }
            };
            around.at(v).iter().for_each(|&(j, _)| add(labels[j as usize]));
            if around.at(v).is_empty() {
                add(0);
            }
            for &(j, corner) in around.at(v) {
                let label = labels[j as usize];
                let at = of_vertices[first..].iter().position(|&p| p == label);
                let at = first + at.expect("it was added above");
                faces[j as usize][usize::from(corner)] = at as u32;
            }
        }
        let vertices = of.iter().map(|&v| self.vertices[v as usize]).collect();
        Split { mesh: Mesh::new(vertices, faces), of, labels: of_vertices }
    }
}

#[cfg(test)]
mod tests {
    use crate::samples::{rng, with_isolated_vertices, zoo};
    use rand::RngExt;

    /// The faces keep their positions, corners have the label of their face, and one label divides nothing.
    #[test]
    fn every_vertex_has_the_label_of_its_faces() {
        let mut rng = rng(1301);
        for (name, mesh) in zoo() {
            let mesh = with_isolated_vertices(mesh);
            let labels: Vec<u16> = mesh.faces.iter().map(|_| rng.random_range(0..4)).collect();
            let split = mesh.split(&labels);
            assert_eq!(split.mesh.faces.len(), mesh.faces.len());
            for (j, face) in split.mesh.faces.iter().enumerate() {
                for (i, &v) in face.iter().enumerate() {
                    assert_eq!(split.of[v as usize], mesh.faces[j][i], "{name}");
                    assert_eq!(split.labels[v as usize], labels[j], "{name}");
                }
                assert_eq!(split.mesh.corners(j), mesh.corners(j), "{name}");
            }
            let whole = mesh.split(&vec![1; mesh.faces.len()]);
            assert_eq!(whole.mesh.faces, mesh.faces);
            assert_eq!(whole.mesh.vertices, mesh.vertices);
        }
    }
}
