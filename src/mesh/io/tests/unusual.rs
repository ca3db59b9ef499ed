//! Unusual but valid files.

use super::read;
use crate::mesh::Mesh;
use crate::mesh::io::Format::{Obj, Off, Ply, Stl};

/// The mesh must be a square of two triangles.
fn assert_square(mesh: &Mesh, context: &str) {
    let corners: Vec<[f64; 3]> = mesh.vertices.iter().map(|&x| x.into()).collect();
    let expected = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(corners, expected, "{context}");
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]], "{context}");
}

const SQUARE_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
const SQUARE_OFF: &str = "OFF\n4 1 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
const SQUARE_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
const SQUARE_STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n\
    endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\n\
    endloop\nendfacet\nendsolid\n";

#[test]
fn line_ends_blanks_and_byte_order_marks() {
    for (format, text) in
        [(Obj, SQUARE_OBJ), (Off, SQUARE_OFF), (Ply, SQUARE_PLY), (Stl, SQUARE_STL)]
    {
        let variants = [
            text.to_string(),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r"),
            text.trim_end().to_string(),
            format!("\u{feff}{text}"),
            text.replace('\n', " \t\n"),
            format!("{text}\n\n  \n"),
        ];
        for variant in variants {
            assert_square(&read(format, &variant).unwrap(), &format!("{variant:?}"));
        }
        if format != Ply {
            let indented = text.replace('\n', "\n\n\t ").replace(' ', "  ");
            assert_square(&read(format, &indented).unwrap(), &indented);
        }
        // Line ends do not matter in PLY files, nor in positions and indices of OFF files.
        if let Some((head, body)) = text.split_once("end_header\n") {
            let broken = format!("{head}end_header\n{}", body.replace(' ', "\n"));
            assert_square(&read(format, broken).unwrap(), "a word a line");
            let joined = format!("{head}end_header\n{}", body.replace('\n', " "));
            assert_square(&read(format, joined).unwrap(), "one line");
        }
        if format == Off {
            let broken = text.replace("1 0 0\n", "1\n 0\n0 \n").replace("4 0 1 2 3", "4 0\n1 2\n3");
            assert_square(&read(format, broken).unwrap(), "broken lines");
        }
    }
}

#[test]
fn numbers_in_every_notation() {
    let points = "v +0 0.0e5 -0\nv 1e0 .0 0.\nv 1.0E+00 100e-2 0e-999\nv -0.0 +1. 1e-999\n";
    for notation in ["f 1 2 3 4", "f +1 2 3 4", "f 01 02 03 04"] {
        let mesh = read(Obj, format!("{points}{notation}")).unwrap();
        assert_square(&mesh, notation);
    }
}

#[test]
fn obj_indices_in_every_form() {
    let head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n";
    // The vertices that get texture coordinates, in every face or only in the first.
    let (none, all) = ([false; 4], [true; 4]);
    for (form, has_uv) in [
        ("f 1 2 3 4", none),
        ("f -4 -3 -2 -1", none),
        ("f 1//1 2//1 3//1 4//1", none),
        ("f 1/ 2/ 3/ 4/", none),
        ("f 1/1 2/2 3/3 4/4", all),
        ("f 1/-4/-1 2/-3/-1 3/-2/1 4/-1/1", all),
        ("f 1/1 2/2 3/3\nf 1/1 3/3 4/4", all),
        ("f 1/1 2/2 3/3\nf 1 3 4", [true, true, true, false]),
        ("f 1/1 2/2 3 4/4", [true, true, false, true]),
        ("f 1 2 \\\n 3 4", none),
        ("f 1 2\\\r\n 3 4 # the end \\", none),
        ("g all # f 1\ns off\nusemtl x\nl 1 2\np 1\no f\nf\t1 2 3 4#", none),
        ("l 1 \\\n2 \\\n3\n f 1 2 3 4", none),
        ("# C:\\\nf 1 2 3 4", none),
    ] {
        let mesh = read(Obj, format!("{head}{form}\n")).unwrap();
        assert_square(&mesh, form);
        let unit = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        assert_eq!(mesh.uv.is_some(), has_uv != none, "{form}");
        let only_first = form.contains("f 1 3 4");
        for (j, (face, uv)) in mesh.faces.iter().zip(mesh.uv.unwrap_or_default()).enumerate() {
            for (&k, t) in face.iter().zip(uv) {
                let known = has_uv[k as usize] && !(only_first && j == 1);
                assert!(if known { t == unit[k as usize] } else { t[0].is_nan() }, "{form}");
            }
        }
    }
    // Faces may come before their vertices.
    assert_square(&read(Obj, format!("f 1 2 3 4\n{head}")).unwrap(), "first");
}

