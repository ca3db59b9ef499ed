//! Surfaces with inconsistent orientation, without curvature, or with constant data.

use std::collections::BTreeSet;
use std::fs;

use meshseg::Mesh;
use meshseg::mesh::io;
use ndarray::Array2;

use super::seams::{case, cut, shape, wrong};
use crate::support::{Answer, Folder, stderr};

/// Flips faces pseudo-randomly, in the same way on every machine.
fn disturbed(mesh: &Mesh) -> (Mesh, usize) {
    let mut mesh = mesh.clone();
    let flips = |j: usize| (j * 7919 + 13) % 101 < 30;
    let faces = mesh.faces.iter_mut().enumerate().filter(|(j, _)| flips(*j));
    let count = faces.map(|(_, face)| face.swap(0, 2)).count();
    (mesh, count)
}

#[test]
fn curvature_does_not_depend_on_the_winding() {
    let folder = Folder::new();
    let torus = shape("torus:60x38");
    let mut inside_out = torus.clone();
    inside_out.faces.iter_mut().for_each(|face| face.swap(1, 2));
    let (flipped, turned) = disturbed(&torus);
    let segment = |name: &str| {
        let line =
            format!("segment {name}.obj --data curvature --regions 2 --lambda 1e-4 --out {name}");
        let output = folder.run(&line);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (folder.answer(name), stderr(&output))
    };
    io::write(&folder.path("torus.obj"), &torus).unwrap();
    let (exact, message) = segment("torus");
    assert!(!message.contains("flipped"), "{message}");
    let counts: BTreeSet<i32> = exact.labels.iter().copied().collect();
    assert_eq!(counts.len(), 2);
    for (name, mesh, turned) in
        [("flipped", &flipped, turned), ("inside", &inside_out, torus.faces.len())]
    {
        io::write(&folder.path(&format!("{name}.obj")), mesh).unwrap();
        let (answer, message) = segment(name);
        let expected = format!("{turned} of {} faces were flipped", torus.faces.len());
        assert!(message.contains(&expected), "{message}");
        assert_eq!(answer.labels, exact.labels, "{name}");
        let again = io::read(&folder.path(&format!("{name}/segmented.ply"))).unwrap();
        assert_eq!(again.faces, mesh.faces, "{name}");
    }
    // The outer half of the tube is the convex one.
    let sign = exact.summary["data_sign"].as_str().unwrap();
    assert!(sign.contains("positive where the surface is convex as seen from outside"));
    let means = exact.summary["region_parameters"].as_array().unwrap();
    let mean = |label: i32| means[label as usize]["mean"][0].as_f64().unwrap();
    let far = |x: &nalgebra::Point3<f64>| x.x.hypot(x.y);
    let order =
        |a: &usize, b: &usize| far(&torus.vertices[*a]).total_cmp(&far(&torus.vertices[*b]));
    let outer = (0..torus.vertices.len()).max_by(order).unwrap();
    let inner = (0..torus.vertices.len()).min_by(order).unwrap();
    assert!(mean(exact.labels[outer]) > mean(exact.labels[inner]));
    assert!(folder.done("segment --help").contains("convex as seen from outside"));
}

/// Seams are welded before normals and curvature are computed.
#[test]
fn curvature_crosses_seams() {
    let folder = Folder::new();
    let torus = shape("torus:60x38");
    let (soup, before) = cut(&disturbed(&torus).0, |j| j);
    let line = |name: &str| {
        format!(
            "segment {name}.ply --data curvature --regions 2 --lambda 1e-4 --no-preview --out {name}"
        )
    };
    for (name, mesh) in [("torus", &torus), ("soup", &soup)] {
        io::write(&folder.path(&format!("{name}.ply")), mesh).unwrap();
        folder.done(&line(name));
    }
    let (whole, soup) = (folder.answer("torus"), folder.answer("soup"));
    let meant: Vec<i32> = before.iter().map(|&k| whole.labels[k]).collect();
    assert_eq!(wrong(&soup, &meant), 0);
    for end in 0..2 {
        let range = |answer: &Answer| answer.summary["data_unit_range"][end].as_f64().unwrap();
        assert!((range(&whole) - range(&soup)).abs() < 1e-9 * range(&whole).abs());
    }
}

