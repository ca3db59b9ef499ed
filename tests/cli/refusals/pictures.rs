//! Requests for pictures that cannot be drawn.

use std::fs;

use ndarray::{Array1, array};
use ndarray_npy::write_npy;

use super::{folder, misuse, refuse};

#[test]
fn what_a_mesh_lacks_is_named() {
    let folder = folder();
    let labels = |name: &str, labels: &[i32]| {
        write_npy(folder.path(name), &Array1::from(labels.to_vec())).unwrap();
    };
    labels("L.npy", &[0, 1, 1, 0]);
    labels("three.npy", &[0, 1, 1]);
    labels("negative.npy", &[0, 1, -1, 0]);
    labels("large.npy", &[0, 1, 64, 0]);
    folder.array("one.npy", &array![[1.0], [1.0], [1.0], [1.0]]);
    folder.array("nan.npy", &array![[1.0, 0.0], [1.0, 0.0], [1.0, f64::NAN], [1.0, 0.0]]);
    folder.array("five.npy", &array![[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 0.0]]);
    for (line, parts) in [
        ("", ["square.obj", "--data curvature"]),
        ("--data colors", ["square.obj", "--data FILE.npy"]),
        ("--data missing.npy", ["missing.npy", "No such file"]),
        ("--data five.npy", ["five.npy", "one row per vertex"]),
        ("--data D.npy --show labels", ["labels cannot be shown", "--labels LABELS.npy"]),
        ("--data D.npy --show data+cut", ["data+cut cannot be shown", "--u U.npy"]),
        ("--u U.npy --show data", ["square.obj", "--data FILE.npy"]),
        ("--u U.npy --show means", ["square.obj", "--data FILE.npy"]),
        ("--u U.npy --show u:2", ["u:2 cannot be shown", "u:0 to u:1"]),
        ("--labels L.npy --show u:0", ["u:0 cannot be shown", "not U"]),
        ("--labels L.npy --show uncertainty", ["uncertainty cannot be shown", "not U"]),
        ("--u missing.npy", ["missing.npy", "No such file"]),
        ("--u five.npy", ["five.npy", "one row per vertex"]),
        ("--u one.npy", ["one.npy", "from 2 to 64"]),
        ("--u nan.npy", ["nan.npy", "row 2, column 1"]),
        ("--labels missing.npy", ["missing.npy", "No such file"]),
        ("--labels three.npy", ["three.npy", "one row per vertex"]),
        ("--labels negative.npy", ["negative.npy", "label -1 in row 2"]),
        ("--labels large.npy", ["large.npy", "label 64 in row 2"]),
        ("--labels S.npy", ["S.npy", "2 axes"]),
        ("--data D.npy --project xy", ["--project", "image:IMAGE"]),
        ("--data D.npy --out picture.jpg", ["picture.jpg", ".png"]),
        ("--data D.npy --out missing/picture.png", ["missing/picture.png", "No such file"]),
    ] {
        refuse(&folder, &format!("render square.obj {line}"), &parts);
    }
}

#[test]
fn folders_that_are_no_runs_are_refused() {
    let folder = folder();
    for name in ["empty", "labels", "run", "manifest", "experiment"] {
        fs::create_dir(folder.path(name)).unwrap();
    }
    let labels = array![0_i32, 1, 1, 0];
    for name in ["labels", "run", "experiment"] {
        write_npy(folder.path(name).join("labels.npy"), &labels).unwrap();
    }
    folder.write("manifest/manifest.json", "{}");
    folder.write("experiment/manifest.json", "{}");
    for (line, parts) in [
        ("empty", ["empty", "without labels.npy"]),
        ("labels", ["labels", "without segmented.ply"]),
        ("labels --u U.npy", ["labels", "name a mesh with --u"]),
        ("manifest", ["manifest", "first repetition"]),
        ("experiment", ["experiment/manifest.json", "no instance_id"]),
    ] {
        refuse(&folder, &format!("render {line}"), &parts);
    }
}

/// A file of a run that was lost or replaced is named.
#[test]
fn damaged_runs_are_refused() {
    let folder = folder();
    folder.done("solve square.obj --costs S.npy --lambda 0.1 --no-preview --out run");
    let damaged = |name: &str, content: Option<&[u8]>, line: &str, parts: &[&str]| {
        let path = folder.path("run").join(name);
        let original = fs::read(&path).unwrap();
        match content {
            Some(content) => fs::write(&path, content).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
        refuse(&folder, &format!("render run {line}"), parts);
        fs::write(path, original).unwrap();
    };
    damaged("labels.npy", None, "", &["run", "without labels.npy"]);
    damaged("segmented.ply", None, "", &["run", "without segmented.ply"]);
    damaged("u.npy", None, "", &["run/u.npy", "No such file"]);
    damaged("summary.json", None, "", &["run/summary.json", "No such file"]);
    damaged("summary.json", Some(b"{"), "", &["run/summary.json", "is not JSON"]);
    folder.done("mesh generate grid:2x2 --out grid.ply");
    let other = fs::read(folder.path("grid.ply")).unwrap();
    damaged("segmented.ply", Some(&other), "", &["run/u.npy", "the mesh has 9 vertices"]);
    // It has no data, and no means of any.
    for line in ["--show data", "--show means", "--data colors", "--data texture"] {
        refuse(
            &folder,
            &format!("render run {line}"),
            &["does not keep the data", "--u run/u.npy"],
        );
    }
    refuse(&folder, "render run --show u:2", &["u:2", "u:0 to u:1"]);
}

#[test]
fn malformed_requests_are_refused() {
    let folder = folder();
    for (line, part) in [
        ("--show label", "must be data, data+cut, means, labels, u:P or uncertainty"),
        ("--show u:x", "u:0"),
        ("--show ", "a value is required"),
        ("--views left", "must be auto"),
        ("--views front,30", "must be auto"),
        ("--views 30,100", "between -90 and 90"),
        ("--width 10", "from 20 to 420 mm"),
        ("--width 3in", "millimeters such as 85"),
        ("--columns 0", "0 is not in 1.."),
        ("--u U.npy --labels L.npy", "cannot be used with"),
    ] {
        misuse(&folder, &format!("render square.obj {line}"), part);
    }
}
