//! The faces around each vertex.

use super::Mesh;
use crate::sweep;

/// A value for each face around each vertex, in the order of the faces.
pub struct Incidence<T> {
    /// The values at vertex v are `values[start[v]..start[v + 1]]`.
    start: Vec<u32>,
    values: Vec<T>,
}

impl<T: Copy + Default + Send> Incidence<T> {
    /// Stores `value(j, i)` at the vertex at corner i of face j, by counting sort. Panics if there are 2^32 corners or
    /// more.
    pub fn new(mesh: &Mesh, value: impl Fn(usize, usize) -> T + Sync) -> Self {
        Self::in_ranges(&sweep::ranges(mesh.vertices.len()), &mesh.faces, value)
    }

    /// The same for faces with N corners and vertices from 0 to the last of `ranges`. Every range is a task that scans
    /// all faces and takes the corners at its vertices.
    pub fn in_ranges<const N: usize>(
        ranges: &[usize],
        faces: &[[u32; N]],
        value: impl Fn(usize, usize) -> T + Sync,
    ) -> Self {
        let corners = N * faces.len();
        assert!(u32::try_from(corners).is_ok(), "too many faces");
        let mut count = vec![0_u32; ranges.last().copied().unwrap_or(0)];
        sweep::sweep_parts(&mut count, ranges, |first, count| {
            for &v in faces.as_flattened() {
                if let Some(count) = count.get_mut((v as usize).wrapping_sub(first)) {
                    *count += 1;
                }
            }
        });
        let mut start = Vec::with_capacity(count.len() + 1);
        let mut sum = 0;
        start.push(0);
        start.extend(count.iter().map(|count| {
            sum += count;
            sum
        }));
        let mut values = vec![T::default(); corners];
        let cuts: Vec<usize> = ranges.iter().map(|&v| start[v] as usize).collect();
        sweep::sweep_parts(&mut values, &cuts, |first, values| {
            if values.is_empty() {
                return;
            }
            let k = cuts.partition_point(|&cut| cut <= first) - 1;
            let range = ranges[k]..ranges[k + 1];
            let mut next = start[range.clone()].to_vec();
            for (j, face) in faces.iter().enumerate() {
                for (i, &v) in face.iter().enumerate() {
                    if let Some(next) = next.get_mut((v as usize).wrapping_sub(range.start)) {
                        values[*next as usize - first] = value(j, i);
                        *next += 1;
                    }
                }
            }
        });
        Incidence { start, values }
    }
}

impl<T> Incidence<T> {
    #[cfg(test)]
    pub fn vertices(&self) -> usize {
        self.start.len() - 1
    }

    /// The values of all vertices, one vertex after the other.
    pub fn into_values(self) -> Vec<T> {
        self.values
    }

    #[inline(always)]
    pub fn at(&self, v: usize) -> &[T] {
        &self.values[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    use crate::samples::{disjoint, shape, zoo};
    use crate::sweep::with_threads;

    #[test]
    fn every_corner_is_at_its_vertex() {
        // Long stretches without a face, at the ends and inside, for several threads.
        let mut sparse = disjoint([shape("grid:40x40"), shape("grid:3x3"), shape("torus:70x50")]);
        for (shift, at) in [(3000, 0), (5000, 3000 + 41 * 41)] {
            let none = vec![Point3::origin(); shift as usize];
            sparse.vertices.splice(at..at, none);
            sparse
                .faces
                .as_flattened_mut()
                .iter_mut()
                .for_each(|v| *v += if *v as usize >= at { shift } else { 0 });
        }
        sparse.vertices.extend(vec![Point3::origin(); 9000]);
        for threads in [1, 2, 3, 7] {
            let sparse = ("sparse", sparse.clone());
            with_threads(Some(threads), || check(zoo().into_iter().chain([sparse]))).unwrap();
        }
    }

    fn check(meshes: impl Iterator<Item = (&'static str, Mesh)>) {
        for (name, mesh) in meshes {
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
