//! Midpoint subdivision: the edges of faces are divided at their midpoints, the surface stays the same set of points.
//!
//! ```text
//!            3                    3                    3
//!          /   \                / | \                / | \
//!        6 ----- 5             /  |  \              /  |  5      new vertices 4, 5, 6 in the middle of the
//!       /  \   /  \           /   |   \            /   | / \     edges 12, 23, 31; three, one or two of them
//!     1 ---- 4 ---- 2        1 -- 4 -- 2          1 -- 4 -- 2
//! ```
//!
//! With two midpoints, the quadrilateral is divided from that of the longer edge.

use std::collections::HashMap;

use nalgebra::center;

use super::{Materials, Mesh};

/// A mesh with some of its edges divided.
pub(crate) struct Divided {
    pub mesh: Mesh,
    /// For each face the one that it is a part of.
    pub whole: Vec<u32>,
    /// The ends of the edge of each new vertex.
    pub ends: Vec<[u32; 2]>,
}

impl Mesh {
    /// The mesh with every face divided into four at the midpoints of its edges.
    ///
    /// The old vertices keep their indices; the new ones follow, in the order in which the faces reach them. An
    /// edge has one midpoint, however many faces share it. Colors and texture coordinates are interpolated
    /// linearly. Face j becomes the faces 4j to 4j+3.
    ///
    /// Panics if more than 2^32 - 1 vertices would be needed.
    pub fn subdivided(&self) -> Self {
        self.divided(|_, _| true, |_| [1.0; 3]).mesh
    }

    /// The mesh with the edges ab divided for which `divides(a, b)`, which must not depend on their order. `lengths(j)`
    /// are the lengths of the edges 12, 23, 31 of face j.
    pub(crate) fn divided(
        &self,
        divides: impl Fn(u32, u32) -> bool,
        lengths: impl Fn(usize) -> [f64; 3],
    ) -> Divided {
        let mut vertices = self.vertices.clone();
        let mut ends = Vec::new();
        let mut colors = self.colors.clone();
        let mut midpoint_of = HashMap::with_capacity(3 * self.faces.len() / 2);
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        let mut uv = self.uv.as_ref().map(|_| Vec::with_capacity(faces.capacity()));
        let mut whole = Vec::with_capacity(faces.capacity());
        for (j, &face) in self.faces.iter().enumerate() {
            let mut midpoint = |a: u32, b: u32| {
                *midpoint_of.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let k = u32::try_from(vertices.len()).expect("at most 2^32 - 1 vertices");
                    let (a, b) = (a as usize, b as usize);
                    vertices.push(center(&vertices[a], &vertices[b]));
                    ends.push([a as u32, b as u32]);
                    if let Some(colors) = &mut colors {
                        colors.push(middle(colors[a], colors[b]));
                    }
                    k
                })
            };
            let [v1, v2, v3] = face;
            let edges = [(v1, v2), (v2, v3), (v3, v1)];
            let divided = edges.map(|(a, b)| divides(a, b));
            let mut corners = [v1, v2, v3, v1, v2, v3];
            for i in (0..3).filter(|&i| divided[i]) {
                corners[3 + i] = midpoint(edges[i].0, edges[i].1);
            }
            let parts = parts(divided, lengths(j));
            faces.extend(parts.iter().map(|part| part.map(|i| corners[i])));
            whole.extend(parts.iter().map(|_| j as u32));
            if let (Some(to), Some(uv)) = (&mut uv, &self.uv) {
                let [t1, t2, t3] = uv[j];
                let corners = [t1, t2, t3, middle(t1, t2), middle(t2, t3), middle(t3, t1)];
                to.extend(parts.iter().map(|part| part.map(|i| corners[i])));
            }
        }
        fn of_parts<T: Clone>(values: &[T], whole: &[u32]) -> Vec<T> {
            whole.iter().map(|&j| values[j as usize].clone()).collect()
        }
        let face_colors = self.face_colors.as_ref().map(|colors| of_parts(colors, &whole));
        let materials = self.materials.as_ref().map(|materials| Materials {
            all: materials.all.clone(),
            of_faces: of_parts(&materials.of_faces, &whole),
        });
        let mesh = Mesh { vertices, faces, colors, face_colors, uv, materials };
        Divided { mesh, whole, ends }
    }
}

