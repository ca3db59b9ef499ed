//! Malformed files: each gives an error of one line, and none a panic, a hang or excessive memory use.

use std::fs;
use std::path::Path;

use super::{PLY, decorated, message, read, written};
use crate::mesh::io::{
    self,
    Format::{self, Obj, Off, Ply, Stl},
};

fn assert_refused(format: Format, table: &[(&str, &str)]) {
    for (content, part) in table {
        let message = message(read(format, content), content);
        assert!(message.contains(part), "{content:?} gave {message:?}");
    }
}

#[test]
fn obj() {
    assert_refused(
        Obj,
        &[
            ("", "has no faces"),
            ("# nothing\n\n", "has no faces"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "has no faces"),
            ("f 1 2 3\n", "line 1: refers to vertex 3, but the file has 0 vertices"),
            ("v 0 0 0\nf 1 1 2\n", "line 2: refers to vertex 2"),
            ("v 0 0 0\nf 1 1 -2\n", "line 2: refers to vertex -2"),
            ("v 0 0 0\nf 0 1 1\n", "line 2: a vertex index is 0"),
            ("v 0 0 0\nf 1 1 4294967296\n", "4294967296"),
            ("v 0 0 0\nf 1 1 99999999999999999999\n", "99999999999999999999"),
            ("v 0 0 0\nf 1 1 -9223372036854775808\n", "-9223372036854775808"),
            ("v 0 0 0\nf 1 1 1.5\n", "\"1.5\""),
            ("v 0 0 0\nf 1 1 a\n", "\"a\""),
            ("v 0 0 0\nf 1 1 /1\n", "\"\""),
            ("v 0 0 0\nf 1 1\n", "has no faces"),
            ("v 0 0 0\nf\n", "has no faces"),
            ("v 0 0\n", "a coordinate is missing"),
            ("v 0 0 \\\n", "a coordinate is missing"),
            ("v 0 0 zero\n", "\"zero\""),
            ("v 0 0 nan\n", "NaN is not a finite"),
            ("v 0 0 -inf\n", "-inf is not a finite"),
            ("v 0 0 1e999\n", "inf is not a finite"),
            ("v 0 0 1e51\n", "too large"),
            ("0 0 0\n", "\"0\""),
            ("\u{1}\u{2}\n", "line 1: expected a statement"),
            ("ply\nformat ascii 1.0\nelement vertex 1\n0 0 0\n", "line 4"),
            ("v 0 0 \u{fc}\n", "\u{fc}"),
        ],
    );
}

