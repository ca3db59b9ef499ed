//! Mesh files as other programs write them: what is read, what is left out with a warning, what survives a conversion.

use std::fs;
use std::path::{Path, PathBuf};

use meshseg::Mesh;
use meshseg::mesh::{Image, io};

use crate::support::{Folder, stderr};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name)
}

fn read(name: &str) -> Mesh {
    io::read(&case(name)).unwrap()
}

/// The warnings of `mesh info` about a file.
fn warnings(name: &str) -> String {
    let line = format!("mesh info {}", case(name).display().to_string().replace(' ', "%20"));
    let output = Folder::new().run(&line.replacen("mesh%20info%20", "mesh info ", 1));
    assert_eq!(output.status.code(), Some(0), "{name}: {}", stderr(&output));
    stderr(&output)
}

/// Colors as bytes; `None` if unknown.
fn bytes(color: &[f64; 3]) -> Option<[u8; 3]> {
    (!color[0].is_nan()).then(|| color.map(|c| (255.0 * c).round() as u8))
}

const RED: Option<[u8; 3]> = Some([200, 40, 40]);
const BLUE: Option<[u8; 3]> = Some([40, 40, 200]);
/// The same two as 0.8 and 0.2.
const FLOAT_RED: Option<[u8; 3]> = Some([204, 51, 51]);
const FLOAT_BLUE: Option<[u8; 3]> = Some([51, 51, 204]);

/// Each file is the square of 12 x 12 cells whose left half is red.
#[test]
fn colors_are_read_in_every_notation() {
    for (name, red, blue) in [
        ("03-obj-rgb255/scan.obj", RED, BLUE),
        ("06-ply-int64/ids.ply", RED, BLUE),
        ("06-ply-int64/faces.ply", RED, BLUE),
        ("07-vt-nan/colored.obj", FLOAT_RED, FLOAT_BLUE),
        ("11-ply-multiline/depth.ply", RED, BLUE),
        ("29-two-corner-face/m.obj", FLOAT_RED, Some([204, 204, 51])),
        ("29-two-corner-face/m.ply", RED, BLUE),
        ("30-mrgb/sculpt.obj", RED, BLUE),
        ("31-f-without-vt/cube.obj", FLOAT_RED, Some([204, 204, 51])),
        ("32-off-color-no-coff/tin.off", RED, BLUE),
        ("33-ply-rgba-float/a.ply", FLOAT_RED, FLOAT_BLUE),
        ("33-ply-rgba-float/f255.ply", RED, BLUE),
    ] {
        let mesh = read(name);
        assert_eq!((mesh.vertices.len(), mesh.faces.len()), (169, 288), "{name}");
        assert!((mesh.area() - 1.0).abs() < 1e-5, "{name}");
        for (x, color) in mesh.vertices.iter().zip(mesh.colors.as_ref().unwrap()) {
            let expected = if x.x < 0.49 { red } else { blue };
            assert_eq!(bytes(color), expected, "{name}");
        }
    }
}

#[test]
fn colors_of_some_vertices_and_of_faces() {
    let scene = read("09-obj-some-colored/scene.obj");
    let colors = scene.colors.unwrap();
    assert_eq!(colors.len(), 338);
    assert!(colors[..169].iter().all(|color| bytes(color).is_none()));
    assert!(colors[169..].iter().all(|color| [FLOAT_RED, FLOAT_BLUE].contains(&bytes(color))));
    let messages = warnings("09-obj-some-colored/scene.obj");
    assert!(messages.contains("169 of 338 vertices have no color"), "{messages}");
    assert_eq!(messages.lines().count(), 1, "{messages}");

    let painted = read("12-ply-face-colors/painted.ply");
    let colors = painted.face_colors.as_ref().unwrap();
    for (j, color) in colors.iter().enumerate() {
        let middle = painted.corners(j).iter().map(|x| x.x).sum::<f64>() / 3.0;
        assert_eq!(bytes(color), if middle < 0.5 { RED } else { BLUE });
    }
    assert!(painted.colors.is_none());
}

