//! `compare`: results with each other, with arrays, and with human segmentations in files that the tests write.

use ndarray::{Array1, Array2, array};
use ndarray_npy::write_npy;
use serde_json::Value;

use crate::support::{Folder, SQUARE_OBJ, costs, stderr};

fn labels(folder: &Folder, name: &str, labels: &[i32]) {
    write_npy(folder.path(name), &Array1::from(labels.to_vec())).unwrap();
}

fn compare(folder: &Folder, arguments: &str) -> Value {
    serde_json::from_str(&folder.done(&format!("compare {arguments} --json"))).unwrap()
}

fn assert_close(value: &Value, exact: f64) {
    let found = value.as_f64().unwrap();
    assert!((found - exact).abs() < 1e-12, "{found}, {exact}");
}

/// A file of human segmentations, given as rows of pixels; uncompressed.
fn mat(humans: &[Array2<u16>]) -> Vec<u8> {
    let element = |kind: u32, data: &[u8]| {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let matrix = |class: u8, [rows, columns]: [usize; 2], name: &str, content: &[u8]| {
        let size = [rows as u32, columns as u32].map(u32::to_le_bytes).concat();
        let head = [element(6, &[class, 0, 0, 0, 0, 0, 0, 0]), element(5, &size)].concat();
        element(14, &[&head, element(1, name.as_bytes()).as_slice(), content].concat())
    };
    let cells: Vec<Vec<u8>> = humans
        .iter()
        .map(|human| {
            let (rows, columns) = human.dim();
            let pixels: Vec<u8> = human.t().iter().flat_map(|label| label.to_le_bytes()).collect();
            let image = matrix(11, [rows, columns], "", &element(4, &pixels));
            let names = [element(5, &13_u32.to_le_bytes()), element(1, b"Segmentation\0")].concat();
            matrix(2, [1, 1], "", &[names, image].concat())
        })
        .collect();
    let truth = matrix(1, [1, cells.len()], "groundTruth", &cells.concat());
    [format!("{:<124}", "MATLAB 5.0").as_bytes(), b"\x00\x01IM", &truth].concat()
}

/// The square of two triangles: vertices 0 and 2 have a third of the area, 1 and 3 a sixth.
#[test]
fn vertices_count_alike_or_with_their_areas() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    labels(&folder, "a.npy", &[0, 0, 1, 1]);
    labels(&folder, "b.npy", &[5, 5, 5, 2]);
    let equal = compare(&folder, "a.npy b.npy");
    let it = &equal["each"][0];
    assert_close(&it["accuracy"], 0.75);
    assert_close(&it["rand_index"], 0.625);
    assert_close(&it["adjusted_rand_index"], 0.25);
    assert_close(&it["covering"], 0.625);
    assert_eq!((&equal["weights"], &equal["vertices"]), (&"equal".into(), &4.into()));
    assert_eq!((&it["regions"], &it["truth_regions"]), (&2.into(), &2.into()));
    assert!(equal["boundary"].is_null() && it["boundary"].is_null());
    let area = compare(&folder, "a.npy b.npy --mesh square.obj");
    assert_close(&area["each"][0]["accuracy"], 2.0 / 3.0);
    assert_eq!(area["weights"], "area");
    let table = folder.done("compare a.npy b.npy");
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split_whitespace().collect()).collect();
    assert_eq!(rows[0].join(" "), "2 regions on 4 vertices, each with the same weight");
    assert_eq!(rows[3], ["truth", "2", "0.7500", "0.6250", "0.2500", "1.1887", "0.6250"]);
    labels(&folder, "c.npy", &[-1, 0, 1, 1]);
    assert_eq!(compare(&folder, "c.npy b.npy")["each"][0]["unknown"], 1);
    let table = folder.done("compare c.npy b.npy");
    assert!(table.starts_with("2 regions on 4 vertices, 1 of them unknown and left out, each"));
    labels(&folder, "one.npy", &[3, 3, 3, 3]);
    let output = folder.run("compare one.npy b.npy");
    assert!(output.status.success() && stderr(&output).contains("all labels are equal; segment"));
}

#[test]
fn a_result_agrees_with_itself_whatever_its_labels_are_called() {
    let folder = Folder::new();
    folder.array("S.npy", &costs(231, 3));
    let answer = folder.solve("grid:20x10 --costs S.npy --lambda 0.01 --no-preview", "out");
    let renamed: Vec<i32> = answer.labels.iter().map(|p| [7, 9, 4][*p as usize]).collect();
    labels(&folder, "renamed.npy", &renamed);
    for truth in ["out", "out/labels.npy", "renamed.npy"] {
        let it = compare(&folder, &format!("out {truth} --mesh grid:20x10"));
        for key in ["accuracy", "rand_index", "adjusted_rand_index", "covering"] {
            assert_close(&it["mean"][key], 1.0);
        }
        assert_eq!(it["mean"]["variation_of_information"], 0.0);
        assert_eq!(it["boundary"]["f"], 1.0);
        // The grid has 21 x 11 vertices.
        assert_close(&it["boundary_tolerance"], 0.0075 * 21_f64.hypot(11.0));
    }
}