#[test]
fn strips_have_no_curvature() {
    let folder = Folder::new();
    for name in ["ribbon.obj", "strip.obj"] {
        fs::copy(case(&format!("18-curvature-boundary/{name}")), folder.path(name)).unwrap();
        let output = folder.run(&format!("segment {name} --data curvature --regions 2 --out out"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        let expected = format!(
            "error: {name}: no vertex of the mesh has a curvature: all lie on the boundary; subdivide"
        );
        assert!(message.starts_with(&expected), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(!folder.path("out").exists());
    }
}

/// Corners whose neighbors all lie on the boundary are unknown; the rest of the mesh is still segmented.
#[test]
fn corners_without_curvature_are_unknown() {
    let folder = Folder::new();
    let mut hill = shape("grid:40x30");
    hill.vertices.iter_mut().for_each(|x| x.z = 0.1 * (-40.0 * (x.x - 0.5).powi(2)).exp());
    io::write(&folder.path("hill.obj"), &hill).unwrap();
    fs::copy(case("18-curvature-boundary/half.obj"), folder.path("half.obj")).unwrap();
    for (name, unknown) in [("hill", 2), ("half", 2)] {
        let output = folder.run(&format!(
            "segment {name}.obj --data curvature --regions 2 --lambda 1e-4 --no-preview --out {name}"
        ));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let expected = format!("{unknown} vertices have no curvature");
        assert!(stderr(&output).contains(&expected), "{}", stderr(&output));
        folder.answer(name).assert_consistent();
    }
    // An unknown corner has the label of its neighbors.
    let labels = folder.answer("hill").labels;
    let at = |x: usize, y: usize| labels[y * 41 + x];
    assert!([(40, 0), (0, 30)].iter().all(|&(x, y)| at(x, y) == at(x, 15)));
    assert!(at(20, 15) != at(0, 15));
    // Half of a tube has constant curvature.
    let used: BTreeSet<i32> = folder.answer("half").labels.iter().copied().collect();
    assert_eq!(used.len(), 1);
}

#[test]
fn curvature_of_a_tube_is_nothing_to_segment() {
    let folder = Folder::new();
    fs::copy(case("39-skinny/tube.obj"), folder.path("tube.obj")).unwrap();
    let output = folder.run("segment tube.obj --data curvature --regions 2 --no-preview --out out");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let expected = "the mean curvature is constant up to rounding";
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    assert!(stderr(&output).contains("there is nothing to segment"));
    let answer = folder.answer("out");
    assert!(answer.summary["warnings"].to_string().contains(expected));
    assert!(answer.number("iterations") < 100.0);
    let used: BTreeSet<i32> = answer.labels.iter().copied().collect();
    assert_eq!(used.len(), 1);
}

/// Which curvature, its range and its unit are reported on the screen and in the summary.
#[test]
fn every_kind_of_curvature_is_named_with_its_range_and_unit() {
    let folder = Folder::new();
    let mut torus = shape("torus:120x76");
    // R = 1, r = 0.4.
    let scale = 1.4 / torus.vertices[0].x;
    torus = torus.scaled(scale);
    io::write(&folder.path("torus.obj"), &torus).unwrap();
    let [outer, inner] = [1.0 / 1.4, -1.0 / 0.6];
    for (kind, name, unit, ends) in [
        ("", "mean curvature", Some("1/length"), [inner, outer].map(|k| 0.5 * (2.5 + k))),
        (
            ":mean-quadric",
            "mean curvature (quadric)",
            Some("1/length"),
            [inner, outer].map(|k| 0.5 * (2.5 + k)),
        ),
        (":gaussian", "Gaussian curvature", Some("1/length^2"), [inner, outer].map(|k| 2.5 * k)),
        (":shape-index", "shape index", None, [-1.0, 1.0]),
    ] {
        let text = folder.done(&format!(
            "segment torus.obj --data curvature{kind} --regions 2 --lambda 1e-4 --out out"
        ));
        let line = text.lines().find(|line| line.starts_with("data ")).unwrap();
        assert!(line.contains(name) && line.contains("to [0, 1]"), "{line}");
        assert!(unit.is_none_or(|unit| line.contains(&format!("in {unit} of the file"))), "{line}");
        let answer = folder.answer("out");
        answer.assert_consistent();
        assert_eq!(answer.summary["data"], name);
        assert_eq!(answer.summary["data_unit"].as_str(), unit);
        let signed = answer.summary["data_sign"].as_str().unwrap_or("none");
        assert_eq!(signed.contains("convex as seen from outside"), kind != ":gaussian", "{signed}");
        // The range is that of the mesh of area 1, the extreme 2 % of the area are cut off.
        let power = [None, Some("1/length"), Some("1/length^2")].iter().position(|u| *u == unit);
        let factor = answer.number("scale").powi(power.unwrap() as i32);
        for (end, exact) in ends.into_iter().enumerate() {
            let found = answer.summary["data_unit_range"][end].as_f64().unwrap() * factor;
            assert!((found - exact).abs() < 0.05 * exact.abs().max(1.0), "{kind}: {found} {exact}");
        }
    }
    let message =
        stderr(&folder.run("segment torus.obj --data curvature:mean-curv --regions 2 --out out"));
    assert!(message.contains("mean, mean-quadric, gaussian, shape-index"), "{message}");
    let message =
        stderr(&folder.run("segment grid:9x9 --data curvature:shape-index --regions 2 --out o"));
    let expected = "error: grid:9x9: no vertex of the mesh has a shape index: the surface is flat up to the rounding";
    assert!(message.starts_with(expected) && message.lines().count() == 1, "{message}");
}

/// Two triangulations of a torus with other vertices and other edges get the same regions.
#[test]
fn regions_do_not_depend_on_the_triangulation() {
    let folder = Folder::new();
    let torus = |nu: u32, nv: u32, shift: f64, other: bool| {
        let mut mesh = shape(&format!("torus:{nu}x{nv}"));
        let angle = |k: u32, n: u32, seed: u32| {
            let shift = shift * f64::from(seed * 7919 % 101) / 101.0;
            std::f64::consts::TAU * (f64::from(k) + shift) / f64::from(n)
        };
        for (k, x) in (0..).zip(&mut mesh.vertices) {
            let (u, v) = (angle(k / nv, nu, k), angle(k % nv, nv, 3 * k + 1));
            let distance = 1.0 + 0.4 * v.cos();
            *x = [distance * u.cos(), distance * u.sin(), 0.4 * v.sin()].into();
        }
        if other {
            for pair in mesh.faces.chunks_exact_mut(2) {
                let ([a, b, c], d) = (pair[0], pair[1][2]);
                pair.copy_from_slice(&[[a, b, d], [b, c, d]]);
            }
        }
        mesh
    };
    let meshes = [torus(60, 38, 0.0, false), torus(71, 43, 0.6, true)];
    for kind in
        ["curvature", "curvature:mean-quadric", "curvature:gaussian", "curvature:shape-index"]
    {
        let labels = [0, 1].map(|i| {
            io::write(&folder.path(&format!("{i}.obj")), &meshes[i]).unwrap();
            folder.done(&format!(
                "segment {i}.obj --data {kind} --regions 2 --lambda 0.003 --no-preview --out {i}"
            ));
            let answer = folder.answer(&i.to_string());
            let mean =
                |p: usize| answer.summary["region_parameters"][p]["mean"][0].as_f64().unwrap();
            let swapped = i32::from(mean(0) > mean(1));
            answer.labels.iter().map(|label| label ^ swapped).collect::<Vec<_>>()
        });
        let mut equal = 0;
        for (x, label) in meshes[0].vertices.iter().zip(&labels[0]) {
            let distance = |k: &usize| (meshes[1].vertices[*k] - x).norm_squared();
            let nearest = (0..meshes[1].vertices.len())
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap();
            equal += usize::from(labels[1][nearest] == *label);
        }
        let share = equal as f64 / labels[0].len() as f64;
        assert!(share > 0.95, "{kind}: {share}");
    }
}

#[test]
fn data_of_one_value_are_nothing_to_segment() {
    let folder = Folder::new();
    let mut grid = shape("grid:8x8");
    let n = grid.vertices.len();
    grid.colors = Some(vec![[1.0; 3]; n]);
    io::write(&folder.path("white.ply"), &grid).unwrap();
    folder.array(
        "rounded.npy",
        &Array2::from_shape_fn((n, 2), |(k, _)| 7.0 + 1e-13 * (k % 3) as f64),
    );
    folder.array(
        "signal.npy",
        &Array2::from_shape_fn((n, 2), |(k, _)| 7.0 + 1e-6 * f64::from(k > n / 2)),
    );
    for (data, expected) in [
        (
            "colors",
            Some(
                "colors: all vertices have the same colors, so there is nothing to segment; choose other data",
            ),
        ),
        (
            "rounded.npy",
            Some(
                "rounded.npy: the values differ by at most 1e-13 of their size, which is rounding, so there is nothing to \
                 segment; choose other data",
            ),
        ),
        ("signal.npy", None),
    ] {
        let output = folder
            .run(&format!("segment white.ply --data {data} --regions 2 --no-preview --out out"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        // Reported once, by the source, which names them.
        let warnings: Vec<String> =
            serde_json::from_value(folder.answer("out").summary["warnings"].clone()).unwrap();
        assert_eq!(warnings, expected.into_iter().collect::<Vec<_>>(), "{data}");
        assert_eq!(stderr(&output).contains("nothing"), expected.is_some(), "{}", stderr(&output));
        let used: BTreeSet<i32> = folder.answer("out").labels.iter().copied().collect();
        assert_eq!(used.len(), if expected.is_some() { 1 } else { 2 }, "{data}");
    }
}
