//! Which vertices a weld looks at, and how many it merges.

use crate::mesh::Mesh;

/// Vertices that are merged onto another.
pub fn moved(first: &[u32]) -> usize {
    (0..).zip(first).filter(|&(v, &first): &(u32, _)| v != first).count()
}

/// The vertices that faces refer to.
pub fn referenced(mesh: &Mesh) -> Vec<bool> {
    let mut referenced = vec![false; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    referenced
}
