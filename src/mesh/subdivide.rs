//! Midpoint subdivision: each face becomes four, the surface stays the same set of points.
//!
//! ```text
//!            3                 new vertices 4, 5, 6 in the middle of the edges 12, 23, 31;
//!          /   \               faces 1 4 6,  4 2 5,  6 5 3,  4 5 6
//!        6 ----- 5
//!       /  \   /  \
//!     1 ---- 4 ---- 2
//! ```

use std::collections::HashMap;

use nalgebra::center;

use super::{Materials, Mesh};

impl Mesh {
    /// The mesh with every face divided into four at the midpoints of its edges.
    ///
    /// The old vertices keep their indices; the new ones follow, in the order in which the faces reach them. An
    /// edge has one midpoint, however many faces share it. Colors and texture coordinates are interpolated
    /// linearly. Face j becomes the faces 4j to 4j+3.
    ///
    /// Panics if more than 2^32 - 1 vertices would be needed.
    pub fn subdivided(&self) -> Self {
        let mut vertices = self.vertices.clone();
        let mut colors = self.colors.clone();
        let mut midpoint_of = HashMap::with_capacity(3 * self.faces.len() / 2);
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        for &[v1, v2, v3] in &self.faces {
            let mut midpoint = |a: u32, b: u32| {
                *midpoint_of.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let k = u32::try_from(vertices.len()).expect("at most 2^32 - 1 vertices");
                    let (a, b) = (a as usize, b as usize);
                    vertices.push(center(&vertices[a], &vertices[b]));
                    if let Some(colors) = &mut colors {
                        colors.push(middle(colors[a], colors[b]));
                    }
                    k
                })
            };
            let (v4, v5, v6) = (midpoint(v1, v2), midpoint(v2, v3), midpoint(v3, v1));
            faces.extend([[v1, v4, v6], [v4, v2, v5], [v6, v5, v3], [v4, v5, v6]]);
        }
        let uv = self.uv.as_ref().map(|uv| {
            let divide = |&[t1, t2, t3]: &[[f64; 2]; 3]| {
                let (t4, t5, t6) = (middle(t1, t2), middle(t2, t3), middle(t3, t1));
                [[t1, t4, t6], [t4, t2, t5], [t6, t5, t3], [t4, t5, t6]]
            };
            uv.iter().flat_map(divide).collect()
        });
        fn fourfold<T: Clone>(faces: &[T]) -> Vec<T> {
            faces.iter().flat_map(|face| std::iter::repeat_n(face.clone(), 4)).collect()
        }
        let face_colors = self.face_colors.as_deref().map(fourfold);
        let materials = self.materials.as_ref().map(|materials| Materials {
            all: materials.all.clone(),
            of_faces: fourfold(&materials.of_faces),
        });
        Mesh { vertices, faces, colors, face_colors, uv, materials }
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