#[test]
fn off_may_have_the_counts_in_the_line_of_the_keyword() {
    let mesh = read("01-off-glued/part.off");
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (169, 288));
    assert_eq!(warnings("01-off-glued/part.off"), "");
}

#[test]
fn concave_polygons_keep_their_area() {
    let folder = Folder::new();
    for (name, area) in [("ell", 3.0), ("dart", 2.0)] {
        let mesh = read(&format!("04-concave/{name}.obj"));
        assert!((mesh.area() - area).abs() < 1e-14);
        assert!((0..mesh.faces.len()).all(|j| mesh.area_vector(j).z > 0.0));
        // Starting at other corners, and reversed.
        let text = fs::read_to_string(case(&format!("04-concave/{name}.obj"))).unwrap();
        let (points, face) = text.trim_end().rsplit_once("f ").unwrap();
        let mut corners: Vec<&str> = face.split(' ').collect();
        for turn in 0..2 * corners.len() {
            corners.rotate_left(1);
            if turn == corners.len() {
                corners.reverse();
            }
            folder.write("turned.obj", format!("{points}f {}\n", corners.join(" ")));
            let mesh = io::read(&folder.path("turned.obj")).unwrap();
            assert!((mesh.area() - area).abs() < 1e-14, "{name} {corners:?}");
        }
    }
}

#[test]
fn unusable_attributes_are_left_out_with_a_warning() {
    for (name, part) in [
        ("07-vt-nan/textured.obj", "(1, the first: line 170)"),
        ("07-vt-nan/textured.obj", "2 of 288 faces have corners without texture coordinates"),
        ("10-obj-some-uv/model.obj", "4 of 288 faces have corners without texture coordinates"),
        ("29-two-corner-face/m.obj", "fewer than 3 corners are left out (1, the first: line 458)"),
        ("29-two-corner-face/m.off", "fewer than 3 corners are left out (1, the first: line 460)"),
        ("29-two-corner-face/m.ply", "fewer than 3 corners are left out (2, the first: face 288)"),
        ("31-f-without-vt/cube.obj", "the file has none"),
    ] {
        let messages = warnings(name);
        assert!(messages.contains(part), "{name}: {messages}");
    }
    let textured = read("07-vt-nan/textured.obj").uv.unwrap();
    assert_eq!(textured.as_flattened().iter().filter(|t| t[0].is_nan()).count(), 2);
    let model = read("10-obj-some-uv/model.obj").uv.unwrap();
    assert_eq!(model.iter().filter(|face| face.iter().all(|t| t[0].is_nan())).count(), 4);
    assert_eq!(read("31-f-without-vt/cube.obj").uv, None);
    assert_eq!(read("29-two-corner-face/m.off").faces.len(), 288);
}

#[test]
fn each_face_has_its_material() {
    for (name, images) in [
        ("02-obj-two-materials/house.obj", Some(["roof.png", "wall.png"])),
        ("13-ply-texnumber/model.ply", Some(["page0.png", "page1.png"])),
        ("40-materials-kd/toy.obj", None),
    ] {
        let mesh = read(name);
        let materials = mesh.materials.as_ref().unwrap();
        let folder = case(name).parent().unwrap().to_owned();
        let found: Vec<_> = materials.all.iter().map(|m| m.image.clone()).collect();
        let expected = images.map(|names| names.map(|name| Image::File(folder.join(name))));
        assert_eq!(found, expected.map_or(vec![None; 2], |paths| paths.map(Some).to_vec()));
        assert!(found.iter().flatten().all(|image| image.path().is_file()));
        for j in 0..mesh.faces.len() {
            let middle = mesh.corners(j).iter().map(|x| x.x).sum::<f64>() / 3.0;
            assert_eq!(materials.of_faces[j], Some(u32::from(middle > 0.5)), "{name}");
        }
        assert_eq!(warnings(name), "");
    }
    let toy = read("40-materials-kd/toy.obj").materials.unwrap();
    assert_eq!(toy.all[0].color, Some([0.8, 0.2, 0.2]));
    assert_eq!(toy.all[1].color, Some([0.2, 0.2, 0.8]));
}

