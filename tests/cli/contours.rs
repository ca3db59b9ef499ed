//! `--contours` and `--cut-mesh`: the cut of U as polylines, and the mesh that is divided along it.

use std::fs;

use meshseg::contour::Cells;
use meshseg::mesh::{Mesh, Source, Statistics, io};
use ndarray::Array2;
use serde_json::Value;

use crate::support::{Folder, stderr};

/// The numbers after a keyword of a line of an OBJ file.
fn numbers<'a>(line: &'a str, keyword: &str) -> Option<impl Iterator<Item = f64> + use<'a>> {
    let rest = line.strip_prefix(keyword)?.strip_prefix(' ')?;
    Some(rest.split(' ').map(|number| number.parse().unwrap()))
}

/// The total length of the polylines in an OBJ file, and the names of its groups.
fn read_contours(text: &str) -> (f64, Vec<String>) {
    let points: Vec<Vec<f64>> =
        text.lines().filter_map(|line| numbers(line, "v")).map(Iterator::collect).collect();
    let mut length = 0.0;
    for line in text.lines().filter_map(|line| numbers(line, "l")) {
        let line: Vec<&Vec<f64>> = line.map(|i| &points[i as usize - 1]).collect();
        for ends in line.windows(2) {
            let square = |i: usize| (ends[1][i] - ends[0][i]).powi(2);
            length += (0..3).map(square).sum::<f64>().sqrt();
        }
    }
    let groups = text.lines().filter_map(|line| line.strip_prefix("g ")).map(String::from);
    (length, groups.collect())
}

fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} is not {b}");
}

fn faces_between(mesh: &Mesh, summary: &Value) {
    let areas: Vec<f64> =
        summary["cell_areas"].as_array().unwrap().iter().map(|a| a.as_f64().unwrap()).collect();
    assert_near(areas.iter().sum(), mesh.area());
}

/// The contour has the units of the file, its seams are no ends, and the divided mesh stays closed.
#[test]
fn spot_is_cut_into_regions() {
    let folder = Folder::new();
    let printed = folder.done(
        "segment builtin:spot --regions 3 --no-preview --contours --cut-mesh spot/cut.ply --out spot",
    );
    assert!(printed.contains("contours") && printed.contains("spot/cut.ply: "), "{printed}");
    let answer = folder.answer("spot");
    let (length, groups) =
        read_contours(&fs::read_to_string(folder.path("spot/contours.obj")).unwrap());
    assert!(groups.iter().all(|group| group.starts_with("region-")) && groups.is_sorted());
    assert_near(answer.number("contour_length"), length);
    assert!(length < answer.number("cut_length"));
    assert!(answer.summary["cut_threshold"].is_null());
    let differs = answer.number("cells_differ_share");
    assert!((0.0..0.1).contains(&differs), "{differs}");

    let mesh = Source::parse("builtin:spot").unwrap().mesh().unwrap();
    faces_between(&mesh, &answer.summary);
    let path = folder.path("spot/cut.ply");
    let cut = io::read(&path).unwrap();
    assert_near(cut.area(), mesh.area());
    assert_eq!(cut.vertices[..mesh.vertices.len()], mesh.vertices);
    let (before, after) = (Statistics::of(&mesh), Statistics::of(&cut));
    assert_eq!(before.boundary_edges, after.boundary_edges);
    assert_eq!(before.euler_characteristic, after.euler_characteristic);
    let header = String::from_utf8_lossy(&fs::read(&path).unwrap()[..600]).into_owned();
    let of_faces = "property list uchar uint vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar \
                    blue\nproperty uchar label\nend_header";
    assert!(header.contains(of_faces), "{header}");
}

/// Costs of two halves of a plane, which are cut by a straight line.
fn halves(folder: &Folder) {
    folder.done("mesh generate grid:8x8 --out grid.ply");
    let mesh = io::read(&folder.path("grid.ply")).unwrap();
    let [low, high] = [mesh.vertices[0].x, mesh.vertices.last().unwrap().x];
    let middle = 0.5 * (low + high);
    let costs = Array2::from_shape_fn((mesh.vertices.len(), 2), |(v, p)| {
        let d = mesh.vertices[v].x - middle;
        if p == 0 { d.max(0.0) } else { (-d).max(0.0) }
    });
    folder.array("s.npy", &costs);
}

