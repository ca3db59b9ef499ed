//! Files with valid positions and faces whose other parts are invalid: these are left out.

use super::{PLY, read};
use crate::mesh::io::Format::{self, Obj, Off, Ply};
use crate::mesh::{Image, Mesh};

/// A file with two concave polygons of areas 3 and 2.
fn concave(format: Format) -> String {
    let points = [
        "0 0 1", "2 0 1", "2 1 1", "1 1 1", "1 2 1", "0 2 1", "10 0 1", "13 1 1", "10 2 1",
        "11 1 1",
    ];
    let points = points.map(|x| format!("{x}\n"));
    match format {
        Obj => format!("v {}f 1 2 3 4 5 6\nf 7 8 9 10\n", points.join("v ")),
        Off => format!("OFF\n10 2 0\n{}6 0 1 2 3 4 5\n4 6 7 8 9\n", points.concat()),
        _ => format!(
            "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\nproperty float z\n\
             element face 2\nproperty list uchar int vertex_indices\nend_header\n{}6 0 1 2 3 4 5\n4 6 7 8 9\n",
            points.concat()
        ),
    }
}

#[test]
fn concave_polygons_are_cut_inside_themselves() {
    for format in [Obj, Off, Ply] {
        let mesh = read(format, concave(format)).unwrap();
        assert_eq!(mesh.faces.len(), 4 + 2);
        assert!((mesh.area() - 5.0).abs() < 1e-14, "{format:?}: {}", mesh.area());
        // No triangle is flipped.
        assert!((0..6).all(|j| mesh.area_vector(j).z > 0.0));
    }
    // Texture coordinates move with their corners.
    let textured = concave(Obj)
        .replace("f 1", "vt 0 0\nvt 2 0\nvt 2 1\nvt 1 1\nvt 1 2\nvt 0 2\nf 1")
        .replace("1 2 3 4 5 6", "1/1 2/2 3/3 4/4 5/5 6/6");
    let mesh = read(Obj, textured).unwrap();
    for (face, uv) in mesh.faces.iter().zip(mesh.uv.as_ref().unwrap()) {
        for (&k, t) in face.iter().zip(uv) {
            let x = mesh.vertices[k as usize];
            assert!(if k < 6 { *t == [x.x, x.y] } else { t[0].is_nan() });
        }
    }
}

fn obj(vertices: [&str; 3], rest: &str) -> Mesh {
    let points = ["0 0 0", "1 0 0", "0 1 0"];
    let lines = points.iter().zip(vertices).map(|(x, extra)| format!("v {x} {extra}\n"));
    read(Obj, lines.collect::<String>() + rest + "f 1 2 3\n").unwrap()
}

/// For comparison: NaN as -1.
fn rows(colors: Option<Vec<[f64; 3]>>) -> Option<Vec<[f64; 3]>> {
    colors.map(|rows| rows.iter().map(|c| c.map(|c| if c.is_nan() { -1.0 } else { c })).collect())
}

#[test]
fn colors_of_either_range_and_of_some_vertices() {
    let (red, dark, none) = ([1.0, 0.0, 0.2], [0.0, 0.2, 0.0], [-1.0; 3]);
    for (extras, expected) in [
        (["255 0 51", "0 51 0", "255 0 51 255"], Some([red, dark, red])),
        (["1 0 0.2", "", "0 0.2 0"], Some([red, none, dark])),
        (["1 0 0.2 0.5", "1", "0 nan 0"], Some([red, none, none])),
        (["1 0 0.2", "0 1", "0 0 0 0 0"], Some([red, none, none])),
        (["1 0 0.2", "red", "0 0.2 x"], Some([red, none, none])),
        // Slightly too bright, in fractions.
        (["1.25 0 0.2", "", "0 0.2 0"], Some([red, none, dark])),
        (["256 0 0", "0 0 0", "0 0 0"], Some([none, [0.0; 3], [0.0; 3]])),
        (["1 0 0.2", "-1 0 0", "1 0 0.2"], Some([red, none, red])),
        // Most colors are outside: they must be of another kind.
        (["-1 0 0", "256 0 0", "0 0 0"], None),
        (["nan 0 0", "", ""], None),
        (["1", "2", "x"], None),
    ] {
        let mesh = obj(extras, "");
        assert_eq!(rows(mesh.colors), expected.map(|rows| rows.to_vec()), "{extras:?}");
        assert_eq!(mesh.faces, [[0, 1, 2]]);
    }
}

#[test]
fn mrgb_colors() {
    let (red, dark) = ([1.0, 0.0, 0.2], [0.0, 0.2, 0.0]);
    for (text, expected) in [
        ("#MRGB ffff0033ff003300FFFF0033\n", Some([red, dark, red])),
        (
            "#MRGB ffff0033\n# other\n#MRGB ff003300\n#MRGB ffff0033ffffffff\n",
            Some([red, dark, red]),
        ),
        ("#MRGB ffff0033\n", Some([red, [-1.0; 3], [-1.0; 3]])),
        ("#MRGB ffff003\n", None),
        ("#MRGB ffff00zz\n", None),
        ("# MRGB\n", None),
    ] {
        let colors = rows(obj([""; 3], text).colors);
        assert_eq!(colors, expected.map(|rows| rows.to_vec()), "{text}");
    }
    // Colors in vertex lines take precedence.
    let both = obj(["0 0.2 0"; 3], "#MRGB ffff0033ffff0033ffff0033\n");
    assert_eq!(both.colors.unwrap(), [dark; 3]);
}

