//! The vertices that a weld considers, and the number that it merges.

use crate::mesh::Mesh;

/// The number of vertices that are merged onto another.
pub fn moved(first: &[u32]) -> usize {
    (0..).zip(first).filter(|&(v, &first): &(u32, _)| v != first).count()
}

/// Whether each vertex is referenced by a face.
pub fn referenced(mesh: &Mesh) -> Vec<bool> {
    let mut referenced = vec![false; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    referenced
}