/// A vertex at a seam stays one vertex.
#[test]
fn obj_seams_split_nothing() {
    let mesh = read(
        Obj,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt .5\nvt .5 .5 0\nf 1/1 2/2 3/3\nf 1/3 3/2 4/1",
    )
    .unwrap();
    assert_square(&mesh, "seam");
    let uv = [[[0., 0.], [0.5, 0.], [0.5, 0.5]], [[0.5, 0.5], [0.5, 0.], [0., 0.]]];
    assert_eq!(mesh.uv.unwrap(), uv);
}

#[test]
fn obj_vertices_with_weights_and_colors() {
    let faces = "f 1 2 3 4";
    for (extra, color) in [
        ("1", None),
        ("0.5 0 1", Some([0.5, 0.0, 1.0])),
        ("0.5 0 1.0000001 1", Some([0.5, 0.0, 1.0])),
    ] {
        let points = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].map(|x| format!("v {x} {extra}\n"));
        let mesh = read(Obj, points.concat() + faces).unwrap();
        assert_square(&mesh, extra);
        assert_eq!(mesh.colors, color.map(|color| vec![color; 4]));
    }
}

#[test]
fn off_headers_and_comments() {
    let body = "0 0 0\n1 0 0\n1 1 0 # corner\n\n# between\n0 1 0\n4 0 1 2 3 255 0 0 # red\n";
    for head in [
        "OFF\n4 1 4\n",
        "OFF 4 1 4\n",
        "OFF4 1 4\n",
        "OFF4 1\n",
        "OFF 4 1\n",
        "# first\nOFF # here\n# then\n\n4 1 0\n",
    ] {
        assert_square(&read(Off, format!("{head}{body}")).unwrap(), head);
    }
}

#[test]
fn off_vertex_extras() {
    let points = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];
    for (keyword, extra, color, texture) in [
        ("NOFF", "0 nan 1", None, None),
        ("OFF", "255 0 51 255", Some([1.0, 0.0, 0.2]), None),
        ("OFF", "1.0 0 0.2", Some([1.0, 0.0, 0.2]), None),
        ("COFF", "255 0 51 255", Some([1.0, 0.0, 0.2]), None),
        ("COFF", "1 0 0.2", Some([1.0, 0.0, 0.2]), None),
        ("STOFF", "0.5 2", None, Some([0.5, 2.0])),
        ("CNOFF", "0 0 1 1 0 0.2 1", Some([1.0, 0.0, 0.2]), None),
        ("NCOFF", "0 0 1 1 0 0.2", Some([1.0, 0.0, 0.2]), None),
        ("STCNOFF", "0 0 1 1 0 0.2 1 .5 2", Some([1.0, 0.0, 0.2]), Some([0.5, 2.0])),
    ] {
        let lines = points.map(|x| format!("{x} {extra}\n")).concat();
        let mesh = read(Off, format!("{keyword}\n4 1 0\n{lines}4 0 1 2 3\n")).unwrap();
        assert_square(&mesh, keyword);
        assert_eq!(mesh.colors, color.map(|color| vec![color; 4]), "{keyword}");
        assert_eq!(mesh.uv, texture.map(|t| vec![[t; 3]; 2]), "{keyword}");
    }
}