#[test]
fn obj_invalid_texture_coordinates() {
    for (rest, known) in [
        ("vt 0 0\nvt nan nan\nvt 1 1\nf 1/1 2/2 3/3\n", [true, false, true]),
        ("vt 0 0\nvt 1 inf\nvt 1 1\nf 1/1 2/2 3/3\n", [true, false, true]),
        ("vt 0 0\nvt\nvt 1 1\nf 1/1 2/2 3/3\n", [true, false, true]),
        ("vt 0 0\nvt x 0\nvt 1 1\nf 1/1/1 2/2 3/3/7\n", [true, false, true]),
        ("vt 0 0\nf 1/1 2/9 3/x\n", [true, false, false]),
        ("vt 0 0\nf 1/1 2/0 3/-7\n", [true, false, false]),
        ("vt 0 0\nf 1/1 2// 3//1\n", [true, false, false]),
    ] {
        let mesh = obj([""; 3], rest);
        assert_eq!(mesh.faces, [[0, 1, 2]; 2], "{rest}");
        let uv = mesh.uv.unwrap();
        assert_eq!(uv[0].map(|t| !t[0].is_nan() && !t[1].is_nan()), known, "{rest}");
        assert!(uv[1].iter().all(|t| t[0].is_nan()));
    }
    for rest in ["f 1/1/1 2/2/2 3/3/3\n", "f 1/x 2/0 3\n", "vt nan 0\nf 1/1 2/1 3/1\n"] {
        assert_eq!(obj([""; 3], rest).uv, None, "{rest}");
    }
}

#[test]
fn points_and_lines_among_the_faces() {
    let lines = obj([""; 3], "f 1 2\nf 3\nf\nusemtl a\n");
    assert_eq!(lines.faces, [[0, 1, 2]]);
    assert_eq!(lines.materials.unwrap().of_faces, [Some(0)]);
    let off = "OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 2\n0\n";
    assert_eq!(read(Off, off).unwrap().faces, [[0, 1, 2]]);
    let ply = PLY.replace("face 1", "face 4").replace("3 0 0 0\n", "2 0 0\n3 0 0 0\n1 0\n0\n");
    assert_eq!(read(Ply, ply).unwrap().faces, [[0, 0, 0]]);
}

#[test]
fn off_colors() {
    let off = |vertices: [&str; 3], faces: [&str; 2]| {
        let [a, b, c] = vertices;
        let [d, e] = faces;
        let text =
            format!("OFF\n3 2 0\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2 {d}\n3 2 1 0 {e}\n");
        let mesh = read(Off, text).unwrap();
        assert_eq!(mesh.faces, [[0, 1, 2], [2, 1, 0]]);
        (rows(mesh.colors), rows(mesh.face_colors))
    };
    let red = [1.0, 0.0, 0.2];
    let none = [-1.0; 3];
    assert_eq!(off(["255 0 51"; 3], ["7", ""]), (Some(vec![red; 3]), None));
    assert_eq!(off(["255 0 51", "1", ""], ["", ""]), (Some(vec![red, none, none]), None));
    assert_eq!(off([""; 3], ["255 0 51 0", "1 2"]), (None, Some(vec![red, none])));
    assert_eq!(off([""; 3], ["1.0 0 0.2", "a b c"]), (None, Some(vec![red, none])));
    assert_eq!(off(["300 0 0", "", ""], ["-1 0 0", ""]), (None, None));
    // Lines without the values that the keyword declares.
    for (keyword, extras) in [
        ("COFF", ["", "1 0 0.2", "1 0"]),
        ("STOFF", ["1", "1 inf", "0.5 0.5"]),
        ("NOFF", ["1 0", "", "0 0 1 1"]),
        ("STCNOFF", ["", "0 0 1 1 0 0.2 1 0.5 0.5", "x"]),
    ] {
        let [a, b, c] = extras;
        let text = format!("{keyword}\n3 1 0\n0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n");
        let mesh = read(Off, text).unwrap();
        assert_eq!(mesh.faces, [[0, 1, 2]]);
        let colored = keyword.contains('C').then(|| vec![none, red, none]);
        assert_eq!(rows(mesh.colors), colored, "{keyword}");
        if let Some([uv]) = mesh.uv.as_deref() {
            assert_eq!(uv.iter().filter(|t| **t == [0.5; 2]).count(), 1, "{keyword}");
            assert_eq!(uv.iter().filter(|t| t[0].is_nan()).count(), 2, "{keyword}");
        } else {
            assert!(!keyword.contains("ST"));
        }
    }
}

