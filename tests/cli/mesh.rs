//! `mesh info`, `distance`, `generate` and `convert`.

use meshseg::Mesh;
use meshseg::mesh::io;
use serde_json::Value;

use crate::support::{Folder, SQUARE_OBJ, stderr};

/// A square with a repeated face, a face without area, a vertex in no face and a flipped neighbor.
const DAMAGED: &str = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 0 1\nv 0 1 0 0 0 1\nv 9 9 9 0 0 0\nf 1 2 3\n\
    f 1 4 3\nf 3 1 2\nf 1 2 2\n";

#[test]
fn info() {
    let folder = Folder::new();
    folder.write("damaged.obj", DAMAGED);
    let mut text = String::new();
    for mesh in ["torus:40x25", "grid:3x2", "sphere:2", "damaged.obj"] {
        text += &format!("{mesh}\n{}\n", folder.done(&format!("mesh info {mesh}")));
    }
    insta::assert_snapshot!("info", text);
}

#[test]
fn info_as_json() {
    let folder = Folder::new();
    folder.write("damaged.obj", DAMAGED);
    let text = folder.done("mesh info damaged.obj --json");
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["duplicate_faces"], 1);
    assert_eq!(json["degenerate_faces"], 1);
    assert_eq!(json["bounding_box"]["max"], serde_json::json!([9.0, 9.0, 9.0]));
    insta::assert_snapshot!("info_json", text);
}

/// Two spheres of radius 1 and 1.1; the second has a diagonal of 2.2 sqrt 3.
#[test]
fn distances_are_relative_to_the_second_surface() {
    let folder = Folder::new();
    folder.done("mesh generate sphere:5 --out small.ply");
    let mut large = read(&folder, "small.ply");
    large.vertices.iter_mut().for_each(|x| *x *= 1.1);
    io::write(&folder.path("large.ply"), &large).unwrap();
    let text = folder.done("mesh distance small.ply large.ply --json");
    let json: Value = serde_json::from_str(&text).unwrap();
    for key in ["mean", "back", "percentile_95", "largest"] {
        let found = json[key].as_f64().unwrap() * 2.2 * 3.0_f64.sqrt();
        assert!((found - 0.1).abs() < 1e-3, "{key}: {text}");
    }
    let text = folder.done("mesh distance small.ply large.ply");
    assert_eq!(text.lines().count(), 4);
    assert!(text.starts_with("mean distance to the truth   2.6"), "{text}");
    folder.write("flat.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n");
    let output = folder.run("mesh distance small.ply flat.obj");
    let said = stderr(&output);
    assert!(said.contains("flat.obj") && said.contains("no face with an area"), "{said}");
    assert_eq!(output.status.code(), Some(1));
}

fn read(folder: &Folder, name: &str) -> Mesh {
    io::read(&folder.path(name)).unwrap()
}

#[test]
fn generate_writes_every_format() {
    let folder = Folder::new();
    for extension in ["ply", "obj", "off"] {
        let name = format!("torus.{extension}");
        folder.done(&format!("mesh generate torus:12x7 --out {name}"));
        let torus: meshseg::mesh::Shape = "torus:12x7".parse().unwrap();
        let expected = if extension == "off" { torus.mesh() } else { torus.textured() };
        assert!(read(&folder, &name) == expected, "{name}");
    }
    folder.done("mesh generate sphere:1 --out sphere.stl");
    assert_eq!(read(&folder, "sphere.stl").faces.len(), 80);
}

#[test]
fn conversions_keep_the_order_and_the_bits() {
    let folder = Folder::new();
    folder.write("first.obj", DAMAGED);
    let first = read(&folder, "first.obj");
    folder.done("mesh convert first.obj --out second.ply");
    folder.done("mesh convert second.ply --out third.off");
    folder.done("mesh convert third.off --out fourth.obj");
    for name in ["second.ply", "third.off", "fourth.obj"] {
        assert_eq!(read(&folder, name), first, "{name}");
    }
    // Onto itself: the old content is read before the new one replaces it.
    folder.done("mesh convert fourth.obj --out fourth.obj");
    assert_eq!(read(&folder, "fourth.obj"), first);
    // The corners of the square are in order of appearance, so that welding the STL file restores them.
    folder.write("square.obj", SQUARE_OBJ);
    folder.done("mesh convert square.obj --out square.stl");
    assert_eq!(read(&folder, "square.stl"), read(&folder, "square.obj"));
}

#[test]
fn subdivision_keeps_the_old_numbers() {
    let folder = Folder::new();
    folder.done("mesh generate grid:2x2 --out coarse.ply");
    folder.done("mesh convert coarse.ply --subdivide 2 --out fine.ply");
    let (coarse, fine) = (read(&folder, "coarse.ply"), read(&folder, "fine.ply"));
    assert_eq!(fine.faces.len(), 16 * coarse.faces.len());
    assert_eq!(fine.vertices[..coarse.vertices.len()], coarse.vertices);
    folder.done("mesh convert coarse.ply --subdivide 0 --out same.ply");
    assert_eq!(read(&folder, "same.ply"), coarse);
}
