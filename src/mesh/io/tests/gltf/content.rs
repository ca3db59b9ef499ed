//! Primitives, accessors, colors, texture coordinates and materials.

use std::fs;

use serde_json::{Value, json};

use super::{BYTE, FLOAT, File, SHORT, SQUARE, floats, points, square, with};
use crate::mesh::io;
use crate::mesh::{Image, Materials, Mesh, Placement};

/// A zigzag in the plane; the odd vertices are above the even ones.
fn zigzag() -> (File, usize) {
    let mut file = File::default();
    let rows = [0_u8, 1, 2, 3, 4, 5].map(|k| [f32::from(k), f32::from(k % 2), 0.0]);
    let positions = file.floats(&rows);
    (file, positions)
}

#[test]
fn strips_and_fans_are_the_triangles_of_their_definition() {
    let (mut file, positions) = zigzag();
    let attributes = json!({"POSITION": positions});
    let strip = file.mesh(json!([{"attributes": attributes, "mode": 5}]));
    assert_eq!(strip.faces, [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]);
    // All have the same side up.
    assert!((0..4).all(|j| strip.area_vector(j).z < 0.0));
    // Two strips with a stitch between them.
    let indices = file.indices(&[0, 1, 2, 2, 3, 3, 4, 5]);
    let strips = file.mesh(json!([{"attributes": attributes, "indices": indices, "mode": 5}]));
    assert_eq!(strips.faces, [[0, 1, 2], [3, 5, 4]]);
    let indices = file.indices(&[0, 2, 4, 5, 3, 1]);
    let fan = file.mesh(json!([{"attributes": attributes, "indices": indices, "mode": 6}]));
    assert_eq!(fan.faces, [[0, 2, 4], [0, 4, 5], [0, 5, 3], [0, 3, 1]]);
    assert!((0..4).all(|j| fan.area_vector(j).z >= 0.0));
    let triangles = file.mesh(json!([{"attributes": attributes}]));
    assert_eq!(triangles.faces, [[0, 1, 2], [3, 4, 5]]);
    // Points and lines are left out.
    let thin = |mode: u32| json!({"attributes": attributes, "mode": mode});
    let some = file.mesh(json!([thin(0), thin(1), thin(4), thin(2), thin(3)]));
    assert_eq!(some, triangles);
}

#[test]
fn indices_of_every_type() {
    let (mut file, positions) = zigzag();
    let bytes = file.accessor("SCALAR", BYTE, 3, &[5, 3, 1]);
    let words: Vec<u8> = [5_u32, 3, 1].iter().flat_map(|k| k.to_le_bytes()).collect();
    let words = file.accessor("SCALAR", 5125, 3, &words);
    for indices in [bytes, words, file.indices(&[5, 3, 1])] {
        let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
        assert_eq!(file.mesh(json!([primitive])).faces, [[5, 3, 1]]);
    }
}

#[test]
fn primitives_of_a_node_share_vertices() {
    let (mut file, _, square) = square();
    let (first, second) = (file.indices(&[0, 1, 2]), file.indices(&[2, 3, 0]));
    let again = file.floats(&SQUARE);
    let part = |positions: usize, indices: usize, material: usize| {
        let attributes = json!({"POSITION": positions});
        json!({"attributes": attributes, "indices": indices, "material": material})
    };
    let read = |primitives: Value, nodes: Value| {
        let materials = json!([{"name": "a"}, {"name": "b"}, {"name": "c"}]);
        file.read(
            json!({"meshes": [{"primitives": primitives}], "nodes": nodes, "materials": materials}),
        )
    };
    let split = json!([part(0, first, 2), part(0, second, 0)]);
    let mesh = read(split.clone(), json!([{"mesh": 0}]));
    assert_eq!((&mesh.vertices, &mesh.faces), (&square.vertices, &square.faces));
    let materials = mesh.materials.unwrap();
    assert_eq!(materials.of_faces, [Some(1), Some(0)]);
    assert_eq!(materials.all.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["a", "c"]);
    // Not those of another node or accessor.
    let mesh = read(split, json!([{"mesh": 0}, {"mesh": 0}]));
    assert_eq!(mesh.faces, [[0, 1, 2], [2, 3, 0], [4, 5, 6], [6, 7, 4]]);
    let mesh = read(json!([part(0, first, 0), part(again, second, 0)]), json!([{"mesh": 0}]));
    assert_eq!((mesh.vertices.len(), mesh.faces), (8, vec![[0, 1, 2], [6, 7, 4]]));
}