#[test]
fn off() {
    assert_refused(
        Off,
        &[
            ("", "line 1: expected OFF"),
            ("OF\n", "expected OFF, not \"OF\""),
            ("3 1 0\n", "expected OFF"),
            ("OFF", "ends before the number of vertices"),
            ("OFF\n3\n", "number of faces is missing"),
            ("OFF\n3 x 0\n", "\"x\""),
            ("OFF\n3 1 0 0\n", "unexpected \"0\""),
            ("OFF\n-3 1 0\n", "\"-3\""),
            ("OFF\n0 0 0\n", "has no faces"),
            ("OFF\n1 0 0\n0 0 0\n", "has no faces"),
            ("OFF\n4294967296 1 0\n0 0 0\n", "at most 2^32 - 1"),
            ("OFF\n4294967295 1 0\n0 0 0\n", "ends after 1 of 4294967295 vertices"),
            ("OFF\n1 18446744073709551615 0\n0 0 0\n", "ends after 0 of"),
            ("OFF\n1 18446744073709551616 0\n0 0 0\n", "is not a valid"),
            ("OFF\n0 1 0\n3 0 0 0\n", "has 0 vertices"),
            ("OFF\n1 1 0\n0 0\n3 0 0 0\n", "ends after 0 of 1 faces"),
            ("OFF\n1 1 0\n0 0 inf\n3 0 0 0\n", "inf is not"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0\n", "a vertex index is missing"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "refers to vertex 1"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 -1\n", "refers to vertex -1"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 0.0\n", "\"0.0\""),
            ("OFF\n1 1 0\n0 0 0\n2 0 0\n", "has no faces"),
            ("OFF\n1 1 0\n0 0 0\n-3 0 0\n", "has -3 corners"),
            ("OFF\n1 1 0\n0 0 0\n9223372036854775807 0 0\n", "is missing"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 0\n3 0 0 0\n", "continues after the declared"),
            ("OFF BINARY\n1 1 0\n", "binary OFF is not supported"),
            ("4OFF\n1 1 0\n", "three dimensions"),
            ("nOFF\n3\n1 1 0\n", "three dimensions"),
            ("CCOFF\n1 1 0\n", "expected OFF"),
            ("OFF1\n", "number of faces is missing"),
            ("OFF1 x 0\n", "\"x\""),
            ("OFF1x 1 0\n", "expected OFF"),
            ("OFF99999999999999999999 1 0\n", "is not a valid"),
        ],
    );
}

#[test]
fn ply() {
    assert!(read(Ply, PLY).is_ok());
    assert_refused(
        Ply,
        &[
            ("", "this is not a PLY file"),
            ("plyx\n", "this is not a PLY file"),
            ("ply", "this is not a PLY file"),
            ("ply\n", "ends before end_header"),
            ("ply\nend_header\n", "no format line"),
            ("ply\nformat ascii 1.0\nend_header\n", "has no vertices"),
            ("ply\nformat text 1.0\n", "line 2: the format \"text\" is unknown"),
            ("ply\nformat ascii 2.0\n", "line 2: the version is \"2.0\""),
            ("ply\nformat ascii 1.0\nformat ascii 1.0\n", "line 3"),
            ("ply\nproperty int x\n", "before the first element"),
            ("ply\nelement vertex\n", "is not a valid line of a PLY header"),
            ("ply\nelement vertex -1\n", "is not a valid number of elements"),
            ("ply\nelement vertex 4294967296\n", "at most 2^32 - 1"),
            ("ply\nelement vertex 1\nelement vertex 1\n", "declared twice"),
            ("ply\nbinary\u{0}garbage\n", "is not a valid line of a PLY header"),
        ],
    );
    for (from, to, part) in [
        ("float x", "list uchar float x", "must be a number"),
        ("float x", "float16 x", "property type \"float16\" is unknown"),
        ("float x", "float x\nproperty int x", "declared twice"),
        ("property float x\n", "", "vertex has no property x"),
        ("property float z\n", "", "vertex has no property z"),
        ("list uchar int", "list uchar float", "must have items of an integer type"),
        ("list uchar int", "list float int", "integer type"),
        ("list uchar int", "int", "must be a list"),
        ("vertex_indices", "indices", "no list property vertex_indices"),
        ("property list uchar int vertex_indices\n", "", "no properties"),
        ("list uchar int vertex_indices", "list", "a type and a name"),
        ("element vertex 1", "element vertex 0", "unexpected"),
        ("element vertex 1", "element vertex 2", "has no faces"),
        (
            "element vertex 1",
            "element vertex 4294967295",
            "line 12: the file ends within element 3 of",
        ),
        ("element face 1", "element face 2", "line 12: the file ends after 1 of 2"),
        ("element face 1", "element face 18446744073709551615", "ends after 1 of 1844"),
        ("element face 1", "element face 18446744073709551616", "is not a valid"),
        ("element face 1", "element face 0", "more values"),
        ("element face 1", "element other 1", "has no faces"),
        ("element vertex", "element point", "has no vertices"),
        ("3 0 0 0\n", "3 0 0 1\n", "line 11: face 0: refers to vertex 1"),
        ("3 0 0 0\n", "3 0 0 -1\n", "refers to vertex -1"),
        ("3 0 0 0\n", "3 0 0 4294967296\n", "refers to vertex 4294967296"),
        ("3 0 0 0\n", "3 0 0 0.5\n", "a whole number, not \"0.5\""),
        ("3 0 0 0\n", "3 0 0 x\n", "\"x\""),
        ("3 0 0 0\n", "3 0 0\n", "is missing"),
        ("3 0 0 0\n", "2 0 0\n", "has no faces"),
        ("3 0 0 0\n", "0\n", "has no faces"),
        ("3 0 0 0\n", "-3 0 0 0\n", "a list has -3 items"),
        ("3 0 0 0\n", "9223372036854775807 0\n", "is missing"),
        ("3 0 0 0\n", "3 0 0 0 0\n", "unexpected \"0\""),
        ("3 0 0 0\n", "3 0 0 0\nx\n", "more values"),
        ("0 0 0\n3", "0 nan 0\n3", "line 10: vertex 0: NaN is not"),
        ("0 0 0\n3", "0 1e999 0\n3", "inf is not"),
        ("0 0 0\n3", "0 a 0\n3", "\"a\""),
        ("0 0 0\n3", "0 0\n3", "unexpected \"0\""),
        ("0 0 0\n3", "0 0 0 0\n3", "unexpected"),
        ("element face 1", "element void 18446744073709551615\nelement face 2", "ends after 1"),
    ] {
        assert!(PLY.contains(from));
        assert_refused(Ply, &[(&PLY.replacen(from, to, 1), part)]);
    }
    let textured = PLY.replace("end_header", "property list uchar float texcoord\nend_header");
    for (list, part) in [("6 0 0 0 0 0", "is missing"), ("-1", "a list has -1 items")] {
        let text = textured.replace("3 0 0 0\n", &format!("3 0 0 0 {list}\n"));
        assert_refused(Ply, &[(&text, part)]);
    }
}

/// Headers that declare something other than what follows.
#[test]
fn ply_binary() {
    let mesh = decorated();
    let valid = written(Ply, &mesh);
    let header_length = valid.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8(valid[..header_length].to_vec()).unwrap();
    let with_header = |header: &str| [header.as_bytes(), &valid[header_length..]].concat();
    let refused = |bytes: &[u8], part: &str| {
        let message = message(read(Ply, bytes), part);
        assert!(message.contains(part), "{message}");
    };
    for (from, to, part) in [
        ("vertex 20", "vertex 19", "refers to|corners|follow|too short|items|texcoord|texture"),
        ("vertex 20", "vertex 4294967295", "too short"),
        ("face 40", "face 39", "bytes follow"),
        ("face 40", "face 41", "ends before"),
        ("face 40", "face 18446744073709551615", "too short"),
        ("little", "big", "vertex 0"),
    ] {
        let message = message(read(Ply, with_header(&header.replace(from, to))), to);
        assert!(part.split('|').any(|part| message.contains(part)), "{message}");
    }
    refused(&[&valid[..], b"more"].concat(), "4 bytes follow");
    let mut broken = valid.clone();
    broken[header_length..header_length + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    refused(&broken, "vertex 0: NaN");
    let faces = valid.len() - 40 * (1 + 12 + 1 + 48);
    let mut broken = valid.clone();
    broken[faces + 1..faces + 5].copy_from_slice(&20_u32.to_le_bytes());
    refused(&broken, "face 0: refers to vertex 20");
    // Lists longer than the file.
    let huge = "ply\nformat binary_little_endian 1.0\nelement x 1\nproperty list uint double y\n\
        element vertex 0\nproperty char x\nproperty char y\nproperty char z\nend_header\n";
    refused(&[huge.as_bytes(), &[0xff; 4]].concat(), "ends before");
}

#[test]
fn stl() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let valid = format!("solid\n{facet}endsolid\n");
    assert!(read(Stl, &valid).is_ok());
    assert_refused(
        Stl,
        &[
            ("", "neither ascii nor binary"),
            ("solid\nendsolid\n", "has no faces"),
            ("solid\n", "the file ends where endsolid is expected"),
            ("facet\n", "neither ascii nor binary"),
        ],
    );
    for (from, to, part) in [
        ("endsolid\n", "", "line 9: the file ends where endsolid"),
        ("endsolid\n", "endsolid\nmore\n", "expected solid, not \"more\""),
        ("facet n", "face n", "expected facet or endsolid"),
        ("outer loop", "outer", "expected loop"),
        ("vertex 0 1 0", "vertex 0 1", "line 7: expected a coordinate, a number, not \"endloop\""),
        ("vertex 0 1 0", "vertex 0 1 0 0", "line 6: expected endloop, not \"0\""),
        ("outer loop", "0 0 outer loop", "line 3: expected outer, not \"0\""),
        ("endloop\nendfacet\nendsolid\n", "", "the file ends where endloop"),
        ("vertex 0 1 0", "vertex 0 1 nan", "NaN"),
        ("vertex 0 1 0", "vertex 0 1 1e999", "inf"),
        ("vertex 0 1 0", "vertex 0 1 x", "\"x\""),
        ("vertex 0 1 0\n", "", "expected vertex, not \"endloop\""),
        ("endloop", "vertex 0 0 1\nendloop", "expected endloop"),
        ("endfacet\n", "", "expected endfacet"),
    ] {
        assert!(valid.contains(from));
        assert_refused(Stl, &[(&valid.replacen(from, to, 1), part)]);
    }

    let binary = written(Stl, &decorated());
    let refused = |bytes: &[u8], part: &str| {
        let message = message(read(Stl, bytes), part);
        assert!(message.contains(part), "{message}");
    };
    let count = |n: u32| [&binary[..80], &n.to_le_bytes(), &binary[84..]].concat();
    refused(&count(41), "declares 41 triangles but has 40");
    refused(&count(u32::MAX), "declares 4294967295 triangles");
    refused(&count(39), "50 bytes follow");
    refused(&[&count(0)[..84]].concat(), "has no faces");
    refused(&[&binary[..], b"x"].concat(), "1 byte follows");
    let mut broken = binary.clone();
    broken[96..100].copy_from_slice(&f32::INFINITY.to_le_bytes());
    refused(&broken, "triangle 0: inf");
    broken[..6].copy_from_slice(b"solid\0");
    refused(&broken[..500], "declares 40 triangles but has 8");
}

#[test]
fn files_that_are_not_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |path: &Path, part: &str| {
        let message = message(io::read(path), part);
        assert!(
            message.contains(part) && message.contains(&path.display().to_string()),
            "{message}"
        );
    };
    let file = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        path
    };
    refused(folder.path(), "is a folder");
    refused(&folder.path().join("missing.ply"), "No such file");
    for extension in ["obj", "ply", "off", "stl", "txt"] {
        refused(&file(&format!("empty.{extension}"), b""), "is empty");
    }
    for (name, content) in [
        ("a.fbx", b"Kaydara FBX Binary  \0\x1a\0".as_slice()),
        ("a.txt", b"hello, world\n"),
        ("a.png", b"\x89PNG\r\n\x1a\n\0\0\0"),
        ("a", b"\xff\xfe\0\0"),
    ] {
        refused(&file(name, content), ".obj, .ply, .off, .stl, .vtp and .vtu");
    }
    message(io::read(Path::new("a\nb.ply")), "a line end in the name");
    #[cfg(unix)]
    refused(Path::new("/dev/zero"), "is not a regular file");
}
