//! Scenes, nodes and their transforms.

use nalgebra::{Matrix4, Point3, Rotation3, Vector3};
use serde_json::{Value, json};

use super::{File, points, square, with};
use crate::mesh::Mesh;

/// The square at nodes, of which 0 is the root.
fn at(nodes: Value) -> Mesh {
    let (file, primitives, _) = square();
    file.read(
        json!({"meshes": [{"primitives": primitives}], "nodes": nodes, "scenes": [{"nodes": [0]}]}),
    )
}

fn assert_moved(mesh: &Mesh, matrix: &Matrix4<f64>) {
    let (.., square) = square();
    assert_eq!(mesh.vertices.len(), square.vertices.len());
    for (x, original) in mesh.vertices.iter().zip(&square.vertices) {
        assert!((x - matrix.transform_point(original)).norm() < 1e-13, "{x}");
    }
}

/// Translation, rotation and scale as a node has them, and their matrix by another formula.
fn moves(signs: [f64; 3]) -> (Value, Matrix4<f64>) {
    let (angle, t) = (0.7_f64, [1.5, -2.0, 0.25]);
    let axis = Vector3::new(1.0, 2.0, -2.0) / 3.0;
    let q = axis * (angle / 2.0).sin();
    let s = [2.0 * signs[0], 0.5 * signs[1], 3.0 * signs[2]];
    let node =
        json!({"translation": t, "rotation": [q.x, q.y, q.z, (angle / 2.0).cos()], "scale": s});
    let rotation = Rotation3::new(axis * angle).into_inner();
    let linear = rotation * nalgebra::Matrix3::from_diagonal(&Vector3::from(s));
    let mut matrix = linear.to_homogeneous();
    matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vector3::from(t));
    (node, matrix)
}

#[test]
fn translation_rotation_and_scale_are_their_matrix() {
    let (mut node, matrix) = moves([1.0; 3]);
    node["mesh"] = 0.into();
    assert_moved(&at(json!([node])), &matrix);
    assert_moved(&at(json!([{"mesh": 0, "matrix": matrix.as_slice()}])), &matrix);
    // Rotations need not be exact.
    let q = node["rotation"].as_array().unwrap().iter().map(|q| 1.001 * q.as_f64().unwrap());
    node["rotation"] = q.collect();
    assert_moved(&at(json!([node])), &matrix);
    // A quarter turn around z.
    let h = 0.5_f64.sqrt();
    let quarter = at(json!([{"mesh": 0, "rotation": [0.0, 0.0, h, h]}]));
    for (x, y) in quarter.vertices.iter().zip(square().2.vertices) {
        assert!((x - Point3::new(-y.y, y.x, y.z)).norm() < 1e-15);
    }
}

#[test]
fn transforms_of_nodes_are_composed_from_the_root() {
    let (mut outer, outer_matrix) = moves([1.0; 3]);
    outer["children"] = json!([2, 1]);
    let inner = Matrix4::new_translation(&Vector3::new(1.0, 2.0, 3.0)) * Matrix4::new_scaling(0.5);
    let mesh = at(json!([outer, {"mesh": 0}, {"mesh": 0, "matrix": inner.as_slice()}]));
    let part = |first: usize| Mesh::new(mesh.vertices[first..first + 4].to_vec(), square().2.faces);
    // The children in the order of their parent.
    assert_moved(&part(0), &(outer_matrix * inner));
    assert_moved(&part(4), &outer_matrix);
    assert_eq!(mesh.faces, [[0, 1, 2], [2, 3, 0], [4, 5, 6], [6, 7, 4]]);
}