#[test]
fn strides_separate_elements() {
    let mut file = File::default();
    let rows: Vec<[f32; 5]> = SQUARE.iter().map(|x| [0.25, x[0], x[1], x[2], 0.75]).collect();
    let view = file.view(&floats(&rows));
    file.views[view]["byteStride"] = 20.into();
    let accessor = |offset: usize| {
        let view = json!({"bufferView": view, "byteOffset": offset});
        with(view, json!({"componentType": FLOAT, "count": 4, "type": "VEC3"}))
    };
    file.accessors = vec![accessor(4)];
    let fan = json!([{"attributes": {"POSITION": 0}, "mode": 6}]);
    assert_eq!(file.mesh(fan.clone()).vertices, points(&SQUARE));
    // The last element would end behind the view.
    file.accessors = vec![accessor(12)];
    assert!(
        file.refused(json!({"meshes": [{"primitives": fan}]}))
            .contains("do not fit into bufferView 0")
    );
}

#[test]
fn sparse_elements_replace_others() {
    let (mut file, _, _) = square();
    let moved = [[7.0, 8.0, 9.0], [-1.0, -2.0, -3.0]];
    let (indices, values) = (file.view(&[1, 3]), file.view(&floats(&moved)));
    let sparse = json!({"count": 2, "indices": {"bufferView": indices, "componentType": BYTE},
        "values": {"bufferView": values}});
    for (view, others) in [(Some(0), [SQUARE[0], SQUARE[2]]), (None, [[0.0; 3]; 2])] {
        let mut accessor =
            json!({"componentType": FLOAT, "count": 4, "type": "VEC3", "sparse": sparse});
        if let Some(view) = view {
            accessor["bufferView"] = view.into();
        }
        file.accessors[0] = accessor;
        let mesh = file.mesh(json!([{"attributes": {"POSITION": 0}, "mode": 6}]));
        assert_eq!(mesh.vertices, points(&[others[0], moved[0], others[1], moved[1]]));
    }
    file.accessors[0]["count"] = 3.into();
    let rest = json!({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]});
    assert!(file.refused(rest).contains("a sparse index is 3, but there are 3 elements"));
}

#[test]
fn integers_are_positions_and_texture_coordinates() {
    let mut file = File::default();
    let bytes = [3_i16, -7, 32767, 0, 1, -32768, 9, 9, 9].map(i16::to_le_bytes).concat();
    let positions = file.accessor("VEC3", 5122, 3, &bytes);
    let uv = file.accessor("VEC2", BYTE, 3, &[0, 255, 51, 0, 255, 204]);
    file.accessors[uv]["normalized"] = true.into();
    let primitives = json!([{"attributes": {"POSITION": positions, "TEXCOORD_0": uv}}]);
    let rest = json!({"meshes": [{"primitives": primitives}],
        "extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]});
    let mesh = file.read(rest);
    assert_eq!(mesh.vertices, points(&[[3.0, -7.0, 32767.0], [0.0, 1.0, -32768.0], [9.0; 3]]));
    assert_eq!(mesh.uv.unwrap(), [[[0.0, 0.0], [0.2, 1.0], [1.0, 1.0 - 204.0 / 255.0]]]);
    file.accessors[positions]["normalized"] = true.into();
    let x = file.mesh(primitives).vertices;
    assert_eq!((x[0].x, x[0].z, x[1].z), (3.0 / 32767.0, 1.0, -1.0));
}

#[test]
fn colors_of_every_type() {
    let (mut file, _, _) = square();
    let red = [1.0, 0.0, 0.2];
    let words = [65535_u16, 0, 13107].map(u16::to_le_bytes).concat();
    let accessors = [
        file.floats(&[[1.0, 0.0, 0.2]; 4]),
        file.floats(&[[1.5, -1.0, 0.2, 0.5]; 4]),
        file.accessor("VEC3", BYTE, 4, &[255, 0, 51].repeat(4)),
        file.accessor("VEC4", BYTE, 4, &[255, 0, 51, 9].repeat(4)),
        file.accessor("VEC3", SHORT, 4, &words.repeat(4)),
    ];
    let part = |colors: Option<usize>| {
        let mut attributes = json!({"POSITION": 0});
        if let Some(colors) = colors {
            attributes["COLOR_0"] = colors.into();
        }
        json!({"attributes": attributes, "indices": 1})
    };
    for colors in accessors {
        let colors = file.mesh(json!([part(Some(colors))])).colors.unwrap();
        assert_eq!(colors.len(), 4);
        let errors = colors.iter().flat_map(|color| [0, 1, 2].map(|i| (color[i] - red[i]).abs()));
        assert!(errors.fold(0.0, f64::max) < 1e-8);
    }
    // The first colors of shared vertices; none where no primitive has some.
    let other = file.floats(&[[0.0; 3]; 4]);
    let mesh = file.mesh(json!([part(None), part(Some(accessors[2])), part(Some(other))]));
    assert_eq!(mesh.colors.unwrap(), [red; 4]);
    let unknown = file.floats(&[[f32::NAN, 0.0, 0.0], [0.5; 3], [0.0; 3], [1.0; 3]]);
    let nodes = json!([{"mesh": 0}, {"mesh": 1}]);
    let meshes = json!([{"primitives": [part(None)]}, {"primitives": [part(Some(unknown))]}]);
    let colors = file.read(json!({"meshes": meshes, "nodes": nodes})).colors.unwrap();
    assert!(colors[..5].iter().all(|color| color[0].is_nan()));
    assert_eq!(colors[5..], [[0.5; 3], [0.0; 3], [1.0; 3]]);
}

/// The square with materials; the second triangle has the second one if there are two.
fn painted(materials: Value, more: Value) -> (File, Value) {
    let (mut file, _, _) = square();
    let uv = file.floats(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.25, 0.75]]);
    let other = file.floats(&[[0.0, 2.0]; 4]);
    let attributes = json!({"POSITION": 0, "TEXCOORD_0": uv, "TEXCOORD_1": other});
    let (first, second) = (file.indices(&[0, 1, 2]), file.indices(&[2, 3, 0]));
    let last = materials.as_array().unwrap().len() - 1;
    let primitives = json!([
        {"attributes": attributes, "indices": first, "material": 0},
        {"attributes": attributes, "indices": second, "material": last},
    ]);
    let rest = json!({"meshes": [{"primitives": primitives}], "materials": materials});
    (file, with(rest, more))
}

