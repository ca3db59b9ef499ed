//! `batch`: many meshes, one line each.

use ndarray::Array2;

use crate::support::{Folder, names, stderr};

fn folder() -> Folder {
    let folder = Folder::new();
    let p = Array2::from_shape_fn((32, 2), |(j, p)| if (j < 16) == (p == 0) { 0.9 } else { 0.1 });
    folder.array("p.npy", &p);
    folder.array("short.npy", &Array2::from_elem((3, 2), 0.5));
    folder
}

/// A mesh that fails has its line, and the others are done; the next call does what is missing.
#[test]
fn one_bad_mesh_stops_no_other() {
    let folder = folder();
    folder.write(
        "list.csv",
        "mesh,probabilities,lambda,out\ngrid:4x4,p.npy,0.01,a\ngrid:4x4,short.npy,,b\nmissing.ply,p.npy,,c\n\
         grid:4x4,p.npy,,d\n",
    );
    let output = folder.run("batch list.csv -- --no-preview --on faces");
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4, "{text}");
    for (line, part) in lines.iter().zip([
        "grid:4x4: converged, 32 faces, 2 regions, labels at most 0.00 % above any labeling",
        "grid:4x4: error: short.npy: has 3 rows",
        "missing.ply: error: missing.ply",
        "grid:4x4: converged",
    ]) {
        assert!(line.starts_with(part), "{line}");
    }
    assert!(stderr(&output).contains("2 of 4 meshes segmented, 2 failed"), "{}", stderr(&output));
    assert_eq!(folder.answer("a").number("lambda"), 0.01);
    assert!(!names(&folder.path("a")).contains("preview.png"));
    assert!(!folder.path("b").exists() && !folder.path("c").exists() && folder.path("d").exists());

    folder.array("short.npy", &Array2::from_elem((32, 2), 0.5));
    let output = folder.run("batch list.csv --resume -- --no-preview --on faces");
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(stderr(&output).contains("1 of 4 meshes segmented, 2 had results before, 1 failed"));
}

#[test]
fn a_shard_is_a_part_of_the_list() {
    let folder = folder();
    let rows: String = (0..5).map(|i| format!("grid:4x4,p.npy,out-{i}\n")).collect();
    folder.write("list.csv", format!("mesh,probabilities,out\n{rows}"));
    let text = folder.done("batch list.csv --shard 2/3 -- --no-preview");
    assert_eq!(text.lines().count(), 2, "{text}");
    for (i, made) in [false, true, false, false, true].into_iter().enumerate() {
        assert_eq!(folder.path(&format!("out-{i}")).exists(), made, "{i}");
    }
}

#[test]
fn wrong_lists_are_refused_before_any_mesh() {
    let folder = folder();
    for (list, part) in [
        ("mesh,probabilities\ngrid:4x4,p.npy\n", "among them mesh and out"),
        ("mesh,out,probs\ngrid:4x4,a,p.npy\n", "\"probs\" is neither mesh nor an option"),
        ("mesh,out,components\ngrid:4x4,a,true\n", "components has no value"),
        ("mesh,out,out\ngrid:4x4,a,b\n", "has the column out twice"),
        (
            "mesh,out,probabilities\ngrid:4x4,a,p.npy\ngrid:4x4,a,p.npy\n",
            "line 3: writes to a, as line 2",
        ),
        ("mesh,out\n,a\n", "line 2: needs a mesh"),
        ("mesh,out\n", "has no meshes"),
        ("mesh,out\ngrid:4x4\n", "list.csv"),
    ] {
        folder.write("list.csv", list);
        let before = folder.listing();
        let output = folder.run("batch list.csv");
        assert_eq!(output.status.code(), Some(1), "{list}");
        assert!(
            stderr(&output).contains(part) && stderr(&output).lines().count() == 1,
            "{}",
            stderr(&output)
        );
        assert_eq!(folder.listing(), before);
    }
    assert_eq!(folder.run("batch list.csv --shard 3/2").status.code(), Some(2));
}