#[test]
fn a_missing_library_is_a_warning() {
    let folder = Folder::new();
    folder.write("a.obj", "mtllib no such.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    let output = folder.run("mesh info a.obj");
    assert_eq!(output.status.code(), Some(0));
    let messages = stderr(&output);
    assert!(messages.contains("no such.mtl") && messages.lines().count() == 1, "{messages}");
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(shown.contains("materials                      1, 0 with an image"), "{shown}");
}

#[test]
fn materials_survive_a_conversion_or_their_loss_is_reported() {
    let folder = Folder::new();
    fs::create_dir(folder.path("in")).unwrap();
    for name in ["house.obj", "house.mtl", "roof.png", "wall.png"] {
        let from = case("02-obj-two-materials").join(name);
        fs::copy(from, folder.path(&format!("in/{name}"))).unwrap();
    }
    folder.done("mesh convert in/house.obj --out h.obj --subdivide 1");
    let library = fs::read_to_string(folder.path("h.mtl")).unwrap();
    assert!(library.contains("map_Kd in/roof.png"), "{library}");
    let text = fs::read_to_string(folder.path("h.obj")).unwrap();
    assert!(text.starts_with("mtllib h.mtl\n"));
    for name in ["h.obj", "h.ply"] {
        let output = folder.run(&format!("mesh convert h.obj --out {name}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let mesh = io::read(&folder.path(name)).unwrap();
        let materials = mesh.materials.unwrap();
        assert_eq!(mesh.faces.len(), 4 * 288);
        for (place, image) in ["in/roof.png", "in/wall.png"].into_iter().enumerate() {
            assert_eq!(materials.all[place].image, Some(Image::File(folder.path(image))), "{name}");
            let faces = materials.of_faces.iter().filter(|m| **m == Some(place as u32));
            assert_eq!(faces.count(), 4 * 144);
        }
        assert!(mesh.uv.is_some());
    }
    for (name, parts) in [
        ("h.ply", &["names and colors of materials"][..]),
        ("h.off", &["texture coordinates", "materials (OBJ holds them)"]),
        ("h.stl", &["texture coordinates", "materials (OBJ holds them)"]),
    ] {
        let messages = stderr(&folder.run(&format!("mesh convert h.obj --out {name}")));
        assert!(parts.iter().all(|part| messages.contains(part)), "{messages}");
        assert_eq!(messages.lines().count(), 2, "{messages}");
    }
}

/// A scan on a map: 1681 vertices, 5 cm apart, at 5 million meters from the origin.
#[test]
fn stl_far_from_the_origin_gets_a_local_origin() {
    let folder = Folder::new();
    let mut text = String::new();
    for k in 0..41 * 41 {
        let (i, j) = (f64::from(k % 41), f64::from(k / 41));
        text += &format!(
            "v {} {} {}\n",
            448_262.25 + 0.05 * i,
            5_411_932.5 + 0.05 * j,
            311.9 + 0.2 * (0.3 * i).sin()
        );
    }
    for k in 0..40 * 40 {
        let a = k / 40 * 41 + k % 40 + 1;
        text += &format!("f {} {} {} {}\n", a, a + 1, a + 42, a + 41);
    }
    folder.write("site.obj", text);
    let output = folder.run("mesh convert site.obj --out site.stl");
    assert_eq!(output.status.code(), Some(0));
    let messages = stderr(&output);
    assert!(messages.contains("relative to the origin 448263.0 5411934.0 312.0"), "{messages}");
    let (site, stl) = (read_in(&folder, "site.obj"), read_in(&folder, "site.stl"));
    assert_eq!((stl.vertices.len(), stl.faces.len()), (1681, 3200));
    assert!((stl.area() - site.area()).abs() < 1e-6 * site.area());
    // Relative to the local origin, the coordinates are small enough.
    assert_eq!(stderr(&folder.run("mesh convert site.stl --out again.stl")).lines().count(), 1);
}

fn read_in(folder: &Folder, name: &str) -> Mesh {
    io::read(&folder.path(name)).unwrap()
}

/// The messages about a mesh file with that name and content.
fn messages_about(name: &str, text: &str) -> String {
    let folder = Folder::new();
    folder.write(name, text);
    let output = folder.run(&format!("mesh info {name}"));
    assert_eq!(output.status.code(), Some(0), "{text}: {}", stderr(&output));
    stderr(&output)
}

/// Two triangles of an OFF file, with text after the corners of each.
fn off(faces: [&str; 2]) -> String {
    let [a, b] = faces;
    format!("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 {a}\n3 0 2 3 {b}\n")
}

#[test]
fn invalid_colors_of_off_faces_are_left_out() {
    let indexed = messages_about("a.off", &off(["7", "12"]));
    assert!(
        indexed.contains("indices into a color map") && indexed.contains("(2, the first: line 7)"),
        "{indexed}"
    );
    assert_eq!(indexed.lines().count(), 1, "{indexed}");
    let odd = messages_about("a.off", &off(["1 2", "0.5"]));
    assert!(odd.contains("values after the corners of faces"), "{odd}");
    assert!(odd.contains("(2, the first: line 7)"), "{odd}");
    assert_eq!(messages_about("a.off", &off(["255 0 0", "0 0 255 128"])), "");
}

/// A file has one range of colors; a warning reports files that seem to have both.
#[test]
fn colors_of_two_ranges_in_one_file() {
    let vertices = |colors: [&str; 4]| {
        let lines = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].iter().zip(colors);
        lines.map(|(x, color)| format!("v {x} {color}\n")).collect::<String>() + "f 1 2 3 4\n"
    };
    let ply = |colors: [&str; 4]| {
        let lines = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].iter().zip(colors);
        let body: String = lines.map(|(x, color)| format!("{x} {color}\n")).collect();
        let properties =
            ["x", "y", "z", "red", "green", "blue"].map(|name| format!("property float {name}\n"));
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\n{}element face 1\nproperty list uchar int vertex_indices\n\
             end_header\n{body}4 0 1 2 3\n",
            properties.concat()
        )
    };
    let mixed = ["200 0 0", "0 255 0", "0.5 0.25 1", "0 0 0"];
    for (messages, place) in [
        (messages_about("a.obj", &vertices(mixed)), "line 3"),
        (messages_about("a.ply", &ply(mixed)), "vertex 2"),
        (messages_about("a.off", &off(["255 0 0", "0.5 0.25 1.0"])), "line 8"),
    ] {
        assert!(
            messages.contains("go up to 2") && messages.contains("some look like fractions of 1"),
            "{messages}"
        );
        assert!(messages.contains(&format!("(1, the first: {place})")), "{messages}");
    }
    // A few integers among many numbers up to 1.
    let few = ["1 0 0", "0 255 0", "0 1 1", "0 0 0"];
    for (messages, place) in [
        (messages_about("a.obj", &vertices(few)), "line 2"),
        (messages_about("a.ply", &ply(few)), "vertex 1"),
    ] {
        assert!(
            messages.contains("go up to 255") && messages.contains("few are above 1"),
            "{messages}"
        );
        assert!(messages.contains(&format!("(1, the first: {place})")), "{messages}");
    }
    // Only the invalid color is left out.
    let odd = messages_about("a.ply", &ply(["1 0 0", "0 1 0", "-0.5 0.25 1", "0 0 0"]));
    assert!(
        odd.contains("outside [0, 1] or [0, 255] are left out (1, the first: vertex 2)"),
        "{odd}"
    );
    assert!(odd.contains("1 of 4 vertices have no color and are unknown"), "{odd}");
    // Fractions below and above 1 are in one range, and so are integers.
    for colors in [
        ["200.5 0 0", "0 254.9 0", "0.5 0.25 1", "0 0 0"],
        ["200 0 0", "0 255 0", "1 0 1", "0 0 0"],
        ["0.25 0 0", "0 1 0", "0.5 0.25 1", "0 0 0"],
    ] {
        assert_eq!(messages_about("a.obj", &vertices(colors)), "");
        assert_eq!(messages_about("a.ply", &ply(colors)), "");
    }
}