fn materials(of: Value, more: Value) -> (Materials, Mesh) {
    let (file, rest) = painted(of, more);
    let mesh = file.read(rest);
    (mesh.materials.clone().unwrap(), mesh)
}

fn texture(texture: Value) -> Value {
    json!({"pbrMetallicRoughness": {"baseColorTexture": texture}})
}

#[test]
fn texture_coordinates_have_v_upwards() {
    let images = json!({"textures": [{"source": 0}], "images": [{"uri": "a.png"}]});
    let (_, mesh) = materials(json!([texture(json!({"index": 0}))]), images.clone());
    let uv = [[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.25, 0.25], [0.0, 1.0]]];
    assert_eq!(mesh.uv.unwrap(), uv);
    let (_, mesh) =
        materials(json!([{}, texture(json!({"index": 0, "texCoord": 1}))]), images.clone());
    assert_eq!(mesh.uv.unwrap(), [uv[0], [[0.0, -1.0]; 3]]);
    let (_, mesh) = materials(json!([{}, texture(json!({"index": 0, "texCoord": 2}))]), images);
    let second = mesh.uv.unwrap()[1];
    assert!(second.as_flattened().iter().all(|t| t.is_nan()));
}

#[test]
fn images_are_files_next_to_it() {
    let name = "a%20b.png";
    let images = json!({
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}, {"source": 9}, {}],
        "images": [{"uri": name}, {"uri": "data:image/png;base64,"}, {"bufferView": 0}, {"uri": "https://a/b.png"}],
    });
    let (file, rest) = painted(json!([texture(json!({"index": 0}))]), images.clone());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, file.glb(rest)).unwrap();
    let read = io::read(&path).unwrap().materials.unwrap();
    assert_eq!(read.all[0].image, Some(Image::File(folder.path().join("a b.png"))));
    let image =
        |index: usize| materials(json!([texture(json!({"index": index}))]), images.clone()).0;
    assert_eq!(image(0).all[0].image, Some(Image::File("a b.png".into())));
    for other in 1..7 {
        assert_eq!(image(other).all[0].image, None);
    }
}