/// An octahedron with faces outwards; its volume is 4/3.
fn octahedron() -> (File, Value) {
    let mut file = File::default();
    let [x, y, z] = [[1.0_f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let positions = file.floats(&[x, y, z, x.map(|x| -x), y.map(|y| -y), z.map(|z| -z)]);
    let indices =
        file.indices(&[0, 1, 2, 1, 3, 2, 3, 4, 2, 4, 0, 2, 1, 0, 5, 3, 1, 5, 4, 3, 5, 0, 4, 5]);
    (file, json!([{"attributes": {"POSITION": positions}, "indices": indices}]))
}

#[test]
fn mirrors_keep_faces_outwards() {
    let (file, primitives) = octahedron();
    for signs in [[1.0; 3], [-1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [-1.0; 3]] {
        let (mut node, matrix) = moves(signs);
        node["mesh"] = 0.into();
        let nodes = json!([node]);
        let mesh = file.read(json!({"meshes": [{"primitives": primitives}], "nodes": nodes}));
        let volume = |j: usize| {
            let [a, b, c] = mesh.corners(j).map(|x| x.coords);
            a.cross(&b).dot(&c) / 6.0
        };
        let volume: f64 = (0..8).map(volume).sum();
        assert!((volume - 4.0 / 3.0 * matrix.determinant().abs()).abs() < 1e-12, "{signs:?}");
    }
}

#[test]
fn scenes_choose_nodes() {
    let (file, primitives, square) = square();
    let shifted = |x: f64| json!({"mesh": 0, "translation": [x, 0.0, 0.0]});
    let read = |scenes: Value| {
        let rest = json!({"meshes": [{"primitives": primitives}],
            "nodes": [shifted(0.0), shifted(1.0), {"children": [0]}, {"children": [1]}]});
        let mesh = file.read(with(rest, scenes));
        let shift = |x: &Point3<f64>| x.x - f64::from(super::SQUARE[0][0]);
        mesh.vertices.iter().step_by(4).map(shift).collect::<Vec<_>>()
    };
    assert_eq!(read(json!({"scenes": [{"nodes": [3]}, {"nodes": [2]}], "scene": 1})), [0.0]);
    assert_eq!(read(json!({"scenes": [{"nodes": [3]}, {"nodes": [2]}]})), [1.0]);
    assert_eq!(read(json!({"scenes": [{"nodes": [3, 2]}]})), [1.0, 0.0]);
    assert_eq!(read(json!({})), [0.0, 1.0]);
    // Without nodes, all meshes.
    let twice =
        file.read(json!({"meshes": [{"primitives": primitives}, {"primitives": primitives}]}));
    assert_eq!(twice.vertices, [&square.vertices[..], &square.vertices].concat());
}

#[test]
fn a_chain_of_nodes_may_be_long_but_not_closed() {
    let n = 20_000;
    let link = |i: usize| json!({"children": [i + 1], "translation": [1.0, 0.0, 0.0]});
    let mut nodes: Vec<_> = (0..n).map(link).collect();
    nodes.push(json!({"mesh": 0}));
    let mesh = at(json!(nodes));
    assert_moved(&mesh, &Matrix4::new_translation(&Vector3::new(n as f64, 0.0, 0.0)));

    let (file, primitives, _) = square();
    let meshes = json!([{"primitives": primitives}]);
    for (nodes, scenes) in [
        (json!([{"mesh": 0, "children": [0]}]), json!([{"nodes": [0]}])),
        (json!([{"mesh": 0, "children": [0]}]), json!([])),
        (json!([{"children": [1]}, {"mesh": 0, "children": [0]}]), json!([{"nodes": [1]}])),
        (json!([{"mesh": 0}, {"children": [3]}, {"children": [1]}, {"children": [2]}]), json!([])),
        (json!([{"children": [1, 1]}, {"mesh": 0}]), json!([])),
        (json!([{"mesh": 0}]), json!([{"nodes": [0, 0]}])),
    ] {
        let message = file.refused(json!({"meshes": meshes, "nodes": nodes, "scenes": scenes}));
        assert!(message.contains("must form trees"), "{message}");
    }
}

#[test]
fn skins_and_morphs_are_in_the_pose_of_their_positions() {
    let (file, mut primitives, square) = square();
    primitives[0]["targets"] = json!([{"POSITION": 0}]);
    let nodes = json!([{"mesh": 0, "skin": 0, "translation": [1.0, 0.0, 0.0]}]);
    let rest = json!({"meshes": [{"primitives": primitives, "weights": [1.0]}], "nodes": nodes,
        "skins": [{"joints": [0]}]});
    assert_eq!(file.read(rest).vertices, square.vertices);
    assert_eq!(points(&super::SQUARE), square.vertices);
}