/// Three vertices and two faces with additional properties and values.
fn ply(
    of_vertices: &str,
    vertices: [&str; 3],
    of_faces: &str,
    faces: [&str; 2],
    head: &str,
) -> Mesh {
    let [a, b, c] = vertices;
    let [d, e] = faces;
    let text = format!(
        "ply\nformat ascii 1.0\n{head}element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         {of_vertices}element face 2\nproperty list uchar int vertex_indices\n{of_faces}end_header\n\
         0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2 {d}\n3 2 1 0 {e}\n"
    );
    let mesh = read(Ply, text).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [2, 1, 0]]);
    mesh
}

#[test]
fn ply_colors() {
    let properties = |kind: &str, names: [&str; 3]| {
        names.map(|name| format!("property {kind} {name}\n")).concat()
    };
    let (red, none) = ([1.0, 0.0, 0.2], [-1.0; 3]);
    let rgb = ["red", "green", "blue"];
    for (kind, names, value, odd, expected) in [
        ("float", ["r", "g", "b"], "1 0 0.2", "nan 0 0", Some(none)),
        ("double", rgb, "255 0 51", "0 0 -nan(ind)", Some(none)),
        ("uchar", ["r", "g", "b"], "255 0 51", "0 0 0", Some([0.0; 3])),
        ("ushort", rgb, "65535 0 13107", "0 0 0", Some([0.0; 3])),
        ("int", rgb, "255 0 51", "256 0 0", Some(none)),
        ("int", rgb, "255 0 51", "-1 0 0", Some(none)),
        ("float", rgb, "1 0 0.2", "1e30 0 0", Some(none)),
    ] {
        let of = properties(kind, names);
        let mesh = ply(&of, [value, odd, value], "", [""; 2], "");
        assert_eq!(rows(mesh.colors), expected.map(|odd| vec![red, odd, red]), "{kind} {odd}");
        let mesh = ply("", [""; 3], &of, [value, odd], "");
        assert_eq!(rows(mesh.face_colors), expected.map(|odd| vec![red, odd]), "{kind} {odd}");
    }
    // A list named `red` is not a color; of two properties with the same name the first counts.
    let list = "property list uchar uchar red\nproperty uchar green\nproperty uchar blue\n";
    assert_eq!(ply(list, ["1 9 9 9"; 3], "", [""; 2], "").colors, None);
    let twice = properties("uchar", rgb) + "property uchar red\n";
    assert_eq!(ply(&twice, ["255 0 51 7"; 3], "", [""; 2], "").colors.unwrap(), [red; 3]);
}

#[test]
fn ply_invalid_texture_coordinates() {
    let st = "property float s\nproperty float t\n";
    let uv = ply(st, ["0 1", "nan 0", "0 inf"], "", [""; 2], "").uv.unwrap();
    assert_eq!(uv[0].map(|t| t[0].is_nan()), [false, true, true]);
    assert_eq!((uv[0][0], uv[1][2]), ([0.0, 1.0], [0.0, 1.0]));
    let texcoord = "property list uchar float texcoord\n";
    let good = "6 0 0 1 0 1 1";
    for odd in
        ["5 0 0 0 0 0", "4 0 0 0 0", "0", "6 0 0 nan 0 0 0", "8 0 0 0 0 0 0 0 0", "6 0 0 x 0 0 0"]
    {
        let uv = ply("", [""; 3], texcoord, [odd, good], "").uv.unwrap();
        assert_eq!(uv[1], [[0., 0.], [1., 0.], [1., 1.]], "{odd}");
        assert!(uv[0].iter().any(|t| t[0].is_nan()), "{odd}");
    }
    assert_eq!(ply("", [""; 3], texcoord, ["0", "0"], "").uv, None);
    assert_eq!(ply("", [""; 3], "property float texcoord\n", ["0", "0"], "").uv, None);
}

#[test]
fn ply_images() {
    let number = "property int texnumber\n";
    let two = "comment TextureFile a b.png\ncomment made by hand\ncomment TextureFile sub/c.png\n";
    let materials = ply("", [""; 3], number, ["1", "0"], two).materials.unwrap();
    assert_eq!(materials.of_faces, [Some(1), Some(0)]);
    let names: Vec<_> = materials.all.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["a b.png", "sub/c.png"]);
    assert_eq!(materials.all[0].image, Some(Image::File("a b.png".into())));
    let odd = ply("", [""; 3], number, ["2", "-1"], two).materials.unwrap();
    assert_eq!(odd.of_faces, [None, None]);
    let one = ply("", [""; 3], "", [""; 2], "comment TextureFile a.png\n").materials.unwrap();
    assert_eq!(one.of_faces, [Some(0), Some(0)]);
    for head in [two, "", "comment TextureFile\n"] {
        assert_eq!(ply("", [""; 3], "", [""; 2], head).materials, None);
    }
    assert_eq!(ply("", [""; 3], number, ["1", "0"], "").materials, None);
}