/// A PNG image and a JPEG image by their first bytes, in a view and in a URI: one image of two materials is the same.
/// Written to OBJ or PLY, they become files, which replace no other ones.
#[test]
fn images_inside_become_files() {
    let png = [b"\x89PNG\r\n\x1a\n".as_slice(), &[7; 30]].concat();
    let jpeg = [b"\xff\xd8\xff".as_slice(), &[9; 20]].concat();
    let uri = "data:image/jpeg;base64,/9j/CQkJCQkJCQkJCQkJCQkJCQkJCQk=";
    let used = [0, 1, 2, 1].map(|index| texture(json!({"index": index})));
    let (mut file, rest) = painted(json!(used), json!({}));
    let view = file.view(&png);
    let images = json!([
        {"bufferView": view, "name": "../my atlas:1"}, {"uri": uri}, {"bufferView": view, "name": "my atlas1"},
    ]);
    let textures = json!([{"source": 0}, {"source": 1}, {"source": 2}]);
    let rest = with(rest, json!({"textures": textures, "images": images}));
    // The faces have the first and the last material.
    let mesh = file.read(rest.clone());
    let inside = |name: &str, bytes: &[u8]| Some(Image::Inside(name.into(), bytes.into()));
    let all = &mesh.materials.as_ref().unwrap().all;
    assert_eq!(all[0].image, inside("my atlas1.png", &png));
    assert_eq!(all[1].image, inside("image-1.jpg", &jpeg));

    let folder = tempfile::tempdir().unwrap();
    for name in ["a.obj", "a.ply", "a.obj"] {
        let path = folder.path().join(name);
        io::write(&path, &mesh).unwrap();
        let read = io::read(&path).unwrap().materials.unwrap();
        for (material, (name, bytes)) in
            read.all.iter().zip([("a-my atlas1.png", &png), ("a-image-1.jpg", &jpeg)])
        {
            let image = material.image.as_ref().unwrap();
            assert_eq!(image.path().file_name().unwrap(), name);
            assert_eq!(&fs::read(image.path()).unwrap(), bytes);
        }
    }
    // Another file of the second image's name: not even the first image is written.
    for name in ["b.ply", "b.obj"] {
        fs::write(folder.path().join("b-image-1.jpg"), "mine").unwrap();
        let message = io::write(&folder.path().join(name), &mesh).unwrap_err().to_string();
        assert!(message.contains("b-image-1.jpg: exists and would be replaced"), "{message}");
        assert_eq!(fs::read(folder.path().join("b-image-1.jpg")).unwrap(), b"mine");
        assert!(!folder.path().join("b-my atlas1.png").exists());
        assert!(!folder.path().join(name).exists());
    }
    // A mesh that cannot be written leaves no images.
    fs::create_dir(folder.path().join("c.ply")).unwrap();
    assert!(io::write(&folder.path().join("c.ply"), &mesh).is_err());
    assert!(!folder.path().join("c-my atlas1.png").exists());
    // A file that another material names is not taken for an image.
    let mut other = mesh.clone();
    let materials = other.materials.as_mut().unwrap();
    materials.all[1].image = Some(Image::File(folder.path().join("d-my atlas1.png")));
    io::write(&folder.path().join("d.ply"), &other).unwrap();
    let read = io::read(&folder.path().join("d.ply")).unwrap().materials.unwrap();
    let names = read.all.iter().map(|m| m.image.as_ref().unwrap().path().file_name().unwrap());
    assert!(names.eq(["inside-d-my atlas1.png", "d-my atlas1.png"]));
}

/// Many images of one view share its bytes; names are short and differ in more than case; values of a wrong type are
/// missing, and the rest is read.
#[test]
fn images_inside_are_shared_and_named_in_short() {
    let png = [b"\x89PNG\r\n\x1a\n".as_slice(), &[7; 30]].concat();
    let used = [0, 1].map(|index| texture(json!({"index": index})));
    let (mut file, rest) = painted(json!(used), json!({}));
    let view = file.view(&png);
    let long = "long ".repeat(100);
    let images = json!([{"bufferView": view, "name": long}, {"bufferView": view, "name": long.to_uppercase()}]);
    let textures = json!([{"source": 0}, {"source": 1}]);
    let with_images = with(rest.clone(), json!({"textures": textures, "images": images}));
    let materials = file.read(with_images).materials.unwrap();
    let [Some(Image::Inside(a, first)), Some(Image::Inside(b, second))] =
        [&materials.all[0].image, &materials.all[1].image]
    else {
        panic!("{materials:?}")
    };
    assert!(std::sync::Arc::ptr_eq(first, second));
    assert!(a.to_str().unwrap().len() < 50 && b.to_str().unwrap().len() < 60);
    assert_ne!(a.to_str().unwrap().to_lowercase(), b.to_str().unwrap().to_lowercase());
    for wrong in [json!({}), json!(5), json!("text"), json!(null)] {
        for key in ["images", "textures", "samplers"] {
            let mut whole = json!({"textures": textures, "images": images});
            whole[key] = wrong.clone();
            let mesh = file.read(with(rest.clone(), whole));
            assert_eq!(mesh.faces.len(), 2, "{key} {wrong}");
        }
        let mut whole = rest.clone();
        whole["materials"] = wrong.clone();
        assert_eq!(file.read(whole).faces.len(), 2);
    }
    let named = json!([{"bufferView": view, "name": 5}, {"bufferView": view, "uri": ""}]);
    let read = file.read(with(rest, json!({"textures": textures, "images": named})));
    assert!(read.materials.unwrap().all.iter().all(|material| material.image.is_some()));
}

