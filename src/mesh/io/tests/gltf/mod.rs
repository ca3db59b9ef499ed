//! glTF: what a file says is read exactly, from each of its containers, and damaged files are refused on one line.

mod content;
mod malformed;
mod places;

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::Point3;
use serde_json::{Value, json};

use super::{message, read};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesh::io::{self, Format};

const FLOAT: u32 = 5126;
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;

/// A file in the making: its bytes, and the JSON that describes them.
#[derive(Clone, Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8]) -> usize {
        let (at, length) = (self.bytes.len(), bytes.len());
        self.views.push(json!({"buffer": 0, "byteOffset": at, "byteLength": length}));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessors.push(
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind}),
        );
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize {
        self.accessor(&format!("VEC{N}"), FLOAT, rows.len(), &floats(rows))
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor("SCALAR", SHORT, indices.len(), &bytes)
    }

    /// The JSON with the given keys besides those of the bytes.
    fn json(&self, rest: Value) -> Value {
        let json = json!({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": self.bytes.len()}],
            "bufferViews": self.views,
            "accessors": self.accessors,
        });
        with(json, rest)
    }

    fn glb(&self, rest: Value) -> Vec<u8> {
        glb(&self.json(rest).to_string(), &self.bytes)
    }

    /// The mesh of one node with these primitives.
    fn mesh(&self, primitives: Value) -> Mesh {
        self.read(json!({"meshes": [{"primitives": primitives}]}))
    }

    fn read(&self, rest: Value) -> Mesh {
        read(Format::Gltf, self.glb(rest)).unwrap()
    }

    fn refused(&self, rest: Value) -> String {
        let context = rest.to_string();
        message(read(Format::Gltf, self.glb(rest)), &context)
    }
}

/// An object with the keys of another one, too.
fn with(mut object: Value, other: Value) -> Value {
    let Value::Object(other) = other else { panic!("it has keys") };
    object.as_object_mut().unwrap().extend(other);
    object
}

fn floats<const N: usize>(rows: &[[f32; N]]) -> Vec<u8> {
    rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn glb(json: &str, bytes: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, data, padding) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", bytes, 0)] {
        let length = data.len().next_multiple_of(4);
        chunks.extend(u32::try_from(length).unwrap().to_le_bytes());
        chunks.extend(kind);
        chunks.extend(data);
        chunks.resize(chunks.len() + length - data.len(), padding);
    }
    let length = u32::try_from(12 + chunks.len()).unwrap();
    [b"glTF", &2_u32.to_le_bytes()[..], &length.to_le_bytes(), &chunks].concat()
}

const SQUARE: [[f32; 3]; 4] = [[0.1, 0.0, 0.0], [1.0, 0.0, 0.3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.7]];

/// A square of two triangles, and its mesh.
fn square() -> (File, Value, Mesh) {
    let mut file = File::default();
    let (positions, indices) = (file.floats(&SQUARE), file.indices(&[0, 1, 2, 2, 3, 0]));
    let primitives = json!([{"attributes": {"POSITION": positions}, "indices": indices}]);
    (file, primitives, Mesh::new(points(&SQUARE), vec![[0, 1, 2], [2, 3, 0]]))
}

fn points(rows: &[[f32; 3]]) -> Vec<Point3<f64>> {
    rows.iter().map(|row| Point3::from(row.map(f64::from))).collect()
}

#[test]
fn the_same_mesh_from_every_container() {
    let (file, primitives, mesh) = square();
    let rest = json!({"meshes": [{"primitives": primitives}], "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}], "scene": 0});
    let binary = file.glb(rest.clone());
    assert_eq!(read(Format::Gltf, &binary).unwrap(), mesh);
    assert_eq!(read(Format::Gltf, [&binary[..], b"\0\0\n"].concat()).unwrap(), mesh);

    let mut json = file.json(rest);
    let base64 = BASE64_STANDARD.encode(&file.bytes);
    for kind in ["data:application/octet-stream;base64,", "data:;base64,"] {
        json["buffers"][0]["uri"] = format!("{kind}{base64}").into();
        assert_eq!(read(Format::Gltf, json.to_string()).unwrap(), mesh);
        assert_eq!(read(Format::Gltf, format!("\u{feff} {json:#}\n")).unwrap(), mesh);
    }

    json["buffers"][0]["uri"] = "a%20b.bin".into();
    let message = message(read(Format::Gltf, json.to_string()), "no folder");
    assert!(message.contains("buffer 0 is the file \"a b.bin\""), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["a.gltf", "a.GLTF", "a"] {
        fs::write(path(name), json.to_string()).unwrap();
        assert!(
            matches!(io::read(&path(name)), Err(Error::Io { path, .. }) if path.ends_with("a b.bin"))
        );
    }
    fs::write(path("a b.bin"), &file.bytes[1..]).unwrap();
    let truncated = io::read(&path("a")).unwrap_err().to_string();
    assert!(truncated.contains("buffer 0 declares 60 bytes but has 59"), "{truncated}");
    fs::write(path("a b.bin"), &file.bytes).unwrap();
    fs::write(path("a.glb"), &binary).unwrap();
    fs::write(path("b"), &binary).unwrap();
    for name in ["a.gltf", "a.GLTF", "a", "a.glb", "b"] {
        assert_eq!(io::read(&path(name)).unwrap(), mesh, "{name}");
    }
}

#[test]
fn it_is_not_written() {
    let (.., mesh) = square();
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.gltf", "a.glb"] {
        let path = folder.path().join(name);
        for result in [
            io::write(&path, &mesh),
            io::check_labeled_faces(&path),
            io::write_labeled_faces(&path, mesh.clone(), &[0, 0], &[[0.0; 3]]),
        ] {
            assert!(result.unwrap_err().to_string().contains("only read; use one of .obj, .ply"));
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(!io::holds_texture(Path::new("a.glb")));
}
