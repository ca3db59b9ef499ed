//! `--pairs`: cuts between each two labels weigh what a file says.

use meshseg::mesh::Shape;
use ndarray::{Array1, Array2, arr2};
use ndarray_npy::read_npy;

use crate::support::{Folder, costs, stderr};

const MESH: &str = "torus:24x16";

fn faces() -> usize {
    MESH.parse::<Shape>().unwrap().mesh().faces.len()
}

/// Costs, classes, and the same weights in three formats.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.array("S.npy", &costs(faces(), 4));
    folder.array("p.npy", &costs(faces(), 4).mapv(|s| (-6.0 * s).exp()));
    folder.write("classes.csv", "name\nwall\nroof\n\"tree, tall\"\nground\n");
    folder.write(
        "names.csv",
        "A, b, Weight\n0,roof,0.5\nroof, ground, 3\n\"tree, tall\",ground,2.5\n0,3,2.75\n1,2,1.25\n",
    );
    folder.write("matrix.csv", "0,0.5,1,2.75\n0.5,0,1.25,3\n1,1.25,0,2.5\n2.75,3,2.5,0\n");
    folder.array(
        "matrix.npy",
        &arr2(&[
            [0.0, 0.5, 1.0, 2.75],
            [0.5, 0.0, 1.25, 3.0],
            [1.0, 1.25, 0.0, 2.5],
            [2.75, 3.0, 2.5, 0.0],
        ]),
    );
    folder
}

/// Every format of the weights gives the same certified labels, other than without them, on faces and on vertices.
#[test]
fn weights_of_pairs_are_read_in_every_format() {
    let folder = prepared();
    let line = format!(
        "segment {MESH} --probabilities p.npy --classes classes.csv --lambda 0.05 --no-preview"
    );
    for on in ["faces", "vertices"] {
        let line = format!("{line} --on {on} --gap 1e-5");
        folder.done(&format!("{line} --out potts"));
        let potts: Array1<i32> = read_npy(folder.path("potts/labels.npy")).unwrap();
        let mut first: Option<(Array1<i32>, f64)> = None;
        for pairs in ["names.csv", "matrix.csv", "matrix.npy"] {
            let text = folder.done(&format!("{line} --pairs {pairs} --out weighted"));
            assert!(text.contains(&format!("cuts weigh as {pairs} says")), "{text}");
            let answer = folder.answer("weighted");
            assert_eq!(answer.status(), "converged");
            assert_eq!(answer.summary["relaxation"], "metric");
            assert_eq!(answer.summary["label_metric"][1][3].as_f64(), Some(3.0));
            let labels: Array1<i32> = read_npy(folder.path("weighted/labels.npy")).unwrap();
            let found = (labels, answer.number("rounded_energy"));
            assert_ne!(found.0, potts);
            assert_eq!(*first.get_or_insert_with(|| found.clone()), found, "{pairs} {on}");
        }
    }
}

