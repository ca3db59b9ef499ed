//! Costs are carried without a change of their integrals, and labels to what they cover.

use ndarray::{Array1, Array2};

use super::random_costs;
use crate::classes::carry::{labels_of_faces, labels_of_vertices, to_faces, to_vertices};
use crate::mesh::geometry::barycentric_areas;
use crate::samples::{assert_within, shape, with_isolated_vertices, zoo};

/// sum_k a_k u_k s_k = sum_j A_j s_j times the mean of u over face j, for U linear on each face.
#[test]
fn costs_of_faces_are_integrated_exactly() {
    for (name, mesh) in zoo() {
        let mut s = random_costs(mesh.faces.len(), 3, 1001);
        s.row_mut(0).fill(f64::NAN);
        let u = random_costs(mesh.vertices.len(), 3, 1002);
        let carried = to_vertices(&mesh, &s);
        let mut left = 0.0;
        for (k, area) in barycentric_areas(&mesh).into_iter().enumerate() {
            if !carried[[k, 0]].is_nan() {
                left += area * u.row(k).dot(&carried.row(k));
            }
        }
        let mut right = 0.0;
        for j in (1..mesh.faces.len()).filter(|&j| !mesh.is_degenerate(j)) {
            let corners = mesh.faces[j].map(|v| v as usize);
            for p in 0..3 {
                let mean = corners.iter().map(|&v| u[[v, p]]).sum::<f64>() / 3.0;
                right += mesh.face_area(j) * mean * s[[j, p]];
            }
        }
        assert_within(left, right, 1e-12, right);
        assert!(left.is_finite(), "{name}");
    }
}

/// A_j s_j is the integral of the linear interpolant of the costs of the corners.
#[test]
fn costs_of_vertices_are_integrated_exactly() {
    let mesh = shape("sphere:2");
    let heights = Array2::from_shape_fn((mesh.vertices.len(), 2), |(k, p)| {
        let x = mesh.vertices[k];
        if p == 0 { x.z + 2.0 } else { x.x - 3.0 * x.y }
    });
    let carried = to_faces(&mesh, &heights);
    for j in 0..mesh.faces.len() {
        let center = mesh
            .corners(j)
            .iter()
            .fold([0.0; 3], |sum, x| [sum[0] + x.x / 3.0, sum[1] + x.y / 3.0, sum[2] + x.z / 3.0]);
        assert!((carried[[j, 0]] - center[2] - 2.0).abs() < 1e-14);
        assert!((carried[[j, 1]] - center[0] + 3.0 * center[1]).abs() < 1e-14);
    }
    let mut some = heights.clone();
    some.row_mut(mesh.faces[0][0] as usize).fill(f64::NAN);
    assert!(to_faces(&mesh, &some).iter().all(|s| !s.is_nan()));
    some.fill(f64::NAN);
    assert!(to_faces(&mesh, &some).iter().all(|s| s.is_nan()));
}

/// Labels that are constant on a component stay, in both directions.
#[test]
fn constant_labels_stay() {
    let mesh = with_isolated_vertices(shape("torus:8x6"));
    let faces: Array1<i32> = Array1::from_elem(mesh.faces.len(), 2);
    let vertices = labels_of_vertices(&mesh, &faces, 4);
    let last = vertices.len() - 1;
    assert!(
        vertices.iter().enumerate().all(|(k, &p)| p == if k == 0 || k == last { 0 } else { 2 })
    );
    let u = Array2::from_elem((mesh.vertices.len(), 4), 0.25);
    let back = labels_of_faces(&mesh, &u, &Array1::from_elem(mesh.vertices.len(), 2));
    assert_eq!(back, faces);
}

/// Two equal corners decide, and three different ones by U.
#[test]
fn faces_take_the_label_of_their_middle() {
    let mesh = shape("grid:1x1");
    let u = ndarray::array![[0.4, 0.3, 0.3], [0.3, 0.4, 0.3], [0.1, 0.1, 0.8], [0.1, 0.1, 0.8]];
    let of = |labels: Vec<i32>| labels_of_faces(&mesh, &u, &labels.into()).to_vec();
    let corners = &mesh.faces;
    let expected = |labels: [i32; 4]| -> Vec<i32> {
        let label = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| labels[v as usize]);
            if a == b || a == c {
                a
            } else if b == c {
                b
            } else {
                2
            }
        };
        corners.iter().map(label).collect()
    };
    for labels in [[0, 0, 1, 1], [0, 1, 1, 0], [0, 1, 2, 2], [2, 2, 2, 2]] {
        assert_eq!(of(labels.to_vec()), expected(labels), "{labels:?}");
    }
}