#[test]
fn ply_elements_in_any_order_with_unknown_ones_between() {
    let text = "ply\ncomment \u{e9}\nformat ascii 1.0\nobj_info made by hand\nelement nothing 1000000000000\n\
        element face 2\nproperty uchar flag\nproperty list uint8 float weight\n\
        property list int16 uint32 vertex_index\n\
        element edge 1\nproperty int a\nproperty list ushort double b\n\
        element vertex 4\nproperty float nx\nproperty double z\nproperty int8 x\nproperty list char char tags\n\
        property float64 y\nend_header\n\
        7 0 3 0 1 2\n7 2 .5 nan 3 0 2 3\n5 1 1e999\nnan 0 0 0 0\n-nan(ind) 0 1 1 9 0\n0 0 1 0 1\n0 0 0 2 1 2 1\n";
    assert_square(&read(Ply, text).unwrap(), "order");
}

#[test]
fn ply_colors_of_every_type() {
    for (kind, names, values) in [
        ("uchar", "", "255 0 51"),
        ("ushort", "", "65535 0 13107"),
        ("float", "", "1 0 0.2"),
        ("float", "", "255.0 0 51"),
        ("double", "diffuse_", "1.0000001 -0 0.2"),
        ("int", "diffuse_", "255 0 51"),
    ] {
        let color = ["red", "green", "blue"].map(|c| format!("property {kind} {names}{c}\n"));
        let text = SQUARE_PLY
            .replace("element face", &format!("{}element face", color.concat()))
            .replace(" 0\n", &format!(" 0 {values}\n"))
            .replace(&format!("1.0 {values}\n"), "1.0\n");
        let mesh = read(Ply, &text).unwrap();
        assert_square(&mesh, kind);
        assert_eq!(mesh.colors.unwrap(), [[1.0, 0.0, 0.2]; 4], "{kind}");
    }
}

#[test]
fn ply_texture_coordinates_of_vertices_and_corners() {
    for names in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let properties = names.map(|name| format!("property float {name}\n")).concat();
        let text = SQUARE_PLY
            .replace("element face", &format!("{properties}element face"))
            .replace(" 0\n", " 0 0.25 0.5\n");
        let mesh = read(Ply, &text).unwrap();
        assert_eq!(mesh.uv.unwrap(), [[[0.25, 0.5]; 3]; 2]);
    }
    let corners = SQUARE_PLY
        .replace("end_header", "property list uchar float texcoord\nend_header")
        .replace("4 0 1 2 3", "4 0 1 2 3 8 0 0 1 0 1 1 0 1");
    let uv = read(Ply, &corners).unwrap().uv.unwrap();
    let expected = [[[0., 0.], [1., 0.], [1., 1.]], [[0., 0.], [1., 1.], [0., 1.]]];
    assert_eq!(uv, expected);
    let none = corners.replace("8 0 0 1 0 1 1 0 1", "0");
    assert_eq!(read(Ply, &none).unwrap().uv, None);
}

/// Strips alternate their winding, -1 starts a new strip, and a repeated index is a stitch.
#[test]
fn ply_triangle_strips() {
    let strips = |list: &str| {
        let text =
            SQUARE_PLY.replace("element face", "element tristrips").replace("4 0 1 2 3", list);
        read(Ply, &text).unwrap().faces
    };
    assert_eq!(strips("4 0 1 2 3"), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(strips("8 0 1 2 -1 1 2 3 -1"), [[0, 1, 2], [1, 2, 3]]);
    assert_eq!(strips("7 0 1 2 2 2 3 0"), [[0, 1, 2], [2, 3, 0]]);
}

/// The same square as bytes of either order.
#[test]
fn ply_binary_in_both_orders() {
    for big in [false, true] {
        let order = |bytes: &mut [u8]| {
            if big {
                bytes.reverse();
            }
        };
        let name = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\nformat binary_{name}_endian 1.0\nelement vertex 4\nproperty float x\nproperty short y\n\
             property double z\nproperty uint unused\nelement face 1\nproperty list ushort int vertex_indices\n\
             end_header\n"
        )
        .into_bytes();
        for (x, y) in [(0.0_f32, 0_i16), (1.0, 0), (1.0, 1), (0.0, 1)] {
            let mut x = x.to_le_bytes();
            let mut y = y.to_le_bytes();
            order(&mut x);
            order(&mut y);
            bytes.extend(x);
            bytes.extend(y);
            bytes.extend([0; 8 + 4]);
        }
        let mut count = 4_u16.to_le_bytes();
        order(&mut count);
        bytes.extend(count);
        for k in 0..4_i32 {
            let mut k = k.to_le_bytes();
            order(&mut k);
            bytes.extend(k);
        }
        assert_square(&read(Ply, &bytes).unwrap(), name);
        bytes.extend(b"\0\0\r\n");
        assert_square(&read(Ply, &bytes).unwrap(), "padded");
    }
}

