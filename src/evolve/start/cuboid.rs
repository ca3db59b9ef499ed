//! The surface of a box.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::mesh::Mesh;

/// The surface of the box between two corners, with a grid of `cells` cells along its longest side and about square ones
/// everywhere. Normals point outwards.
///
/// # Panics
/// `cells` is 0, or a side has no length.
pub fn cuboid(low: Point3<f64>, high: Point3<f64>, cells: u32) -> Mesh {
    let sides = high - low;
    assert!(cells > 0 && sides.iter().all(|&side| side > 0.0));
    let n: [u32; 3] =
        [0, 1, 2].map(|i| (f64::from(cells) * sides[i] / sides.max()).round().max(1.0) as u32);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let mut index = HashMap::new();
    let mut vertex = |at: [u32; 3]| {
        *index.entry(at).or_insert_with(|| {
            let x = |i: usize| low[i] + sides[i] * f64::from(at[i]) / f64::from(n[i]);
            vertices.push(Point3::new(x(0), x(1), x(2)));
            vertices.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        let [right, up] = [(axis + 1) % 3, (axis + 2) % 3];
        for end in [0, n[axis]] {
            for i in 0..n[right] {
                for j in 0..n[up] {
                    let mut at = |i: u32, j: u32| {
                        let mut at = [end; 3];
                        (at[right], at[up]) = (i, j);
                        vertex(at)
                    };
                    // Counterclockwise seen against the axis.
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let [b, d] = if end == 0 { [d, b] } else { [b, d] };
                    faces.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    Mesh::new(vertices, faces)
}