/// The parts of a face, with its corners 0, 1, 2 and the midpoints 3, 4, 5 of the edges 01, 12, 20 that are divided.
fn parts(divided: [bool; 3], lengths: [f64; 3]) -> Vec<[usize; 3]> {
    let is = |want: bool| (0..3).find(|&i| divided[i] == want).unwrap_or(0);
    match divided.iter().filter(|&&divided| divided).count() {
        0 => vec![[0, 1, 2]],
        1 => {
            let i = is(true);
            let [a, b, c] = [i, (i + 1) % 3, (i + 2) % 3];
            vec![[a, 3 + i, c], [3 + i, b, c]]
        }
        2 => {
            let a = is(false);
            let [b, c] = [(a + 1) % 3, (a + 2) % 3];
            let [on_bc, on_ca] = [3 + b, 3 + c];
            let quadrilateral = if lengths[b] >= lengths[c] {
                [[a, b, on_bc], [a, on_bc, on_ca]]
            } else {
                [[a, b, on_ca], [b, on_bc, on_ca]]
            };
            vec![[on_bc, c, on_ca], quadrilateral[0], quadrilateral[1]]
        }
        _ => vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    }
}

fn middle<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Mesh, Shape, Statistics};
    use nalgebra::Point3;

    #[test]
    fn keeps_area_and_topology() {
        let coarse = "torus:12x8".parse::<Shape>().unwrap().mesh();
        let fine = coarse.subdivided();
        let (before, after) = (Statistics::of(&coarse), Statistics::of(&fine));
        assert!((before.area - after.area).abs() < 1e-13);
        assert_eq!(after.faces, 4 * before.faces);
        assert_eq!(after.vertices, before.vertices + before.edges);
        assert_eq!(after.euler_characteristic, before.euler_characteristic);
        assert_eq!(after.inconsistent_edges, 0);
        assert_eq!(fine.vertices[..coarse.vertices.len()], coarse.vertices);
    }

    /// A linear function of the position, as color and as texture coordinates, is preserved.
    #[test]
    fn interpolates_linearly() {
        let mut mesh = "grid:3x2".parse::<Shape>().unwrap().mesh();
        let color = |x: &Point3<f64>| [x.x, x.y, 0.5 * (x.x + x.y)];
        mesh.colors = Some(mesh.vertices.iter().map(color).collect());
        let texture = |k: u32, mesh: &Mesh| {
            let x = mesh.vertices[k as usize];
            [1.0 - x.x, 2.0 * x.y]
        };
        let uv = mesh.faces.iter().map(|f| f.map(|k| texture(k, &mesh)));
        mesh.uv = Some(uv.collect());
        let fine = mesh.subdivided().subdivided();
        for (x, c) in fine.vertices.iter().zip(fine.colors.as_ref().unwrap()) {
            for (expected, actual) in color(x).iter().zip(c) {
                assert!((expected - actual).abs() < 1e-15);
            }
        }
        for (face, uv) in fine.faces.iter().zip(fine.uv.as_ref().unwrap()) {
            for (&k, t) in face.iter().zip(uv) {
                let expected = texture(k, &fine);
                assert!((expected[0] - t[0]).abs() < 1e-15 && (expected[1] - t[1]).abs() < 1e-15);
            }
        }
    }

    /// Three faces at one edge share its midpoint.
    #[test]
    fn divides_non_manifold_edges_once() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0., -1., 0.]];
        let book =
            Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]);
        let fine = book.subdivided();
        assert_eq!(fine.vertices.len(), 5 + 7);
        assert_eq!(Statistics::of(&fine).non_manifold_edges, 2);
        assert_eq!(fine.faces[0], [0, 5, 7]);
        assert_eq!(fine.faces[4], [0, 5, 9]);
    }
}
