//! FreeSurfer: both forms of surfaces are the same mesh, numbers and labels come back, and damaged files are refused.

use std::fmt::Write;
use std::path::Path;

use ndarray::array;

use super::{assert_survives_damage, message, read};
use crate::error::Result;
use crate::mesh::io::Format::FreeSurfer;
use crate::mesh::io::{self, Annotation, read_annotation, read_curvature, write_annotation};

const POINTS: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.5], [1.0, 0.0, -1.25], [0.0, 1.0, 0.0], [0.1, 0.7, 3e-8]];
const FACES: [[i32; 3]; 2] = [[0, 1, 2], [1, 3, 2]];

fn ints(numbers: impl IntoIterator<Item = i32>) -> Vec<u8> {
    numbers.into_iter().flat_map(i32::to_be_bytes).collect()
}

fn floats(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(f32::to_be_bytes).collect()
}

fn binary(counts: [i32; 2]) -> Vec<u8> {
    [
        b"\xff\xff\xfecreated by me on Monday\n\n".to_vec(),
        ints(counts),
        floats(POINTS.into_iter().flatten()),
        ints(FACES.into_iter().flatten()),
    ]
    .concat()
}

fn text() -> String {
    let mut text = "#!ascii version of lh.white\n4 2\n".to_owned();
    for [x, y, z] in POINTS.map(|x| x.map(f64::from)) {
        writeln!(text, "{x}  {y}  {z}  0").unwrap();
    }
    for [a, b, c] in FACES {
        writeln!(text, "{a} {b} {c} 0").unwrap();
    }
    text
}

fn curvature(content: &[u8]) -> Result<Vec<f64>> {
    read_curvature(Path::new("lh.test"), content)
}

fn annotation(content: &[u8]) -> Result<Annotation> {
    read_annotation(Path::new("lh.test.annot"), content)
}

#[test]
fn binary_and_text_are_the_same_mesh() {
    let mesh = read(FreeSurfer, binary([4, 2])).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(mesh.vertices[3].z, f64::from(3e-8_f32));
    assert_eq!(read(FreeSurfer, text()).unwrap(), mesh);
    // Tags follow.
    let tags = [binary([4, 2]), ints([20]), b"valid = 1\n".to_vec()].concat();
    assert_eq!(read(FreeSurfer, &tags).unwrap(), mesh);
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in [("lh.white", tags), ("rh.pial.asc", text().into_bytes())] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        assert_eq!(io::read(&path).unwrap(), mesh);
        assert!(message(io::read_data(&path), name).contains("is a surface"));
        let refused = message(io::write(&path, &mesh), name);
        assert!(refused.contains(name) && refused.contains(".ply"), "{refused}");
    }
}

#[test]
fn damaged_files() {
    assert_survives_damage(&binary([4, 2]), |bytes| read(FreeSurfer, bytes));
    assert_survives_damage(text().as_bytes(), |bytes| read(FreeSurfer, bytes));
    let complete = binary([4, 2]);
    for length in 0..complete.len() {
        message(read(FreeSurfer, &complete[..length]), "cut off");
    }
    let numbers = [b"\xff\xff\xff".to_vec(), ints([3, 9, 1]), floats([0.5, -1.0, 2.0])].concat();
    assert_survives_damage(&numbers, curvature);
    assert_survives_damage(&annotated().1, annotation);
    assert_survives_damage(&old_annotation(), annotation);
}

#[test]
fn malformed_surfaces() {
    let refused = |content: &[u8], part: &str| {
        let message = message(read(FreeSurfer, content), part);
        assert!(message.contains(part), "{part}: {message}");
    };
    refused(b"\xff\xff\xff\0\0\0\x04", "mris_convert");
    refused(b"\xff\xff\xfd\0\0\0\x04", "mris_convert");
    refused(b"\xff\xff\xfe", "ends within its comment");
    refused(b"\xff\xff\xfe\n\n\0", "ends within vertices");
    refused(b"off", "is not a surface of FreeSurfer");
    refused(&binary([i32::MAX, 2]), "declares 2147483647 vertices, and has room for");
    refused(&binary([4, i32::MAX]), "declares 2147483647 faces, and has room for 2");
    refused(&binary([-1, 2]), "-1 is not a number of vertices");
    refused(&binary([4, 0])[..], "has no faces");
    for (from, to, part) in [
        ("4 2\n", "4\n", "line 2: the number of faces is missing"),
        ("4 2\n", "99999999999 2\n", "refers|expected|missing"),
        ("4 2\n", "4 -2\n", "-2 is not the number of faces"),
        ("4 2\n", "4 3\n", "the file ends where face 2 of 3"),
        ("4 2\n", "4 1\n", "line 8: the file continues"),
        ("1 3 2 0", "1 4 2 0", "line 8: face 1: refers to vertex 4, but the file has 4 vertices"),
        ("1 3 2 0", "1 -1 2 0", "refers to vertex -1"),
        ("1 3 2 0", "1 3", "is missing"),
        ("0  0  0.5  0", "0  0  nan  0", "line 3: NaN is not a finite"),
    ] {
        assert!(text().contains(from));
        let message = message(read(FreeSurfer, text().replacen(from, to, 1)), part);
        assert!(part.split('|').any(|part| message.contains(part)), "{part}: {message}");
    }
}

