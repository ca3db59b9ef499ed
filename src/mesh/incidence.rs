//! Which faces meet at a vertex.

use super::Mesh;

/// The corners at each vertex. Corner i of face j has the number 3 j + i, its place among the flattened faces.
pub struct Incidence {
    /// The corners at vertex v are `corners[start[v]..start[v + 1]]`, in their order.
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl Incidence {
    /// By counting sort. Panics if there are 2^32 corners or more.
    pub fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.faces.as_flattened();
        assert!(u32::try_from(vertices.len()).is_ok(), "too many faces");
        // One place behind its own, so that placing the corners moves every start to where it belongs.
        let mut start = vec![0; mesh.vertices.len() + 2];
        for &v in vertices {
            start[v as usize + 2] += 1;
        }
        for v in 2..start.len() {
            start[v] += start[v - 1];
        }
        let mut corners = vec![0; vertices.len()];
        for (corner, &v) in vertices.iter().enumerate() {
            let place = &mut start[v as usize + 1];
            corners[*place as usize] = corner as u32;
            *place += 1;
        }
        start.pop();
        Incidence { start, corners }
    }

    pub fn vertices(&self) -> usize {
        self.start.len() - 1
    }

    /// The numbers of the corners at a vertex, in ascending order.
    #[inline(always)]
    pub fn at(&self, v: usize) -> &[u32] {
        &self.corners[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::zoo;

    #[test]
    fn every_corner_is_at_its_vertex() {
        for (name, mesh) in zoo() {
            let around = Incidence::new(&mesh);
            assert_eq!(around.vertices(), mesh.vertices.len());
            let mut count = 0;
            for v in 0..around.vertices() {
                assert!(around.at(v).is_sorted(), "{name}");
                let flat = mesh.faces.as_flattened();
                assert!(around.at(v).iter().all(|&corner| flat[corner as usize] as usize == v));
                count += around.at(v).len();
            }
            assert_eq!(count, 3 * mesh.faces.len(), "{name}");
        }
    }
}
