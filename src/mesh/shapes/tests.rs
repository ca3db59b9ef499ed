//! Tests of the generated surfaces: their areas, topology, normals, parts and names.

use super::*;
use crate::mesh::Statistics;
use std::f64::consts::PI;

#[test]
fn torus_follows_the_recipe() {
    let (nu, nv) = (40, 25);
    let mesh = Shape::Torus { nu, nv }.mesh();
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (1000, 2000));
    assert!((mesh.area() - 1.0).abs() < 1e-14);
    assert_eq!(mesh.faces[..2], [[0, 25, 26], [0, 26, 1]]);
    assert_eq!(mesh.faces[1998..], [[999, 24, 0], [999, 0, 975]]);
    // Every vertex is at distance r from the circle of radius R, up to the common scale.
    let c = mesh.vertices[0].x / 1.4;
    for x in &mesh.vertices {
        let from_axis = x.x.hypot(x.y) / c;
        assert!(((from_axis - 1.0).hypot(x.z / c) - 0.4).abs() < 1e-14);
    }
    assert_eq!(Statistics::of(&mesh).euler_characteristic, 0);
}

/// The area before scaling tends to 4 pi^2 R r with order 2.
#[test]
fn torus_converges() {
    let error = |n: u32| {
        let mesh = Shape::Torus { nu: 2 * n, nv: n }.mesh();
        let c = mesh.vertices[0].x / 1.4;
        ((c * c).recip() - 4.0 * PI * PI * 0.4).abs()
    };
    assert_order_2(error(32), error(64));
}

#[test]
fn sphere_converges() {
    let error = |level| (4.0 * PI - Shape::Sphere { level }.mesh().area()).abs();
    for level in 2..5 {
        assert_order_2(error(level), error(level + 1));
    }
    for level in 0..4 {
        let mesh = Shape::Sphere { level }.mesh();
        let s = Statistics::of(&mesh);
        assert_eq!((s.vertices, s.faces), (10 * 4_usize.pow(level) + 2, 20 * 4_usize.pow(level)));
        assert_eq!((s.euler_characteristic, s.inconsistent_edges), (2, 0));
        assert!(mesh.vertices.iter().all(|x| (x.coords.norm() - 1.0).abs() < 1e-15));
        let outwards = |j: usize| mesh.area_vector(j).dot(&mesh.corners(j)[0].coords) > 0.0;
        assert!((0..mesh.faces.len()).all(outwards));
    }
}

#[test]
fn grid_is_a_rectangle() {
    let mesh = Shape::Grid { nx: 8, ny: 3 }.mesh();
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (36, 48));
    assert!((mesh.area() - 3.0 / 8.0).abs() < 1e-15);
    assert!((0..48).all(|j| mesh.area_vector(j).z > 0.0));
    assert_eq!(mesh.vertices[35], Point3::new(1.0, 0.375, 0.0));
}

/// All parts are there, on faces with an area and normals as they are documented.
#[test]
fn parts_are_known() {
    for (text, m) in [("jaw:350x60", 15), ("city:160x160", 12)] {
        let shape: Shape = text.parse().unwrap();
        assert_eq!(shape.parts(), Some(m));
        let (mesh, parts) = (shape.mesh(), shape.part_of_faces().unwrap());
        assert_eq!((parts.len(), parts.len() as u64), (mesh.faces.len(), shape.faces()));
        let mut areas = vec![0.0; m];
        parts.iter().enumerate().for_each(|(j, &p)| areas[p] += mesh.face_area(j) / mesh.area());
        assert!(areas.iter().all(|&area| area > 0.005), "{text}: {areas:?}");
        assert!((0..mesh.faces.len()).all(|j| !mesh.is_degenerate(j)));
        let s = Statistics::of(&mesh);
        assert_eq!((s.euler_characteristic, s.inconsistent_edges), (1, 0));
    }
    let city = "city:160x160".parse::<Shape>().unwrap().mesh();
    assert!((0..city.faces.len()).all(|j| city.area_vector(j).z > 0.0));
    // The highest faces of the arch look upwards.
    let jaw = "jaw:350x60".parse::<Shape>().unwrap().mesh();
    let crest = (0..jaw.faces.len()).max_by(|&i, &j| {
        let z = |j: usize| jaw.corners(j).iter().map(|x| x.z).sum::<f64>();
        z(i).total_cmp(&z(j))
    });
    assert!(jaw.area_vector(crest.unwrap()).z > 0.0);
    assert_eq!("torus:4x4".parse::<Shape>().unwrap().part_of_faces(), None);
}

#[test]
fn text_round_trips() {
    for text in [
        "torus:400x250",
        "sphere:0",
        "sphere:10",
        "ellipsoid:3",
        "peanut:0",
        "dent:10",
        "grid:1x7",
        "grid:5000x5000",
        "jaw:700x120",
        "city:300x200",
    ] {
        let shape: Shape = text.parse().unwrap();
        assert_eq!(shape.to_string(), text);
    }
    for name in Shape::NAMES {
        let said = name.parse::<Shape>().unwrap_err().to_string();
        assert!(said.contains(&format!("as {name}:")), "{said}");
        assert!(Shape::SYNTAX.contains(&format!("{name}:")));
    }
    assert_eq!("torus:400x250".parse::<Shape>().unwrap().faces(), 200_000);
    for text in [
        "",
        "torus",
        "torus:",
        "torus:4",
        "torus:2x9",
        "torus:4x4x4",
        "torus:-4x4",
        "torus:4 x4",
        "torus:99999999999999999999x3",
        "torus:4000000000x4000000000",
        "sphere:",
        "sphere:11",
        "sphere:x",
        "sphere:+1",
        "grid:0x3",
        "grid:3x0",
        "grid:5001x5000",
        "peanut:11",
        "dent",
        "cube:3",
        "cube\n:3",
        "Torus:4x4",
    ] {
        let message = text.parse::<Shape>().unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
    }
}

fn assert_order_2(coarse: f64, fine: f64) {
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.05, "observed order {order}");
}
