//! Malformed files: each gives an error of one line, and none a panic, a hang or excessive memory use.

use serde_json::{Value, json};

use super::{FLOAT, File, glb, message, read, square};
use crate::mesh::io::Format::Gltf;

/// The JSON of a square and its bytes; every kind of entry occurs.
fn complete() -> (File, Value) {
    let (mut file, mut primitives, _) = square();
    let uv = file.floats(&[[0.0, 0.5]; 4]);
    let colors = file.floats(&[[0.0, 0.5, 1.0]; 4]);
    let (at, values) = (file.view(&[1]), file.view(&[0; 12]));
    file.accessors[0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": at, "byteOffset": 0, "componentType": 5121},
        "values": {"bufferView": values, "byteOffset": 0}});
    primitives[0]["attributes"] = json!({"POSITION": 0, "TEXCOORD_0": uv, "COLOR_0": colors});
    primitives[0]["material"] = 0.into();
    primitives[0]["mode"] = 4.into();
    let transform = json!({"KHR_texture_transform": {"offset": [0.0, 1.0], "scale": [2.0, 2.0]}});
    let texture = json!({"index": 0, "texCoord": 0, "extensions": transform});
    let surface = json!({"baseColorFactor": [1.0, 0.5, 0.0, 1.0], "baseColorTexture": texture});
    let rest = json!({
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "scale": [1.0, 1.0, 2.0]}, {"mesh": 0, "translation": [1.0, 0.0, 0.0]}],
        "meshes": [{"primitives": primitives}],
        "materials": [{"name": "a", "pbrMetallicRoughness": surface}],
        "textures": [{"source": 0, "sampler": 0}],
        "images": [{"uri": "a.png"}],
        "samplers": [{"wrapS": 10497, "wrapT": 33071}],
    });
    (file, rest)
}

/// The result is a mesh or an error of one line.
fn check(bytes: &[u8], context: &str) {
    if let result @ Err(_) = read(Gltf, bytes) {
        message(result, context);
    }
}

#[test]
fn every_truncation_is_refused() {
    let (file, rest) = complete();
    let bytes = file.glb(rest.clone());
    assert!(read(Gltf, &bytes).is_ok());
    for length in 0..bytes.len() {
        message(read(Gltf, &bytes[..length]), &format!("{length} bytes"));
    }
    let text = file.json(rest).to_string();
    for length in 0..text.len() {
        message(read(Gltf, &text[..length]), &format!("{length} bytes"));
    }
}

#[test]
fn every_changed_byte_is_read_or_refused() {
    let (file, rest) = complete();
    let text = file.json(rest).to_string();
    for at in 0..text.len() {
        for byte in [b'9', b'-', b'"', b'0', 0xff] {
            let mut changed = text.clone().into_bytes();
            changed[at] = byte;
            let context = String::from_utf8_lossy(&changed).into_owned();
            let mut bytes = glb(&text, &file.bytes);
            bytes[20..20 + text.len()].copy_from_slice(&changed);
            check(&bytes, &context);
        }
    }
    let bytes = glb(&text, &file.bytes);
    for at in (0..20).chain(20 + text.len()..bytes.len()) {
        for byte in [0, 1, 0x7f, 0xff] {
            let mut changed = bytes.clone();
            changed[at] = byte;
            check(&changed, &format!("byte {at} is {byte}"));
        }
    }
}

/// Sets the value at a JSON pointer, which need not exist.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (above, key) = pointer.rsplit_once('/').unwrap();
    match json.pointer_mut(above).unwrap() {
        Value::Object(object) => {
            object.insert(key.to_owned(), value);
        }
        Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer}"),
    }
}