/// Texture coordinates that are finite but far outside of any image.
#[test]
fn texture_coordinates_beyond_all_images() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1e30 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property double s\nproperty double t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 0 0\n1 0 0 1e30 0\n0 1 0 0 1\n3 0 1 2\n";
    let off = "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1e30 0\n0 1 0 0 1\n3 0 1 2\n";
    for (name, text, place) in
        [("a.obj", obj, "line 5"), ("a.ply", ply, "vertex 1"), ("a.off", off, "line 4")]
    {
        let messages = messages_about(name, text);
        let expected = format!("or are beyond 1e9, are unknown (1, the first: {place})");
        assert!(messages.contains(&expected), "{messages}");
        assert!(
            messages.contains("1 of 1 face has corners without texture coordinates"),
            "{messages}"
        );
        assert_eq!(messages.lines().count(), 2, "{messages}");
    }
}

#[test]
fn texture_coordinates_at_some_corners() {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4\n",
    );
    let convert = |out: &str| stderr(&folder.run(&format!("mesh convert a.obj --out {out}")));
    let messages = convert("a.ply");
    assert!(
        messages.contains("left out: the texture coordinates of 1 face that has them"),
        "{messages}"
    );
    let messages = convert("b.obj");
    assert!(
        messages.contains("1 of 2 faces have corners without") && !messages.contains("left out"),
        "{messages}"
    );
    let uv = |name: &str| io::read(&folder.path(name)).unwrap().uv.unwrap();
    let known = |uv: Vec<[[f64; 2]; 3]>| uv.concat().iter().filter(|t| !t[0].is_nan()).count();
    assert_eq!((known(uv("a.obj")), known(uv("b.obj")), known(uv("a.ply"))), (5, 5, 3));
    // A list with a single number is invalid.
    let messages = messages_about(
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n0 1 0\n\
         3 0 1 2 1 0.5\n",
    );
    assert!(messages.contains("texcoord does not have one pair per corner"), "{messages}");
}