/// What `solve` finds, `evaluate` and an exchanged problem confirm: the energy of labels by a sum over edges is theirs.
#[test]
fn weighted_energies_are_confirmed() {
    let folder = prepared();
    let line = format!("{MESH} --costs S.npy --on faces --lambda 0.02 --pairs matrix.csv");
    folder.done(&format!("solve {line} --gap 1e-6 --no-preview --out weighted"));
    let answer = folder.answer("weighted");
    let labels: Array1<i32> = read_npy(folder.path("weighted/face_labels.npy")).unwrap();
    let one_hot =
        Array2::from_shape_fn((labels.len(), 4), |(j, p)| f64::from(labels[j] == p as i32));
    folder.array("one-hot.npy", &one_hot);
    let scores = folder.done(&format!("evaluate {line} --u one-hot.npy --dual-steps 2000"));
    let scores: serde_json::Value = serde_json::from_str(&scores).unwrap();
    let [energy, bound] = ["energy", "dual_bound"].map(|key| scores[key].as_f64().unwrap());
    let size = energy.abs();
    assert!((energy - answer.number("rounded_energy")).abs() <= 1e-12 * size);
    assert!(bound <= answer.number("energy") + 1e-12 * size && bound >= energy - 0.05 * size);
    assert_eq!(scores["relaxation"], "metric");

    let mesh = MESH.parse::<Shape>().unwrap().mesh();
    let weights: Array2<f64> = read_npy(folder.path("matrix.npy")).unwrap();
    let s: Array2<f64> = read_npy(folder.path("S.npy")).unwrap();
    let weight = |a: i32, b: i32| weights[[a as usize, b as usize]];
    let mut sum: f64 =
        (0..labels.len()).map(|j| mesh.face_area(j) * s[[j, labels[j] as usize]]).sum();
    let mut sides = std::collections::BTreeMap::new();
    for (j, face) in mesh.faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            if let Some(k) = sides.insert((a.min(b), a.max(b)), j) {
                let length = (mesh.vertices[a as usize] - mesh.vertices[b as usize]).norm();
                sum += 2.0_f64.sqrt() * 0.02 * length * weight(labels[j], labels[k]);
            }
        }
    }
    assert!((sum - energy).abs() <= 1e-12 * size, "{sum} {energy}");

    let text = folder.done(&format!("problem export {line} --out problem.npz"));
    assert!(text.contains("metric"), "{text}");
    std::fs::create_dir(folder.path("trace")).unwrap();
    folder.write("trace/trace.csv", "iteration,seconds\n1,0.5\n");
    folder.array("trace/u_1.npy", &one_hot);
    folder.done("problem import-trace problem.npz trace --no-preview --out imported");
    let summary = std::fs::read(folder.path("imported/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    assert!((summary["energy"].as_f64().unwrap() - energy).abs() <= 1e-12 * size);
    assert_eq!(summary["label_metric"][3][2].as_f64(), Some(2.5));
}

#[test]
fn weights_that_do_not_fit_are_refused() {
    let folder = prepared();
    folder.write("empty.csv", "");
    folder.write("semicolons.csv", "a;b;weight\n0;1;2\n");
    folder.write("blank.csv", "\n\n");
    folder.write("header.csv", "x,y,z\n0,1,2\n");
    folder.write("unknown.csv", "a,b,weight\nwall,rof,2\n");
    folder.write("far.csv", "a,b,weight\n0,4,2\n");
    folder.write("same.csv", "a,b,weight\nroof,1,2\n");
    folder.write("twice.csv", "a,b,weight\n0,1,2\n1,0,2\n");
    folder.write("cells.csv", "a,b,weight\n0,1\n");
    folder.write("word.csv", "a,b,weight\n0,1,much\n");
    folder.write("ragged.csv", "0,1,1,1\n1,0,1\n");
    folder.write("three.csv", "0,1,1\n1,0,1\n1,1,0\n");
    folder.write("long.csv", "a,b,weight\nwall,ground,2.5\n");
    folder.write("zero.csv", "a,b,weight\nwall,ground,0\n");
    folder.write("one-way.csv", "0,2,1,1\n1,0,1,1\n1,1,0,1\n1,1,1,0\n");
    let segment =
        format!("segment {MESH} --probabilities p.npy --classes classes.csv --lambda 0.05");
    let solve = format!("solve {MESH} --costs S.npy --on faces --lambda 0.05");
    for (line, part) in [
        ("--pairs none.csv", "none.csv"),
        ("--pairs empty.csv", "is empty"),
        ("--pairs semicolons.csv", "`a;b;weight` is not a number; separate cells by commas"),
        ("--pairs blank.csv", "has no weights"),
        ("--pairs header.csv", "`x` is not a number; write a row of weights for each label"),
        ("--pairs unknown.csv", "line 2: no class is called `rof`; did you mean \"roof\"?"),
        ("--pairs far.csv", "line 2: there is no label 4: they are 0 to 3"),
        ("--pairs same.csv", "line 2: `roof` and `1` are one label"),
        ("--pairs twice.csv", "line 3: `1` and `0` have a weight already"),
        ("--pairs cells.csv", "line 2: has 2 cells"),
        ("--pairs word.csv", "line 2: `much` is not a number"),
        ("--pairs ragged.csv", "line 2: has 3 cells; the first row has 4"),
        ("--pairs three.csv", "has 3 x 3 weights, but 4 labels need 4 x 4"),
        ("--pairs long.csv", "more than 1.0 + 1.0 by way of label 1"),
        ("--pairs zero.csv", "must be positive and finite"),
        ("--pairs one-way.csv", "a cut has no direction"),
    ] {
        let before = folder.listing();
        let output = folder.run(&format!("{segment} {line} --out none"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains(part) && message.trim_end().lines().count() == 1, "{message}");
        assert_eq!(folder.listing(), before);
    }
    for (line, part) in [
        (format!("{solve} --pairs unknown.csv"), "names need --classes"),
        (format!("{solve} --pairs matrix.csv --precision f32"), "no weights of pairs of labels"),
        (
            format!("segment {MESH} --data curvature --regions 3 --pairs matrix.csv"),
            "supply --probabilities",
        ),
    ] {
        let output = folder.run(&format!("{line} --out none"));
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    for option in ["--relaxation separate", "--label-gap 1e-3"] {
        let output = folder.run(&format!("{solve} --pairs matrix.csv {option} --out none"));
        assert_eq!(output.status.code(), Some(2), "{option}");
    }
}