#[test]
fn stl_of_both_kinds() {
    let shouted = SQUARE_STL.to_uppercase().replace("NORMAL 0 0 1", "NORMAL NAN 0 -NAN(IND)");
    assert_square(&read(Stl, shouted).unwrap(), "upper case");
    let named = SQUARE_STL.replace("solid", "solid of facet").replace("vertex 0 0", "vertex -0 0");
    assert_square(&read(Stl, &named).unwrap(), "named");
    let parts = named.replacen("endfacet\n", "endfacet\nendsolid\nsolid b\n", 1);
    assert_square(&read(Stl, parts).unwrap(), "two solids");
    let joined = SQUARE_STL.replace('\n', " ").replacen("solid ", "solid a\n", 1);
    assert_square(&read(Stl, joined).unwrap(), "all on one line");
    let apart = SQUARE_STL.replace(' ', "\n");
    assert_square(&read(Stl, apart).unwrap(), "every word on its own");
    let bare = SQUARE_STL.replace(" normal 0 0 1", "");
    assert_square(&read(Stl, bare).unwrap(), "without normals");

    let mut binary = super::written(Stl, &read(Stl, SQUARE_STL).unwrap());
    assert_square(&read(Stl, &binary).unwrap(), "binary");
    binary[..5].copy_from_slice(b"solid");
    assert_square(&read(Stl, &binary).unwrap(), "binary that says solid");
    binary[5..80].fill(b' ');
    assert_square(&read(Stl, &binary).unwrap(), "binary that says solid in blanks");
    // The sign of zero does not make a new vertex.
    let at = 84 + 12;
    binary[at..at + 4].copy_from_slice(&(-0.0_f32).to_le_bytes());
    assert_square(&read(Stl, &binary).unwrap(), "minus zero");
}

#[test]
fn ply_integers_of_64_bits() {
    for (signed, unsigned) in [("int64", "uint64"), ("longlong", "ulonglong")] {
        let text = SQUARE_PLY
            .replace(
                "property float z\n",
                &format!("property {signed} z\nproperty {unsigned} id\n"),
            )
            .replace(" 0\n", " 0 18446744073709551615\n")
            .replace("uchar int", &format!("{unsigned} {signed}"))
            .replace("1.0 18446744073709551615", "1.0");
        assert_square(&read(Ply, &text).unwrap(), signed);
        for big in [false, true] {
            let name = if big { "big" } else { "little" };
            let (header, _) = text.split_once("0 0 0 184").unwrap();
            let mut bytes = header
                .replace("ascii", &format!("binary_{name}_endian"))
                .replace("property float", "property double")
                .into_bytes();
            let ordered = |mut bytes: [u8; 8]| {
                if big {
                    bytes.reverse();
                }
                bytes
            };
            for (x, y) in [(0.0_f64, 0.0_f64), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                bytes.extend(ordered(x.to_le_bytes()));
                bytes.extend(ordered(y.to_le_bytes()));
                bytes.extend([0; 8]);
                bytes.extend([0xff; 8]);
            }
            for n in [4_u64, 0, 1, 2, 3] {
                bytes.extend(ordered(n.to_le_bytes()));
            }
            assert_square(&read(Ply, &bytes).unwrap(), name);
            // More than any file can hold.
            let count = bytes.len() - 40;
            bytes[count..count + 8].fill(0xff);
            assert!(read(Ply, &bytes).is_err());
        }
    }
}
