//! `segment --probabilities`, `--scores`, `--labels-in`: classes on vertices and faces, in every format.

use std::fs;
use std::io::Write;

use meshseg::mesh::{Mesh, Shape, io};
use ndarray::{Array1, Array2};
use ndarray_npy::{NpzWriter, read_npy, write_npy};

use crate::support::{Folder, names, stderr};

const MESH: &str = "torus:60x40";

fn mesh() -> Mesh {
    MESH.parse::<Shape>().unwrap().mesh()
}

/// Four parts of the torus, by the sides of its faces' middles.
fn truth(mesh: &Mesh) -> Vec<usize> {
    let part = |j: usize| {
        let [a, b, c] = mesh.corners(j);
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        2 * usize::from(middle.x > 0.0) + usize::from(middle.y > 0.0)
    };
    (0..mesh.faces.len()).map(part).collect()
}

/// A number from 0 to 1 that looks random.
fn noise(k: usize) -> f64 {
    let mut x = (k as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

/// Votes for four classes, one row per face: the true one leads on average only.
fn votes(truth: &[usize]) -> Array2<f64> {
    Array2::from_shape_fn((truth.len(), 4), |(j, p)| {
        let right = if truth[j] == p { 3.0 } else { 0.0 };
        (right + 6.0 * noise(4 * j + p)).floor()
    })
}

fn labels(folder: &Folder, file: &str) -> Array1<i32> {
    read_npy(folder.path(file)).unwrap()
}

fn right(labels: &Array1<i32>, truth: &[usize]) -> f64 {
    let right = labels.iter().zip(truth).filter(|&(&p, &q)| p as usize == q).count();
    right as f64 / truth.len() as f64
}

/// One command from votes of faces to labels of faces and of vertices, on either element, with certificates.
#[test]
fn votes_become_labels_of_faces_and_vertices() {
    let folder = Folder::new();
    let mesh = mesh();
    let truth = truth(&mesh);
    let votes = votes(&truth);
    folder.array("votes.npy", &votes);
    let most = |j: usize| {
        (1..4).fold(0, |best, p| if votes[[j, p]] > votes[[j, best]] { p } else { best })
    };
    let first: Array1<i32> = (0..truth.len()).map(|j| most(j) as i32).collect();
    assert!(right(&first, &truth) < 0.75, "{}", right(&first, &truth));
    for (on, rows) in [("faces", mesh.faces.len()), ("vertices", mesh.vertices.len())] {
        let text =
            folder.done(&format!("segment {MESH} --probabilities votes.npy --on {on} --out {on}"));
        for part in
            ["converged", "chosen for these probabilities", &format!("labels on {on}"), "relabeled"]
        {
            assert!(text.contains(part), "{part}\n{text}");
        }
        let expected = [
            "face_labels.npy",
            "labels.npy",
            "preview.png",
            "segmented.ply",
            "summary.json",
            "trace.csv",
            "u.npy",
        ];
        assert_eq!(names(&folder.path(on)), expected.map(String::from).into());
        let answer = folder.answer(on);
        assert_eq!(answer.u.dim(), (rows, 4));
        assert!(answer.number("relative_gap") <= 1e-4 && answer.number("lambda") > 0.0);
        assert!(answer.number("rounded_relative_gap") < 0.02);
        let of_faces = labels(&folder, &format!("{on}/face_labels.npy"));
        assert_eq!(of_faces.len(), mesh.faces.len());
        // Cuts of labels of vertices run through faces, of which one in thirty is at a border here.
        let least = if on == "faces" { 0.97 } else { 0.95 };
        assert!(right(&of_faces, &truth) > least, "{on}: {}", right(&of_faces, &truth));
        assert_eq!(labels(&folder, &format!("{on}/labels.npy")).len(), mesh.vertices.len());
        let shares = answer.summary["region_parameters"].as_array().unwrap().iter();
        let whole: f64 = shares.map(|class| class["share"].as_f64().unwrap()).sum();
        assert!((whole - 1.0).abs() < 1e-12);
        let written = io::read(&folder.path(&format!("{on}/segmented.ply"))).unwrap();
        assert!(written.faces == mesh.faces && written.vertices == mesh.vertices);
        let colors = written.face_colors.unwrap();
        let palette = |p: i32| meshseg::colormap::categorical(p as usize);
        for (color, &p) in colors.iter().zip(&of_faces) {
            assert!((0..3).all(|c| (color[c] - palette(p)[c]).abs() < 1.0 / 255.0));
        }
    }
    assert_eq!(folder.answer("faces").summary["on"], "faces");
}

/// Formats, votes, probabilities and scores with the same information give the same labels.
#[test]
fn every_format_gives_the_same_labels() {
    let folder = Folder::new();
    let votes = votes(&truth(&mesh())) + 1.0;
    let p = &votes / &votes.sum_axis(ndarray::Axis(1)).insert_axis(ndarray::Axis(1));
    folder.array("p.npy", &p);
    folder.array("votes.npy", &votes);
    folder.array("x.npy", &(p.mapv(f64::ln) + 3.0));
    write_npy(folder.path("p32.npy"), &p.mapv(|p| p as f32)).unwrap();
    let mut table = String::from("wall,roof,door,sky\n");
    for row in p.outer_iter() {
        table += &(row.iter().map(|p| format!("{p:?}")).collect::<Vec<_>>().join(", ") + "\n");
    }
    folder.write("p.csv", table);
    let mut npz = NpzWriter::new(fs::File::create(folder.path("p.npz")).unwrap());
    npz.add_array("names", &ndarray::arr1(&[1, 2, 3])).unwrap();
    npz.add_array("probabilities", &p).unwrap();
    npz.finish().unwrap();
    let common = format!("segment {MESH} --lambda 0.02 --no-preview");
    folder.done(&format!("{common} --probabilities p.npy --out expected"));
    let expected = labels(&folder, "expected/face_labels.npy");
    let energy = folder.answer("expected").number("energy");
    for given in [
        "--probabilities votes.npy",
        "--probabilities p.csv",
        "--probabilities p.npz",
        "--probabilities p32.npy",
        "--scores x.npy",
    ] {
        folder.done(&format!("{common} {given} --out found"));
        let found = folder.answer("found").number("energy");
        assert!((found - energy).abs() <= 2e-4 * energy, "{given}: {found} {energy}");
        let other = labels(&folder, "found/face_labels.npy");
        let differ = other.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert!(differ <= 2, "{given}: {differ}");
    }
    // A named first column that counts the rows is no class, and unknown rows may be words.
    let indexed = p.outer_iter().enumerate().map(|(j, row)| match j {
        7 => "7,NA,NA,NA,NA\n".to_owned(),
        _ => format!("{j},{:?},{:?},{:?},{:?}\n", row[0], row[1], row[2], row[3]),
    });
    folder
        .write("indexed.csv", format!("Face,wall,roof,door,sky\n{}", indexed.collect::<String>()));
    folder.done(&format!("{common} --probabilities indexed.csv --out found"));
    let answer = folder.answer("found");
    assert_eq!((answer.u.ncols(), answer.number("unknown_rows")), (4, 1.0));
    let other = labels(&folder, "found/face_labels.npy");
    assert!(other.iter().zip(&expected).filter(|(a, b)| a != b).count() <= 2);
    let output = folder.run(&format!("{common} --probabilities votes.npy --out found"));
    assert!(stderr(&output).contains("4800 faces do not sum to 1"), "{}", stderr(&output));
}

/// Labels of faces with two classes are optimal, by a certificate.
#[test]
fn two_classes_on_faces_are_optimal() {
    let folder = Folder::new();
    let p = Array2::from_shape_fn((4800, 2), |(j, p)| {
        let first = (0.3 + 0.4 * f64::from(u8::from(j < 2400)) + 0.3 * noise(j)).min(1.0);
        if p == 0 { first } else { 1.0 - first }
    });
    folder.array("p.npy", &p);
    folder
        .done(&format!("segment {MESH} --probabilities p.npy --lambda 0.05 --gap 1e-6 --out out"));
    let answer = folder.answer("out");
    assert_eq!(answer.number("rounded_relative_gap"), 0.0);
    assert!(answer.number("relative_gap") <= 1e-6);
}

/// Noisy labels, some unknown: the rest is smoothed and the unknown ones are filled in.
#[test]
fn labels_are_smoothed_and_filled_in() {
    let folder = Folder::new();
    let truth = truth(&mesh());
    let given: Array1<i32> = truth
        .iter()
        .enumerate()
        .map(|(j, &p)| match noise(j) {
            x if x < 0.15 => 9,
            x if x < 0.25 => -1,
            x if x < 0.45 => (40.0 * x) as i32 % 4,
            _ => p as i32,
        })
        .collect();
    write_npy(folder.path("labels.npy"), &given).unwrap();
    let unknown = given.iter().filter(|&&p| p == 9 || p == -1).count();
    let line = format!(
        "segment {MESH} --labels-in labels.npy --unknown 9 --confidence 0.8 --out out --no-preview"
    );
    let output = folder.run(&line);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        stderr(&output).contains(&format!("nothing is known of {unknown} faces")),
        "{}",
        stderr(&output)
    );
    let answer = folder.answer("out");
    assert_eq!(answer.number("unknown_rows"), unknown as f64);
    assert_eq!(answer.number("confidence"), 0.8);
    let found = labels(&folder, "out/face_labels.npy");
    assert!(right(&found, &truth) > 0.97, "{}", right(&found, &truth));
    // NaN is unknown as well, and a table is read.
    let mut table = String::new();
    for &p in &given {
        table += &(if p == 9 || p == -1 { "nan".to_owned() } else { p.to_string() } + "\n");
    }
    folder.write("labels.csv", table);
    folder.done(&format!(
        "segment {MESH} --labels-in labels.csv --confidence 0.8 --out other --no-preview"
    ));
    assert_eq!(labels(&folder, "other/face_labels.npy"), found);
}

/// Names and colors reach the terminal, the summary and the mesh.
#[test]
fn classes_have_names_and_colors() {
    let folder = Folder::new();
    folder.array("votes.npy", &votes(&truth(&mesh())));
    folder.write(
        "classes.csv",
        "name,color\nwall,#cc8844\nroof,#010203\n\"tree, tall\",\nground,#ffffff\n",
    );
    let mut file = fs::File::create(folder.path("classes.toml")).unwrap();
    for (name, color) in
        [("wall", "#cc8844"), ("roof", "#010203"), ("tree, tall", ""), ("ground", "#ffffff")]
    {
        writeln!(file, "[[class]]\nname = \"{name}\"").unwrap();
        if !color.is_empty() {
            writeln!(file, "color = \"{color}\"").unwrap();
        }
    }
    for list in ["classes.csv", "classes.toml"] {
        let line = format!(
            "segment {MESH} --probabilities votes.npy --lambda 0.02 --classes {list} --out out"
        );
        let text = folder.done(&line);
        assert!(text.contains("tree, tall") && text.contains("#cc8844"), "{text}");
        let answer = folder.answer("out");
        let class = &answer.summary["region_parameters"][1];
        assert_eq!(class["name"], "roof");
        assert_eq!(class["palette"][2].as_f64().unwrap(), 3.0 / 255.0);
        let colors = io::read(&folder.path("out/segmented.ply")).unwrap().face_colors.unwrap();
        let label = labels(&folder, "out/face_labels.npy")[0];
        if label == 1 {
            assert_eq!(colors[0], [1.0, 2.0, 3.0].map(|c| c / 255.0));
        }
    }
}

/// The cut of labels of faces runs along edges; the result is drawn, and seeds of faces and vertices hold.
#[test]
fn cuts_pictures_and_seeds_of_faces() {
    let folder = Folder::new();
    folder.array("votes.npy", &votes(&truth(&mesh())));
    folder.write("seeds.csv", "face,region\n7,3\n");
    folder.write("corner.csv", "vertex,region\n0,2\n");
    let common = format!("segment {MESH} --probabilities votes.npy --lambda 0.02 --no-preview");
    let text =
        folder.done(&format!("{common} --seeds seeds.csv --contours --cut-mesh cut.ply --out out"));
    assert!(text.contains("polylines of length") && text.contains("cut mesh"), "{text}");
    assert_eq!(labels(&folder, "out/face_labels.npy")[7], 3);
    assert!(fs::read_to_string(folder.path("out/contours.obj")).unwrap().contains("g region-0-1"));
    let cut = io::read(&folder.path("cut.ply")).unwrap();
    assert_eq!(cut.faces, mesh().faces);
    folder.done(&format!("{common} --seeds corner.csv --out corner"));
    let found = labels(&folder, "corner/face_labels.npy");
    let mesh = mesh();
    let around = || mesh.faces.iter().zip(&found).filter(|(face, _)| face.contains(&0));
    assert!(around().count() == 6 && around().all(|(_, &p)| p == 2));
    // Nothing of an earlier run stays.
    folder.done(&format!("segment {MESH} --data curvature --regions 2 --no-preview --out out"));
    assert!(!names(&folder.path("out")).contains("face_labels.npy"));
    folder.done("render corner --out picture.png --show labels --views front");
    assert!(image::open(folder.path("picture.png")).unwrap().width() > 100);
}

/// Seams are welded, for data on either element; labels are those of the file.
#[test]
fn seams_are_welded() {
    let folder = Folder::new();
    let mut mesh = mesh();
    // Every face gets corners of its own.
    mesh.vertices = mesh.faces.iter().flatten().map(|&v| mesh.vertices[v as usize]).collect();
    mesh.faces = (0..4800).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
    io::write(&folder.path("soup.ply"), &mesh).unwrap();
    let truth = truth(&mesh);
    folder.array("votes.npy", &votes(&truth));
    let of_vertices =
        Array2::from_shape_fn((14_400, 4), |(v, p)| f64::from(truth[v / 3] == p) + 0.5);
    folder.array("vertices.npy", &of_vertices);
    for (file, on) in
        [("votes", "faces"), ("votes", "vertices"), ("vertices", "faces"), ("vertices", "vertices")]
    {
        folder.done(&format!(
            "segment soup.ply --probabilities {file}.npy --on {on} --out out --no-preview"
        ));
        let answer = folder.answer("out");
        assert_eq!(labels(&folder, "out/labels.npy").len(), 14_400);
        assert_eq!(answer.number("vertices"), 14_400.0);
        assert_eq!(answer.number("welded_vertices"), 12_000.0);
        let least = if on == "faces" { 0.97 } else { 0.95 };
        let share = right(&labels(&folder, "out/face_labels.npy"), &truth);
        assert!(share > least, "{file} {on}: {share}");
    }
}

/// Properties of a PLY mesh, where cuts are cheap, and labels without small parts.
#[test]
fn properties_contrast_and_cleaning() {
    let folder = Folder::new();
    let mesh = mesh();
    let truth = truth(&mesh);
    let votes = votes(&truth);
    folder.array("votes.npy", &votes);
    let mut ply = format!("ply\nformat ascii 1.0\nelement vertex {}\n", mesh.vertices.len());
    ply += "property double x\nproperty double y\nproperty double z\n";
    ply += &format!("element face {}\nproperty list uchar int vertex_indices\n", mesh.faces.len());
    for p in 0..4 {
        ply += &format!("property float p_{p}\n");
    }
    ply += "property float other\nend_header\n";
    for x in &mesh.vertices {
        ply += &format!("{:?} {:?} {:?}\n", x.x, x.y, x.z);
    }
    for (face, row) in mesh.faces.iter().zip(votes.outer_iter()) {
        ply += &format!("3 {} {} {}", face[0], face[1], face[2]);
        row.iter().for_each(|p| ply += &format!(" {p}"));
        ply += " 7\n";
    }
    folder.write("votes.ply", ply);
    let common = "--lambda 0.001 --no-preview";
    folder.done(&format!("segment {MESH} --probabilities votes.npy {common} --out array"));
    folder.done(&format!("segment votes.ply --property p_* {common} --out property"));
    let plain = labels(&folder, "array/face_labels.npy");
    assert_eq!(labels(&folder, "property/face_labels.npy"), plain);
    let output = folder.run(&format!("segment votes.ply --property q_* {common} --out none"));
    assert!(stderr(&output).contains("no such number at vertices or faces"), "{}", stderr(&output));
    let output = folder.run(&format!("segment {MESH} --property p_* {common} --out none"));
    assert!(stderr(&output).contains("needs a PLY or VTK mesh"), "{}", stderr(&output));

    let text = folder
        .done(&format!("segment votes.ply --property p_* {common} --min-area 1% --out clean"));
    assert!(text.contains("cleaned") && text.contains("their energy was"), "{text}");
    let [before, after] = ["array", "clean"].map(|out| folder.answer(out));
    let cleaned = &after.summary["cleaned"];
    assert!(cleaned["parts"].as_u64().unwrap() > 0);
    assert_eq!(cleaned["energy_after"].as_f64(), after.summary["rounded_energy"].as_f64());
    let close =
        (cleaned["energy_before"].as_f64().unwrap() - before.number("rounded_energy")).abs();
    assert!(close < 1e-9);
    assert!(after.number("rounded_relative_gap") >= before.number("rounded_relative_gap"));
    let share = right(&labels(&folder, "clean/face_labels.npy"), &truth);
    assert!(share > right(&plain, &truth), "{share}");
    let property = |name: &str| {
        folder.done(&format!("segment votes.ply --property {name} {common} --out property"));
        labels(&folder, "property/face_labels.npy")
    };
    assert_eq!(property("face:p_*"), plain);
    // The curve is that of the labels that are written.
    for cleaning in ["", "--min-area 1%", "--components"] {
        let line = format!(
            "segment votes.ply --property p_* {common} --on vertices --contours {cleaning}"
        );
        folder.done(&format!("{line} --cut-mesh cut.ply --out curve"));
        let cut = io::read(&folder.path("cut.ply")).unwrap();
        let answer = folder.answer("curve");
        let of_mesh = cut.faces.len() - mesh.faces.len();
        match cleaning {
            "--components" => {
                assert_eq!(answer.number("contour_length"), 0.0);
                assert_eq!(of_mesh, 0);
                assert!(!folder.path("curve/contours.obj").exists());
            }
            _ => assert!(of_mesh > 0 && answer.number("contour_length") > 0.0),
        }
    }
    folder.done(&format!(
        "segment votes.ply --property p_* {common} --components --on vertices --out one"
    ));
    let one = labels(&folder, "one/labels.npy");
    assert!(one.iter().all(|&p| p == one[0]));

    for choice in ["normals", "weights.csv"] {
        folder.write("weights.csv", "0.5\n".repeat(mesh.faces.len()));
        for on in ["vertices", "faces"] {
            let line = format!("segment votes.ply --property p_* {common} --on {on}");
            folder.done(&format!("{line} --edge-aware {choice} --out edges"));
            let answer = folder.answer("edges");
            assert_eq!(answer.summary["edge_aware"], choice);
            assert!(answer.number("relative_gap") <= 1e-4);
        }
    }
    folder.write("zero.csv", "0\n".repeat(mesh.faces.len()));
    for (argument, part) in [
        ("--edge-aware colors", "the mesh has no colors"),
        ("--edge-aware zero.csv", "the weight of face 0 is 0.0"),
        ("--edge-aware votes.npy", "supply one weight per face"),
    ] {
        let output =
            folder.run(&format!("segment votes.ply --property p_* {common} {argument} --out none"));
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    for argument in ["--min-area 0", "--min-area -1%", "--fill-holes nan"] {
        let output =
            folder.run(&format!("segment votes.ply --property p_* {common} {argument} --out none"));
        assert_eq!(output.status.code(), Some(2), "{argument}");
    }
}

/// What a mask leaves out has no label, and the rest is as if it were not there.
#[test]
fn a_mask_leaves_out_a_part() {
    let folder = Folder::new();
    let mesh = mesh();
    let truth = truth(&mesh);
    folder.array("votes.npy", &votes(&truth));
    let kept: Vec<bool> =
        (0..mesh.faces.len()).map(|j| mesh.corners(j).iter().all(|x| x.x > 0.0)).collect();
    write_npy(folder.path("mask.npy"), &Array1::from_iter(kept.iter().copied())).unwrap();
    let vertices: String =
        mesh.vertices.iter().map(|x| if x.x > 0.0 { "1\n" } else { "0\n" }).collect();
    folder.write("mask.csv", vertices);
    folder.write("seeds.csv", "face,region\n0,3\n");
    assert!(kept[0]);
    let common =
        format!("segment {MESH} --probabilities votes.npy --lambda 0.02 --seeds seeds.csv");
    for on in ["faces", "vertices"] {
        let mut found = Vec::new();
        for mask in ["mask.npy", "mask.csv"] {
            let output =
                folder.run(&format!("{common} --on {on} --mask {mask} --contours --out out"));
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            assert!(
                stderr(&output).contains("faces are left out by the mask"),
                "{}",
                stderr(&output)
            );
            assert!(!stderr(&output).contains("unknown"), "{}", stderr(&output));
            let of_faces = labels(&folder, "out/face_labels.npy");
            for (&p, &kept) in of_faces.iter().zip(&kept) {
                assert_eq!(p == -1, !kept);
            }
            let of_vertices = labels(&folder, "out/labels.npy");
            let answer = folder.answer("out");
            for (v, &p) in of_vertices.iter().enumerate() {
                let inside = mesh
                    .faces
                    .iter()
                    .zip(&kept)
                    .any(|(face, &kept)| kept && face.contains(&(v as u32)));
                assert_eq!(p == -1, !inside, "{v}");
                if on == "vertices" {
                    assert_eq!(answer.u[[v, 0]].is_nan(), !inside);
                }
            }
            let outside = kept.iter().filter(|kept| !**kept).count();
            assert_eq!(answer.number("left_out_faces"), outside as f64);
            assert_eq!([answer.number("vertices"), answer.number("faces")], [2400.0, 4800.0]);
            assert_eq!(of_faces[0], 3);
            let written = io::read(&folder.path("out/segmented.ply")).unwrap();
            assert_eq!(written.faces, mesh.faces);
            found.push(of_faces);
        }
        assert_eq!(found[0], found[1]);
        let inside = found[0].iter().zip(&truth).zip(&kept).filter(|(_, kept)| **kept);
        let right = inside.clone().filter(|((p, q), _)| **p as usize == **q).count();
        assert!(right as f64 > 0.94 * inside.count() as f64, "{on}");
    }
    folder.write("none.csv", "0\n".repeat(4800));
    folder.write("two.csv", "0,1\n".repeat(4800));
    for (mask, part) in [
        ("none.csv", "leaves no face"),
        ("two.csv", "has 2 columns"),
        ("votes.npy", "has 4 columns"),
    ] {
        let output = folder.run(&format!("{common} --mask {mask} --out none"));
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
}

#[test]
fn what_is_no_class_is_refused() {
    let folder = Folder::new();
    let p = Array2::from_elem((32, 2), 0.5);
    folder.array("p.npy", &p);
    folder.array("short.npy", &Array2::from_elem((7, 2), 0.5));
    folder.array("one.npy", &Array2::from_elem((32, 1), 0.5));
    let mut negative = p.clone();
    negative[[3, 1]] = -0.25;
    folder.array("negative.npy", &negative);
    let mut partly = p.clone();
    partly[[4, 0]] = f64::NAN;
    folder.array("partly.npy", &partly);
    folder.array("zeros.npy", &Array2::zeros((32, 2)));
    write_npy(folder.path("cube.npy"), &ndarray::Array3::<f64>::zeros((32, 2, 2))).unwrap();
    folder.write("words.csv", "a,b\n0.5,half\n");
    folder.write("ragged.csv", "0.5,0.5\n0.5\n");
    folder.write("empty.csv", "a,b\n");
    folder.write("text.npz", "no archive");
    folder.write("p.dat", "0.5");
    folder.write("half.csv", format!("0.5\n{}", "0\n".repeat(31)));
    folder.write("far.csv", format!("70\n{}", "0\n".repeat(31)));
    let rows = |first: &dyn Fn(usize) -> String| -> String {
        (0..32).map(|row| format!("{},0.5,0.5\n", first(row))).collect()
    };
    folder.write("counted.csv", rows(&|row| row.to_string()));
    folder.write("order.csv", format!("face,a,b\n{}", rows(&|row| (31 - row).to_string())));
    folder.write("semicolons.csv", "0.5;0.5\n".repeat(32));
    folder.write("twice.csv", "name\na\na\n");
    NpzWriter::new(fs::File::create(folder.path("empty.npz")).unwrap()).finish().unwrap();
    folder.write("three.csv", "name\na\nb\nc\n");
    folder.write("color.csv", "name,color\na,red\nb,#000000\n");
    folder.write("typo.toml", "[[class]]\nnmae = \"a\"\n");
    folder.write(
        "tetra.off",
        "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
    );
    folder.array("four.npy", &Array2::from_elem((4, 2), 0.5));
    for (line, part) in [
        ("--probabilities short.npy", "has 7 rows, but the mesh has 25 vertices and 32 faces"),
        ("--probabilities one.npy", "both p and 1 - p"),
        ("--probabilities negative.npy", "row 3, column 1 is -0.25"),
        ("--probabilities partly.npy", "row 4 of the probabilities has NaN and numbers"),
        ("--probabilities zeros.npy", "at least one must be known"),
        ("--probabilities cube.npy", "has 3 axes"),
        ("--probabilities words.csv", "words.csv, line 2: `half` is not a number"),
        ("--probabilities ragged.csv", "line 2: has 1 cells"),
        ("--probabilities empty.csv", "has no rows"),
        ("--probabilities text.npz", "is not an .npz file"),
        ("--probabilities p.dat", "supply .npy, .npz or .csv"),
        ("--probabilities missing.npy", "missing.npy"),
        ("--probabilities p.npy --floor 0.5", "the floor is 0.5"),
        ("--probabilities p.npy --floor nan", "the floor is NaN"),
        ("--probabilities p.npy --mass voronoi", "--mass"),
        ("--probabilities p.npy --coarse-to-fine", "coarse to fine"),
        ("--probabilities p.npy --save q", "dual field"),
        ("--probabilities p.npy --lambda -1", "lambda = -1"),
        ("--labels-in p.npy", "has 2 columns"),
        ("--labels-in half.csv", "the label in row 0 is 0.5"),
        (
            "--labels-in far.csv",
            "the label in row 0 is 70: classes are numbered from 0 to 63; --unknown 70",
        ),
        ("--probabilities counted.csv", "a first column that counts the rows"),
        ("--probabilities order.csv", "must be 0, 1, 2"),
        ("--probabilities semicolons.csv", "separate numbers by commas"),
        ("--probabilities p.npy --classes twice.csv", "classes 0 and 1 have the same name"),
        ("--probabilities p.npy --pure 2", "--pure needs --data views:FILE"),
        ("--probabilities empty.npz", "has no arrays"),
        ("--labels-in one.npy --confidence 1", "labels are integers"),
        ("--probabilities p.npy --classes three.csv", "has 3 classes, but there are 2"),
        ("--probabilities p.npy --classes color.csv", "write it as #rrggbb"),
        ("--probabilities p.npy --classes typo.toml", "typo.toml, line 2"),
        ("--regions 2 --on faces", "--on needs --probabilities"),
        ("--regions 2 --floor 0.1", "--floor needs --probabilities"),
    ] {
        let before = folder.listing();
        let output = folder.run(&format!("segment grid:4x4 {line} --out out"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{line}\n{message}");
        assert!(message.contains(part) && message.lines().count() == 1, "{line}\n{message}");
        assert_eq!(folder.listing(), before, "{line}");
    }
    let output = folder.run("segment tetra.off --probabilities four.npy --out out");
    assert!(stderr(&output).contains("as many vertices as faces"), "{}", stderr(&output));
    folder.done("segment tetra.off --probabilities four.npy --on faces --out out --no-preview");
    for line in [
        "--probabilities p.npy --scores p.npy",
        "--probabilities p.npy --regions 2",
        "--scores p.npy --data colors",
        "--labels-in one.npy --floor 0.1",
        "--probabilities p.npy --confidence 0.9",
        "--probabilities p.npy --model l1",
    ] {
        let output = folder.run(&format!("segment grid:4x4 {line} --out out"));
        assert_eq!(output.status.code(), Some(2), "{line}");
    }
}

/// Degenerate answers are said: one class everywhere, and classes that are never the most probable.
#[test]
fn degenerate_answers_are_said() {
    let folder = Folder::new();
    let one = Array2::from_shape_fn((32, 3), |(_, p)| [0.7, 0.2, 0.1][p]);
    folder.array("one.npy", &one);
    let output = folder.run("segment grid:4x4 --probabilities one.npy --out out --no-preview");
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.contains("class 0 is the most probable one everywhere"), "{message}");
    assert!(message.contains("no face has its smallest cost there"), "{message}");
}
