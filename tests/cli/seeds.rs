//! `--seeds` and `--regions auto`: labels that are given, and a number of regions that is chosen.

use ndarray::{Array1, Array2};
use ndarray_npy::{read_npy, write_npy};

use crate::support::{Folder, stderr};

const MESH: &str = "grid:20x20";
const VERTICES: usize = 21 * 21;

/// Four values, one per quarter of the grid, with a bounded perturbation.
fn quarters(folder: &Folder) {
    let value = |k: usize| {
        let [x, y] = [k % 21, k / 21].map(|i| f64::from(u8::from(i > 10)));
        x + 2.0 * y + 0.1 * (k as f64).sin()
    };
    write_npy(folder.path("data.npy"), &Array1::from_shape_fn(VERTICES, value)).unwrap();
}

fn labels(folder: &Folder, out: &str) -> Array1<i32> {
    read_npy(folder.path(out).join("labels.npy")).unwrap()
}

/// Vertices and faces, tables and arrays: the labels agree with all of them, and regions are numbered as they say.
#[test]
fn labels_agree_with_seeds_of_any_format() {
    let folder = Folder::new();
    quarters(&folder);
    let common = format!("segment {MESH} --data data.npy --regions 4 --lambda 0.01 --no-preview");
    // The corners of the grid in an order that no clustering would give.
    folder.write("seeds.csv", "vertex,region\n0,2\n20,0\n420, 3\n440,1\n");
    folder.done(&format!("{common} --seeds seeds.csv --out table"));
    let table = labels(&folder, "table");
    assert_eq!([0, 20, 420, 440].map(|k| table[k]), [2, 0, 3, 1]);
    let mut array = Array1::from_elem(VERTICES, -1_i8);
    for (k, p) in [(0, 2), (20, 0), (420, 3), (440, 1)] {
        array[k] = p;
    }
    write_npy(folder.path("seeds.npy"), &array).unwrap();
    folder.done(&format!("{common} --seeds seeds.npy --out array"));
    assert_eq!(labels(&folder, "array"), table);
    let answer = folder.answer("array");
    assert_eq!((answer.number("seed_vertices"), answer.status()), (4.0, "converged"));
    assert_eq!(answer.summary["init"], "seeds");

    // Face 0 is at vertex 0; a seed that contradicts its data is obeyed, and the labels cost more.
    folder.write("face.csv", "face,region\n0,2\n799,2\n");
    folder.done(&format!("{common} --seeds face.csv --out face"));
    let face = labels(&folder, "face");
    assert!(face[0] == 2 && face[440] == 2, "{} {}", face[0], face[440]);
    assert!(folder.answer("face").number("relative_gap") <= 1e-4);
}

/// `solve` takes seeds for any costs, and so does `segment` with given means.
#[test]
fn given_costs_and_means_respect_seeds() {
    let folder = Folder::new();
    quarters(&folder);
    let data: Array1<f64> = read_npy(folder.path("data.npy")).unwrap();
    let mu = [0.0, 1.0, 2.0, 3.0];
    let costs = Array2::from_shape_fn((VERTICES, 4), |(k, p)| (data[k] - mu[p]).powi(2));
    folder.array("costs.npy", &costs);
    write_npy(folder.path("mu.npy"), &Array2::from_shape_fn((4, 1), |(p, _)| mu[p])).unwrap();
    folder.write("seeds.csv", "vertex,region\n0,3\n");
    for mass in ["barycentric", "consistent"] {
        let common = format!("--lambda 0.01 --mass {mass} --seeds seeds.csv --no-preview");
        let solve = format!("solve {MESH} --costs costs.npy --relaxation separate");
        folder.done(&format!("{solve} {common} --out solved-{mass}"));
        let segment = format!("segment {MESH} --data data.npy --means mu.npy --normalize none");
        folder.done(&format!("{segment} {common} --out given-{mass}"));
        let [solved, given] =
            ["solved", "given"].map(|name| folder.answer(&format!("{name}-{mass}")));
        assert_eq!(given.u, solved.u);
        assert_eq!(solved.u[[0, 3]], 1.0);
        assert_eq!(labels(&folder, &format!("solved-{mass}"))[0], 3);
    }
}

#[test]
fn wrong_seeds_are_refused_with_their_line() {
    let folder = Folder::new();
    quarters(&folder);
    let cases = [
        ("vertex,region\n0,1\n441,0\n", "line 3: 441 is out of range; the 441 vertices"),
        ("vertex,region\n-1,0\n", "line 2: -1 is out of range"),
        ("face,region\n800,0\n", "line 2: 800 is out of range; the 800 faces"),
        ("vertex,region\n0,4\n", "line 2: region 4 is out of range; the 4 regions"),
        ("vertex,region\n0,1\n5,2\n0,2\n", "line 4: vertex 0 is already a seed of region 1"),
        ("vertex,region\n0,x\n", "line 2: `x` is not an integer"),
        ("vertex,region\n", "has no seeds"),
        ("0,1\n", "line 1: must begin with the line"),
        ("", "is empty"),
        ("vertex,region\n0\n", "line 2: has 1 number; it must have two"),
        ("vertex,region\n0,1,2\n", "line 2: has 3 numbers"),
    ];
    let common = format!("segment {MESH} --data data.npy --no-preview --out out");
    for (content, message) in cases {
        folder.write("seeds.csv", content);
        let output = folder.run(&format!("{common} --regions 4 --seeds seeds.csv"));
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains("seeds.csv") && text.contains(message), "{message}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    }
    write_npy(folder.path("short.npy"), &Array1::from_elem(7, -1)).unwrap();
    write_npy(folder.path("none.npy"), &Array1::from_elem(VERTICES, -1)).unwrap();
    folder.write("good.csv", "vertex,region\n0,1\n");
    for (arguments, message) in [
        ("--regions 4 --seeds short.npy", "short.npy: has 7 integers; the mesh has 441 vertices"),
        ("--regions 4 --seeds none.npy", "none.npy: has no seeds"),
        ("--regions 4 --seeds missing.csv", "missing.csv"),
        ("--regions 4 --model kmeans --seeds good.csv", "good.csv: --seeds does not apply"),
        ("--regions auto --seeds good.csv", "good.csv: seeds name regions by numbers"),
        ("--regions auto --model gaussian", "constant and l1 only"),
    ] {
        let output = folder.run(&format!("{common} {arguments}"));
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains(message), "{message}: {text}");
    }
    assert!(!folder.path("out").exists());
}

/// Four different values are four regions, whatever the range.
#[test]
fn the_number_of_regions_is_that_of_the_clusters() {
    let folder = Folder::new();
    quarters(&folder);
    let common = format!("segment {MESH} --data data.npy --lambda 0.01 --no-preview");
    for (regions, model) in [("auto", "constant"), ("auto:3..6", "l1")] {
        let out = format!("{model}-out");
        let text =
            folder.done(&format!("{common} --regions {regions} --model {model} --out {out}"));
        assert!(text.contains("regions chosen  4, by the largest index"), "{text}");
        assert_eq!(folder.answer(&out).number("regions"), 4.0);
        let tried = folder.answer(&out).summary["regions_tried"].as_array().unwrap().len();
        assert_eq!(tried, if regions == "auto" { 7 } else { 4 });
    }
    for wrong in ["auto:8..2", "auto:1..3", "auto:2..65", "auto:", "auto:3", "1", "65", "x"] {
        let output = folder.run(&format!("{common} --regions {wrong} --out wrong"));
        assert_eq!(output.status.code(), Some(2), "{wrong}: {}", stderr(&output));
    }
}