#[test]
fn numbers_at_vertices() {
    let magic = b"\xff\xff\xff".to_vec();
    let content = [magic.clone(), ints([3, 9, 1]), floats([0.5, -1.0, 1e-3])].concat();
    let values = [0.5, -1.0, f64::from(1e-3_f32)];
    assert_eq!(curvature(&content).unwrap(), values);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lh.thickness");
    std::fs::write(&path, &content).unwrap();
    assert_eq!(io::read_data(&path).unwrap(), array![[values[0]], [values[1]], [values[2]]]);
    for (header, part) in [
        (ints([2, 9, 1]), "4 bytes follow"),
        (ints([4, 9, 1]), "declares 4 numbers, and has room for 3"),
        (ints([i32::MAX, 9, 1]), "declares 2147483647"),
        (ints([-3, 9, 1]), "-3 is not a number of vertices"),
        (ints([3, 9, 2]), "has 2 numbers per vertex"),
    ] {
        let content = [&magic[..], &header, &content[15..]].concat();
        let message = message(curvature(&content), part);
        assert!(message.contains(part), "{message}");
    }
    assert!(message(curvature(b"\0\0\x03"), "old").contains("writes today"));
    std::fs::write(&path, b"\0\0\x03\0\0\x01").unwrap();
    assert!(message(io::read_data(&path), "old").contains("known format"));
}

/// Labels as our writer writes them.
fn annotated() -> (Annotation, Vec<u8>) {
    let labels = vec![0, 2, -1, 1, 3, 4, 2];
    let names = [Some("<\"a\" & b>".to_owned()), None, Some("c\0\u{e9}".to_owned()), None, None];
    let red = [1.0, 0.0, 0.0];
    let colors = [red, [0.2, 0.4, 0.6], red, [0.0; 3], [1.0; 3]];
    let mut bytes = Vec::new();
    write_annotation(&mut bytes, &labels, &names, &colors).unwrap();
    let names = ["<\"a\" & b>", "region 1", "c \u{e9}", "region 3", "region 4"];
    // A color that is taken, and black, are one step of blue further.
    let step = 1.0 / 255.0;
    let colors = vec![red, [0.2, 0.4, 0.6], [1.0, 0.0, step], [0.0, 0.0, step], [1.0; 3]];
    (Annotation { labels, names: names.map(str::to_owned).to_vec(), colors }, bytes)
}

/// An annotation of version 1 for three vertices, the second of which has an unknown code.
fn old_annotation() -> Vec<u8> {
    [
        ints([3, 2, 0x0003_0201, 1, 77, 0, 0, 1, 2, 4]),
        b"old\0".to_vec(),
        ints([2]),
        b"a\0".to_vec(),
        ints([1, 2, 3, 0, 5]),
        b"black".to_vec(),
        ints([0, 0, 0, 0]),
    ]
    .concat()
}

#[test]
fn labels_and_their_names_come_back() {
    let (expected, bytes) = annotated();
    assert_eq!(annotation(&bytes).unwrap(), expected);
    let old = annotation(&old_annotation()).unwrap();
    assert_eq!(old.labels, [1, -1, 0]);
    assert_eq!(old.names, ["a", "black"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lh.regions.annot");
    std::fs::write(&path, old_annotation()).unwrap();
    assert_eq!(io::read_values(&path).unwrap(), array![[1.0], [-1.0], [0.0]]);
}

/// Equal colors stay different, also if more of them are the same than a channel has values.
#[test]
fn many_equal_colors() {
    let colors = vec![[1.0, 1.0, 1.0]; 256];
    let labels: Vec<i32> = (0..256).collect();
    let mut bytes = Vec::new();
    write_annotation(&mut bytes, &labels, &[], &colors).unwrap();
    assert_eq!(annotation(&bytes).unwrap().labels, labels);
    assert!(write_annotation(&mut Vec::new(), &[], &[], &vec![[1.0; 3]; 257]).is_err());
}

#[test]
fn malformed_annotations() {
    let refused = |content: Vec<u8>, part: &str| {
        let message = message(annotation(&content), part);
        assert!(message.contains(part), "{part}: {message}");
    };
    refused(ints([i32::MAX, 0, 0]), "declares 2147483647 vertices, and has room for 1");
    refused(ints([-1]), "-1 is not a number of vertices");
    refused(ints([1, 0, 5]), "has no table");
    refused(ints([1, 0, 5, 0]), "has no table");
    refused(ints([1, 1, 5, 1]), "has a label of vertex 1, but 1 vertex");
    refused(ints([2, 0, 5, 0, 5, 1]), "has two labels of vertex 0");
    refused(ints([1, 0, 5, 1, -3]), "unknown version -3");
    refused(ints([1, 0, 5, 1, -2, i32::MAX, 0, 1]), "a table of 2147483647 rows");
    refused(ints([1, 0, 5, 1, i32::MAX, 0]), "a table of 2147483647 rows");
    refused(ints([1, 0, 5, 1, 3, i32::MAX]), "ends within a name");
    refused(ints([1, 0, 5, 1, -2, 1, 0, i32::MAX]), "ends within");
    refused(ints([1, 0, 5, 1, -2, 1, 0, 1, 1, 0, 0, 0, 0, 0]), "has row 1 in a table of 1");
    refused(ints([1, 0, 5, 1, -2, 1, 0, 1, 0, 0, 256, 0, 0, 0]), "has the color 256");
    refused(ints([1, 0, 5, 1, -2, 1, 0, 1, 0, 0, 0, 0, 0, 0, 77]), "4 bytes follow");
}