#[test]
fn values_that_do_not_fit() {
    let (file, rest) = complete();
    let valid = file.json(rest);
    let most = u64::MAX;
    let primitive = "/meshes/0/primitives/0";
    for (pointer, value, part) in [
        ("/asset/version", json!("1.0"), "is glTF of version \"1.0\""),
        ("/asset/version", json!(2), "line 1, column"),
        ("/asset", json!(null), "is JSON, but not glTF"),
        ("/accessors", json!({}), "invalid type: map, expected a sequence"),
        ("/scene", json!(1), "scene 1 does not exist"),
        ("/scene", json!(-1), "invalid value: integer `-1`"),
        ("/scenes/0/nodes/0", json!(2), "node 2 does not exist"),
        ("/scenes/0/nodes", json!([]), "has no faces"),
        ("/nodes/1/mesh", json!(1), "mesh 1 does not exist"),
        ("/nodes/1/translation", json!([1.0]), "invalid length 1"),
        ("/nodes/1/translation", json!([1e60, 0, 0]), "primitive 0: vertex 0: the coordinate"),
        ("/nodes/1/rotation", json!([0, 0, 0, 0]), "node 1: its rotation is 0"),
        ("/nodes/1/matrix", json!(vec![1; 16]), "node 1: the last row of its matrix"),
        ("/meshes/0/primitives", json!([]), "has no faces"),
        ("mode", json!(7), "primitive 0: the mode is unknown"),
        ("mode", json!(1), "has no faces"),
        ("attributes", json!({}), "primitive 0: has no POSITION"),
        ("attributes/POSITION", json!(9), "accessor 9: does not exist"),
        ("attributes/POSITION", json!(1), "accessor 1: expected the type VEC3, not \"SCALAR\""),
        ("indices", json!(0), "accessor 0: expected the type SCALAR"),
        ("/accessors/0/componentType", json!(5125), "integers of 32 bits"),
        ("/accessors/0/componentType", json!(5130), "the componentType 5130 is unknown"),
        ("/accessors/1/componentType", json!(FLOAT), "indices must be unsigned"),
        ("/accessors/1/count", json!(5), "the number of corners, 5, is not a multiple of 3"),
        ("/accessors/0/count", json!(3), "primitive 0: refers to vertex 3, but has 3 positions"),
        ("/accessors/0/count", json!(most), "do not fit into bufferView 0 of 48 bytes"),
        ("/accessors/0/count", json!(1e30), "invalid type: floating point"),
        ("/accessors/1/byteOffset", json!(most), "do not fit into bufferView 1 of 12 bytes"),
        ("/accessors/1/count", json!(most), "do not fit into bufferView 1"),
        ("/accessors/0/bufferView", json!(99), "bufferView 99 does not exist"),
        ("/accessors/0/bufferView", json!(null), "accessor 0: has 4"),
        ("/accessors/0/sparse/count", json!(most), "do not fit into bufferView 4"),
        ("/accessors/0/sparse/count", json!(2), "do not fit into bufferView 4"),
        ("/accessors/0/sparse/indices/bufferView", json!(9), "bufferView 9 does not exist"),
        ("/accessors/0/sparse/indices/componentType", json!(5120), "sparse indices must be"),
        ("/accessors/0/sparse/values/byteOffset", json!(4), "do not fit into bufferView 5"),
        ("/bufferViews/0/byteStride", json!(8), "elements of 12 bytes overlap"),
        ("/bufferViews/0/byteStride", json!(most), "do not fit into bufferView 0"),
        ("/bufferViews/0/buffer", json!(1), "buffer 1 does not exist"),
        ("/bufferViews/0/byteLength", json!(most), "bufferView 0 reaches beyond the"),
        ("/bufferViews/1/byteOffset", json!(most), "bufferView 1 reaches beyond the"),
        ("/buffers/0/byteLength", json!(most), "buffer 0 declares 18446744073709551615 bytes"),
        ("/buffers/0/byteLength", json!(4), "reaches beyond the 4 bytes of buffer 0"),
        ("/buffers/0/uri", json!("data:;base64,?"), "buffer 0 has a data URI that is not valid"),
        ("/buffers/0/uri", json!("http://a/b"), "buffer 0 is at \"http://a/b\""),
        ("/buffers/0/uri", json!(""), "buffer 0 is the file \"\""),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "convert it without compression",
        ),
        ("/extensionsRequired", json!(["EXT_meshopt_compression"]), "EXT_meshopt_compression"),
        ("/extensionsRequired", json!(["A_b\n"]), "requires the extension \"A_b\\n\""),
        ("/nodes/0/scale", json!("x".repeat(999)), "invalid type: string"),
    ] {
        let mut json = valid.clone();
        let pointer = match pointer.starts_with('/') {
            true => pointer.to_owned(),
            false => format!("{primitive}/{pointer}"),
        };
        set(&mut json, &pointer, value.clone());
        if pointer.ends_with("/0/bufferView") {
            // More zeros than bytes.
            set(&mut json, "/accessors/0/count", json!(4_000_000_000_u64));
        }
        let message = message(read(Gltf, glb(&json.to_string(), &file.bytes)), &pointer);
        assert!(message.contains(part), "{pointer} = {value} gave {message:?}");
    }
    // A compression that is not declared.
    let mut json = valid.clone();
    set(&mut json, "/accessors/0", json!({"componentType": FLOAT, "count": 4, "type": "VEC3"}));
    let extension = json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    set(&mut json, &format!("{primitive}/extensions"), extension);
    let message = message(read(Gltf, glb(&json.to_string(), &file.bytes)), "Draco");
    assert!(message.contains("convert it without compression"), "{message}");
}

#[test]
fn containers_that_do_not_fit() {
    let (file, rest) = complete();
    let bytes = file.glb(rest);
    let with = |at: usize, value: u32| {
        let mut changed = bytes.clone();
        changed[at..at + 4].copy_from_slice(&value.to_le_bytes());
        changed
    };
    let length = u32::try_from(bytes.len()).unwrap();
    for (content, part) in [
        (with(4, 1), "is binary glTF of version 1"),
        (with(8, length + 1), "it is truncated"),
        (with(8, u32::MAX), "declares 4294967295 bytes"),
        (with(8, length - 4), "a chunk reaches beyond the end"),
        (with(8, 0), "continues after the 0 bytes"),
        (with(12, u32::MAX), "a chunk reaches beyond the end"),
        (with(16, 0), "the first chunk is"),
        ([&bytes[..], b"x"].concat(), "continues after"),
        (glb("", &[]), "the JSON is not valid: line 1"),
        (glb("[]", &[]), "the JSON is not valid"),
        (glb("{}", &[]), "is JSON, but not glTF"),
        (glb(&"[".repeat(100_000), &[]), "the JSON is not valid"),
        (glb(r#"{"asset": {"version": "2.0"}}"#, &[]), "has no faces"),
        (b"glTF\x02\0\0\0\x0c\0\0\0".to_vec(), "has no chunks"),
        (b"v 0 0 0\nf 1 1 1\n".to_vec(), "the JSON is not valid"),
        (b"\xff".to_vec(), "the JSON is not valid"),
    ] {
        let message = message(read(Gltf, content), part);
        assert!(message.contains(part), "{message:?} instead of {part:?}");
    }
}

#[test]
fn small_files_cannot_repeat_large_meshes() {
    // Each node repeats all primitives, and each primitive all corners, which are stitches.
    let mut file = File::default();
    let positions = file.floats(&[[0.0; 3]; 3]);
    let indices = file.indices(&[0; 60_000]);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": 5});
    let primitives = vec![primitive; 10];
    let nodes = vec![json!({"mesh": 0}); 100];
    let refused = file.refused(json!({"meshes": [{"primitives": primitives}], "nodes": nodes}));
    assert!(refused.contains("repeat meshes to more than 50000000 elements"), "{refused}");
}