/// Numbers are printed with their significant digits, whatever the unit of the mesh.
#[test]
fn meshes_of_any_scale_are_described_by_short_numbers() {
    for scale in ["1e-30", "1e-6", "1e6", "1e30"] {
        let folder = Folder::new();
        let mesh = "grid:8x8".parse::<meshseg::mesh::Shape>().unwrap().mesh();
        io::write(&folder.path("m.off"), &mesh.scaled(scale.parse().unwrap())).unwrap();
        let data =
            ndarray::Array2::from_shape_fn((81, 1), |(k, _)| if k < 40 { 2e-9 } else { 5e20 });
        folder.array("d.npy", &data);
        folder.array("S.npy", &crate::support::costs(81, 2));
        let mut printed = vec![folder.done("mesh info m.off")];
        let lambda = format!("--lambda {scale}");
        for line in [
            "segment m.off --data d.npy --regions 2 --out a".to_owned(),
            "segment m.off --data d.npy --regions 2 --normalize none --out b".to_owned(),
            format!("solve m.off --costs S.npy {lambda} --out c"),
            format!("evaluate m.off --costs S.npy {lambda} --u c/u.npy"),
        ] {
            let output = folder.run(&line);
            assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
            printed.push(String::from_utf8(output.stdout.clone()).unwrap() + &stderr(&output));
        }
        for word in printed.iter().flat_map(|text| text.split_whitespace()) {
            let digits = word.bytes().filter(u8::is_ascii_digit).count();
            assert!(digits < 25, "{scale}: {word}");
        }
        assert!(
            !printed[0].contains(" 0.000000000\n") && !printed[0].contains("(-0.000000, "),
            "{}",
            printed[0]
        );
        assert!(printed[2].contains("5.00e20"), "{}", printed[2]);
    }
}
