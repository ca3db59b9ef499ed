//! Invalid meshes.

use std::fs;

use super::{VERBS, folder, refuse};
use crate::support::SQUARE_OBJ;

/// A minimal PLY file.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
    endfacet\nendsolid\n";

const OFF: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn malformed_text_is_refused() {
    let folder = folder();
    let ply = |from: &str, to: &str| PLY.replacen(from, to, 1);
    let stl = |from: &str, to: &str| STL.replacen(from, to, 1);
    let off = |from: &str, to: &str| OFF.replacen(from, to, 1);
    let obj = |from: &str, to: &str| SQUARE_OBJ.replacen(from, to, 1);
    for (name, content, part) in [
        ("a.obj", String::new(), "is empty"),
        ("a.obj", "# nothing\n".into(), "has no faces"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n".into(), "has no faces"),
        ("a.obj", obj("f 1 2 3", "f 1 2 5"), "line 5: refers to vertex 5"),
        ("a.obj", obj("f 1 2 3", "f 0 1 2"), "line 5: a vertex index is 0"),
        ("a.obj", obj("f 1 2 3", "f 1 2 -5"), "refers to vertex -5"),
        ("a.obj", obj("f 1 2 3", "f 1 2 99999999999999999999"), "line 5"),
        ("a.obj", "v 0 0 0\nf 1 1\n".into(), "has no faces"),
        ("a.obj", obj("f 1 2 3", "f 1 2 c"), "\"c\""),
        ("a.obj", obj("v 1 1 0", "v 1 nan 0"), "line 3: NaN"),
        ("a.obj", obj("v 1 1 0", "v 1 1e999 0"), "line 3: inf"),
        ("a.obj", obj("v 1 1 0", "v 1 1e60 0"), "too large"),
        ("a.obj", obj("v 1 1 0", "v 1 1"), "line 3: a coordinate is missing"),
        ("a.off", "3 1 0\n".into(), "line 1: expected OFF"),
        ("a.off", off("3 1 0", "4294967295 1 0"), "ends after 4 of 4294967295 vertices"),
        ("a.off", off("3 1 0", "3 18446744073709551615 0"), "ends after 1"),
        ("a.off", off("3 0 1 2", "3 0 1 3"), "refers to vertex 3"),
        ("a.off", off("3 0 1 2", "9223372036854775807 0 1"), "is missing"),
        ("a.off", off("3 0 1 2", "2 0 1"), "has no faces"),
        ("a.off", off("OFF", "4OFF"), "three dimensions"),
        ("a.off", off("OFF", "OFF BINARY"), "binary OFF"),
        ("a.off", OFF.to_owned() + "3 0 1 2\n", "continues after the declared"),
        ("a.ply", ply("ply\n", "plyx\n"), "not a PLY file"),
        ("a.ply", ply("end_header\n", ""), "PLY header"),
        ("a.ply", ply("ascii", "utf8"), "line 2: the format \"utf8\" is unknown"),
        ("a.ply", ply("vertex 3", "vertex 4294967295"), "element 5 of 4294967295"),
        ("a.ply", ply("vertex 3", "vertex 4"), "line 14: the file ends"),
        ("a.ply", ply("vertex 3", "vertex -1"), "not a valid number of elements"),
        ("a.ply", ply("face 1", "face 18446744073709551615"), "ends after 1"),
        ("a.ply", ply("face 1", "face 0"), "more values"),
        ("a.ply", ply("face 1", "edge 1"), "has no faces"),
        ("a.ply", ply("property float z\n", ""), "no property z"),
        ("a.ply", ply("float x", "list uchar float x"), "must be a number"),
        ("a.ply", ply("3 0 1 2", "3 0 1 3"), "face 0: refers to vertex 3"),
        ("a.ply", ply("3 0 1 2", "-3 0 1 2"), "a list has -3 items"),
        ("a.ply", ply("3 0 1 2", "9223372036854775807 0"), "is missing"),
        ("a.ply", ply("1 0 0", "1 nan 0"), "vertex 1: NaN"),
        ("a.ply", ply("ascii", "binary_little_endian"), "a.ply"),
        ("a.stl", "solid\nendsolid\n".into(), "has no faces"),
        ("a.stl", "solid\n".into(), "endsolid"),
        ("a.stl", "neither".into(), "neither ascii nor binary"),
        ("a.stl", stl("vertex 0 1 0", "vertex 0 1"), "line 7"),
        ("a.stl", stl("vertex 0 1 0", "vertex 0 inf 0"), "inf"),
        ("a.stl", stl("endloop", "vertex 0 0 1\nendloop"), "endloop"),
        ("a.stl", stl("endsolid\n", ""), "endsolid"),
        ("a.txt", "hello, world\n".into(), ".obj, .ply, .off, .stl, .vtp and .vtu"),
        ("a.npy", "\u{1}NUMPY".into(), ".obj, .ply, .off, .stl, .vtp and .vtu"),
    ] {
        folder.write(name, content);
        refuse(&folder, &format!("mesh info {name}"), &[name, part]);
    }
}

#[test]
fn malformed_binary_files_are_refused() {
    let folder = folder();
    let header = "ply\nformat binary_little_endian 1.0\n";
    let xyz = "property double x\nproperty double y\nproperty double z\n";
    let list = "property list uint uint vertex_indices\nend_header\n";
    let stl =
        |triangles: u32| [vec![0; 80], triangles.to_le_bytes().to_vec(), vec![0; 50]].concat();
    for (name, content, part) in [
        (
            "a.ply",
            format!("{header}element vertex 4294967295\n{xyz}element face 1\n{list}").into(),
            "too short",
        ),
        (
            "a.ply",
            [
                format!("{header}element vertex 0\n{xyz}element face 1\n{list}").as_bytes(),
                &[255; 4],
            ]
            .concat(),
            "a.ply",
        ),
        ("a.ply", format!("{header}element face 18446744073709551615\n{list}").into(), "a.ply"),
        ("a.stl", stl(u32::MAX), "declares 4294967295 triangles"),
        ("a.stl", stl(2), "declares 2 triangles"),
        ("a.stl", stl(0), "a.stl"),
        (
            "a.fbx",
            b"Kaydara FBX Binary  \0\x1a\0".to_vec(),
            ".obj, .ply, .off, .stl, .vtp and .vtu",
        ),
        ("a.obj", b"\xff\xfe\0\0v\0".to_vec(), "a.obj"),
        ("zeros.obj", vec![0; 1 << 20], "zeros.obj"),
        ("deep.ply", [b"ply\n".to_vec(), vec![b'('; 1 << 20]].concat(), "deep.ply"),
        ("line.obj", [b"f".to_vec(), b" 1".repeat(1 << 19)].concat(), "line.obj"),
    ] {
        folder.write(name, content);
        refuse(&folder, &format!("mesh info {name}"), &[name, part]);
    }
}

#[test]
fn every_verb_refuses_an_invalid_mesh() {
    let folder = folder();
    folder.write("empty.obj", "");
    folder.write("wrong.obj", "v 0 0 0\nf 1 1 2\n");
    fs::create_dir(folder.path("folder.ply")).unwrap();
    for (verb, rest) in VERBS {
        for (mesh, part) in [
            ("missing.ply", "No such file"),
            ("folder.ply", "is a folder"),
            ("empty.obj", "is empty"),
            ("wrong.obj", "line 2"),
            ("builtin:cow", "use builtin:spot"),
            ("cube:3", "neither a file nor a shape"),
            ("torus:2x2", "at least 3x3"),
            ("sphere:99", "must be 0 to 10"),
            ("grid:100000x100000", "at most"),
        ] {
            refuse(&folder, &format!("{verb} {mesh} {rest}"), &[mesh, part]);
        }
    }
}

#[test]
fn meshes_without_area_are_refused_where_an_area_is_needed() {
    let folder = folder();
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\nf 2 3 4\nf 1 1 1\n");
    folder.write("tiny.obj", SQUARE_OBJ.replace(" 1", " 1e-170").replace("f 1e-170", "f 1"));
    for (verb, rest) in &VERBS[..5] {
        refuse(&folder, &format!("{verb} flat.obj {rest}"), &["flat.obj", "no face with an area"]);
        refuse(&folder, &format!("{verb} tiny.obj {rest}"), &["tiny.obj", "area"]);
    }
    // They are valid meshes nevertheless.
    folder.done("mesh info flat.obj");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused() {
    let folder = folder();
    let made = std::process::Command::new("mkfifo").arg(folder.path("pipe.obj")).status();
    assert!(made.unwrap().success());
    fs::hard_link(folder.path("pipe.obj"), folder.path("pipe.npy")).unwrap();
    for (verb, rest) in VERBS {
        refuse(&folder, &format!("{verb} pipe.obj {rest}"), &["pipe.obj", "not a regular file"]);
    }
    for line in [
        "solve square.obj --costs pipe.npy --lambda 1 --out out",
        "evaluate square.obj --costs S.npy --u pipe.npy --lambda 1",
        "segment square.obj --data pipe.npy --regions 2 --out out",
        "render square.obj --labels pipe.npy",
        "render square.obj --data pipe.npy",
        "segment square.obj --data image:pipe.npy --project xy --regions 2 --out out",
    ] {
        refuse(&folder, line, &["pipe.npy", "not a regular file"]);
    }
    refuse(&folder, "mesh info /dev/zero", &["/dev/zero", "not a regular file"]);
}

#[test]
fn a_line_break_in_a_name_is_escaped() {
    let output = assert_cmd::Command::new(crate::support::PROGRAM)
        .args(["mesh", "info", "no\nsuch.ply"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = crate::support::stderr(&output);
    assert!(message.starts_with("error: no\\nsuch.ply: ") && message.lines().count() == 1);
}