#[test]
fn placements_are_texture_transforms() {
    let (offset, scale) = ([0.25, 0.5], [2.0, -3.0]);
    let transform = |transform: Value| {
        let image = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
        let more = json!({"textures": [{"source": 0, "sampler": 0}], "images": [{"uri": "a.png"}],
            "samplers": [{"wrapS": 33071, "wrapT": 33071}], "extensionsRequired": ["KHR_texture_transform"]});
        let (materials, mesh) = materials(json!([texture(image)]), more);
        (materials.all[0].placement, mesh.uv.unwrap())
    };
    let (placement, uv) = transform(json!({"offset": offset, "scale": scale}));
    assert!(placement.clamp);
    // In coordinates with t downwards, as the extension defines it.
    for [u, v] in uv.into_iter().flatten() {
        let [s, t] = [u, 1.0 - v];
        let expected = [offset[0] + scale[0] * s, 1.0 - (offset[1] + scale[1] * t)];
        assert_eq!(placement.of(&[[u, v]; 3])[0], expected);
    }
    let (rotated, _) = transform(json!({"rotation": 1.0, "scale": scale}));
    assert_eq!(rotated, Placement { clamp: true, ..Placement::default() });
    let (moved, other) = transform(json!({"offset": [1.0, 0.0], "texCoord": 1}));
    assert_eq!((moved.offset, moved.scale), ([1.0, 0.0], [1.0; 2]));
    assert_eq!(other, [[[0.0, -1.0]; 3]; 2]);
}

#[test]
fn base_colors_and_names() {
    let colored = |name: &str, color: Value| json!({"name": name, "pbrMetallicRoughness": {"baseColorFactor": color}});
    let read = |of: Value| {
        let (materials, _) = materials(of, json!({}));
        materials.all.into_iter().map(|m| (m.name, m.color)).collect::<Vec<_>>()
    };
    let red = Some([1.0, 0.0, 0.2]);
    let named = |name: &str, color| (name.to_owned(), color);
    let both = read(json!([colored("a\nb ", json!([1.0, 0.0, 0.2, 0.5])), {"name": "white"}]));
    assert_eq!(both, [named("a b", red), named("white", Some([1.0; 3]))]);
    assert_eq!(read(json!([{"name": "a"}, {"name": "a"}])), [named("a", None), named("a-1", None)]);
    assert_eq!(read(json!([{}])), [named("material-0", None)]);
    for odd in [json!([1.0, 2.0, 0.0, 1.0]), json!([1.0]), json!([-1, 0, 0, 1])] {
        assert_eq!(read(json!([colored("a", odd)])), [named("a", None)]);
    }
    let glossy = json!({"diffuseFactor": [1.0, 0.0, 0.2, 1.0]});
    let glossy = json!({"KHR_materials_pbrSpecularGlossiness": glossy});
    assert_eq!(read(json!([{"extensions": glossy}])), [named("material-0", red)]);
}

#[test]
fn what_cannot_be_read_besides_positions_and_faces_is_left_out() {
    let (mut file, mut rest) = painted(json!([{"name": "a"}, {"name": 1}]), json!({}));
    let colors = file.floats(&[[0.5; 3]; 3]);
    let whole = file.read(rest.clone());
    let uv = whole.uv.unwrap();
    let materials = whole.materials.unwrap();
    assert_eq!(
        materials.all.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
        ["a", "material-1"]
    );
    // Too few elements, another type, and an accessor that does not exist.
    for (attribute, accessor) in [
        ("COLOR_0", colors),
        ("COLOR_0", 1),
        ("COLOR_0", 99),
        ("TEXCOORD_0", colors),
        ("TEXCOORD_0", 99),
    ] {
        let mut rest = rest.clone();
        rest["meshes"][0]["primitives"][1]["attributes"][attribute] = accessor.into();
        let mesh = file.read(rest);
        assert_eq!((&mesh.vertices, &mesh.faces), (&whole.vertices, &whole.faces));
        assert_eq!(mesh.colors, None);
        let mesh_uv = mesh.uv.unwrap();
        assert_eq!(mesh_uv[0], uv[0]);
        assert_eq!(mesh_uv[1][0][0].is_nan(), attribute == "TEXCOORD_0");
    }
    rest["meshes"][0]["primitives"][1]["material"] = 2.into();
    assert_eq!(file.read(rest).materials.unwrap().of_faces, [Some(0), None]);
}