/// 5 x 3 pixels, rows from the top; vertices of the grid from the lower left.
#[test]
fn humans_are_compared_on_a_grid_or_as_pixels() {
    let folder = Folder::new();
    let human = array![[1, 1, 2, 2, 2], [1, 1, 2, 2, 2], [3, 3, 3, 3, 3_u16]];
    let other = array![[1, 1, 2, 2, 2], [1, 1, 2, 2, 2], [1, 1, 2, 2, 2_u16]];
    folder.write("t.mat", mat(&[human, other]));
    labels(&folder, "pixels.npy", &[8, 8, 5, 5, 5, 8, 8, 5, 5, 5, 0, 0, 0, 0, 0]);
    labels(&folder, "vertices.npy", &[0, 0, 0, 0, 0, 8, 8, 5, 5, 5, 8, 8, 5, 5, 5]);
    for line in ["pixels.npy t.mat --image-size 5x3", "vertices.npy t.mat --mesh grid:4x2"] {
        let it = compare(&folder, line);
        assert_close(&it["each"][0]["accuracy"], 1.0);
        assert_eq!(it["each"][0]["boundary"]["f"], 1.0);
        assert!(it["each"][1]["accuracy"].as_f64().unwrap() < 0.9);
        // Every boundary pixel is one of the first human's.
        assert_eq!(it["boundary"]["precision"], 1.0);
        let table = folder.done(&format!("compare {line}"));
        let last: Vec<&str> = table.lines().last().unwrap().split_whitespace().collect();
        assert_eq!((last.len(), &last[..2]), (10, &["all", "humans"][..]), "{table}");
    }
    // The mean of accuracies 1 and 2/3.
    assert_close(
        &compare(&folder, "pixels.npy t.mat --image-size 5x3")["mean"]["accuracy"],
        5.0 / 6.0,
    );
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    labels(&folder, "a.npy", &[0, 0, 1, 1]);
    labels(&folder, "five.npy", &[0, 0, 1, 1, 1]);
    labels(&folder, "none.npy", &[]);
    labels(&folder, "unknown.npy", &[-1, -1, -1, -1]);
    folder.array("square.npy", &array![[0.0, 1.0], [1.0, 0.0]]);
    write_npy(folder.path("float.npy"), &array![0.0, 1.0, 1.0, 0.0]).unwrap();
    write_npy(folder.path("many.npy"), &Array1::from_iter(0..2000_i32)).unwrap();
    folder.write("text.npy", "0 0 1 1");
    folder.write("bad.mat", "MATLAB 5.0 MAT-file");
    folder.write("t.mat", mat(&[array![[1, 1], [2, 2_u16]]]));
    folder.write("empty.mat", mat(&[]));
    std::fs::create_dir(folder.path("folder")).unwrap();
    for (line, part) in [
        ("a.npy five.npy", "five.npy: has 5 labels, but a.npy has 4; both must label"),
        ("a.npy none.npy", "none.npy: has no labels"),
        ("a.npy float.npy", "float.npy: holds <f8, not integers"),
        ("square.npy a.npy", "square.npy: has 2 axes; it must have 1"),
        ("a.npy text.npy", "text.npy: is not a .npy file"),
        ("a.npy missing.npy", "missing.npy: "),
        ("a.npy folder", "folder: has no labels.npy; name a result folder"),
        ("a.npy unknown.npy", "no vertex has a weight and a known label"),
        (
            "many.npy many.npy",
            "many.npy and many.npy: the labeling has more than 1024 different labels",
        ),
        ("a.npy a.npy --mesh grid:2x2", "a.npy: has 4 labels, but grid:2x2 has 9 vertices"),
        ("a.npy a.npy --mesh missing.obj", "missing.obj"),
        ("a.npy a.npy --image-size 3x2", "a.npy: has 4 labels, but an image of 3 x 2 pixels has 6"),
        ("a.npy a.npy --mesh grid:1x1 --image-size 4x1", "the grid has 2 x 2 vertices"),
        ("a.npy t.mat", "t.mat: is compared with labels on a grid or of pixels; add --mesh"),
        ("a.npy t.mat --image-size 1x4", "t.mat: has images of 2 x 2 pixels, not 1 x 4"),
        ("a.npy bad.mat --mesh grid:1x1", "bad.mat: is not a MATLAB file of version 5 to 7"),
        ("a.npy empty.mat --mesh grid:1x1", "empty.mat: holds no human segmentations"),
    ] {
        let output = folder.run(&format!("compare {line}"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{line}\n{message}");
        assert!(output.stdout.is_empty() && message.lines().count() == 1, "{line}\n{message}");
        assert!(message.starts_with("error: ") && message.len() < 300, "{line}\n{message}");
        assert!(message.contains(part), "{line}: {part:?} is not in\n{message}");
    }
    for size in ["0x3", "4", "4x", "4x1x1", "99999999999x1"] {
        let output = folder.run(&format!("compare a.npy a.npy --image-size {size}"));
        assert_eq!(output.status.code(), Some(2), "{size}");
        assert!(stderr(&output).contains("such as 481x321"), "{size}");
    }
}
