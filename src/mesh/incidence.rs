//! Which faces meet at a vertex.

use super::Mesh;

/// Something about each face at each vertex, in the order of the faces.
pub struct Incidence<T> {
    /// What is at vertex v is `values[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    values: Vec<T>,
}

impl<T: Copy + Default> Incidence<T> {
    /// By counting sort; `value(j, i)` is told to the vertex at corner i of face j. Panics if there are 2^32
    /// corners or more.
    pub fn new(mesh: &Mesh, value: impl Fn(usize, usize) -> T) -> Self {
        let corners = 3 * mesh.faces.len();
        assert!(u32::try_from(corners).is_ok(), "too many faces");
        // One place behind its own, so that placing the values moves every start to where it belongs.
        let mut start = vec![0; mesh.vertices.len() + 2];
        for &v in mesh.faces.as_flattened() {
            start[v as usize + 2] += 1;
        }
        for v in 2..start.len() {
            start[v] += start[v - 1];
        }
        let mut values = vec![T::default(); corners];
        for (j, face) in mesh.faces.iter().enumerate() {
            for (i, &v) in face.iter().enumerate() {
                let place = &mut start[v as usize + 1];
                values[*place as usize] = value(j, i);
                *place += 1;
            }
        }
        start.pop();
        Incidence { start, values }
    }
}

impl<T> Incidence<T> {
    pub fn vertices(&self) -> usize {
        self.start.len() - 1
    }

    #[inline(always)]
    pub fn at(&self, v: usize) -> &[T] {
        &self.values[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::zoo;

    #[test]
    fn every_corner_is_at_its_vertex() {
        for (name, mesh) in zoo() {
            let around = Incidence::new(&mesh, |j, i| (j, i));
            assert_eq!(around.vertices(), mesh.vertices.len());
            let mut count = 0;
            for v in 0..around.vertices() {
                assert!(around.at(v).is_sorted(), "{name}");
                assert!(around.at(v).iter().all(|&(j, i)| mesh.faces[j][i] as usize == v));
                count += around.at(v).len();
            }
            assert_eq!(count, 3 * mesh.faces.len(), "{name}");
        }
    }
}