/// The threshold of two regions is in the summary, and the file has the contour of this level.
#[test]
fn two_regions_are_cut_at_a_threshold() {
    let folder = Folder::new();
    halves(&folder);
    let solve = "grid.ply --costs s.npy --lambda 0.001 --no-preview --contours";
    for format in ["ply", "obj", "off"] {
        let answer = folder.solve(&format!("{solve} --cut-mesh cut.{format}"), "out");
        let t = answer.number("cut_threshold");
        let mesh = io::read(&folder.path("grid.ply")).unwrap();
        let contours = Cells::new(&mesh, answer.u.view(), Some(t)).contours();
        let text = fs::read_to_string(folder.path("out/contours.obj")).unwrap();
        let (length, groups) = read_contours(&text);
        assert_near(length, contours.length());
        assert_eq!(groups, ["region-0-1"]);
        faces_between(&mesh, &answer.summary);
        let cut = io::read(&folder.path(&format!("cut.{format}"))).unwrap();
        assert_near(cut.area(), mesh.area());
        match format {
            "obj" => {
                let materials = cut.materials.unwrap();
                let names: Vec<&str> = materials.all.iter().map(|m| m.name.as_str()).collect();
                assert_eq!(names, ["region-0", "region-1"]);
                assert_eq!(materials.of_faces.len(), cut.faces.len());
            }
            _ => assert_eq!(cut.face_colors.unwrap().len(), cut.faces.len()),
        }
    }
    // The picture draws the same cut.
    folder.done("render out --show labels --out labels.png");
}

/// Where there is no cut, no file is written and an earlier one is removed.
#[test]
fn without_a_cut_there_is_no_file() {
    let folder = Folder::new();
    halves(&folder);
    let solve = "grid.ply --costs s.npy --no-preview --out out";
    folder.done(&format!("solve {solve} --lambda 0.001 --contours"));
    assert!(folder.path("out/contours.obj").exists());
    let output = folder.run(&format!("solve {solve} --lambda 100 --contours --cut-mesh cut.ply"));
    assert_eq!(output.status.code(), Some(0));
    assert!(stderr(&output).contains("contours.obj is not written"), "{}", stderr(&output));
    assert!(!folder.path("out/contours.obj").exists());
    assert_eq!(io::read(&folder.path("cut.ply")).unwrap().faces.len(), 128);
    assert_eq!(folder.answer("out").number("contour_length"), 0.0);
}

/// Names that cannot be written are refused before the solve.
#[test]
fn impossible_files_are_refused() {
    let folder = Folder::new();
    halves(&folder);
    fs::create_dir(folder.path("folder.ply")).unwrap();
    for (file, part) in [
        ("cut.xyz", ".obj, .ply, .off, .stl, .vtp and .vtu"),
        ("cut.stl", "the labels of faces are written to .ply, .obj or .off"),
        ("folder.ply", "is a folder"),
        ("missing/cut.ply", "its folder does not exist"),
        ("grid.ply", "the mesh that is cut"),
        ("./grid.ply", "the mesh that is cut"),
        ("out/segmented.ply", "another result"),
        ("model.obj", "the materials of another mesh"),
    ] {
        folder.write("model.mtl", "newmtl mine\n");
        let line =
            format!("solve grid.ply --costs s.npy --lambda 0.001 --cut-mesh {file} --out out");
        let output = folder.run(&line);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(part) && message.contains(file), "{message}");
        assert!(!folder.path("out").exists());
    }
}

/// The same files with any number of threads.
#[test]
fn the_cut_has_the_same_bytes_with_any_number_of_threads() {
    let folder = Folder::new();
    for threads in [1, 2] {
        folder.done(&format!(
            "segment torus:60x40 --data curvature --regions 3 --no-preview --threads {threads} --contours --cut-mesh \
             {threads}/cut.ply --out {threads}"
        ));
    }
    for name in ["contours.obj", "cut.ply"] {
        let [one, two] = ["1", "2"].map(|n| fs::read(folder.path(n).join(name)).unwrap());
        assert_eq!(one, two, "{name}");
    }
}
