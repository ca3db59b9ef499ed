//! Bad input: each case ends with exit code 1 and one line that names the cause, or with 2 for a malformed command
//! line, and no files are written.

mod arguments;
mod arrays;
mod images;
mod meshes;
mod outputs;
mod photographs;
mod pictures;
mod views;

use std::time::Instant;

use crate::support::{Folder, HANGS, SQUARE_OBJ, stderr};

/// A square mesh and costs, U and data that fit it.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    folder.array("S.npy", &ndarray::array![[0.0, 1.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    folder.array("U.npy", &ndarray::array![[0.0, 1.0], [1.0, 0.0], [1.0, 0.0], [0.5, 0.5]]);
    folder.array("D.npy", &ndarray::array![[0.0], [1.0], [1.0], [0.0]]);
    folder
}

/// Runs a command line that must fail with exit code 1; the one line on stderr has each of `parts`.
fn refuse(folder: &Folder, line: &str, parts: &[&str]) {
    let before = folder.listing();
    let begin = Instant::now();
    let output = folder.run(line);
    assert!(begin.elapsed() < HANGS);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{line}\n{message}");
    assert!(output.stdout.is_empty(), "{line}");
    assert!(message.starts_with("error: ") && message.ends_with('\n'), "{line}\n{message}");
    assert_eq!(message.lines().count(), 1, "{line}\n{message}");
    assert!(message.len() < 300, "{line}\n{message}");
    for part in parts {
        assert!(message.contains(part), "{line}: {part:?} is not in\n{message}");
    }
    assert_eq!(folder.listing(), before, "{line}");
}

/// Runs a malformed command line.
fn misuse(folder: &Folder, line: &str, part: &str) {
    let before = folder.listing();
    let output = folder.run(line);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{line}\n{message}");
    assert!(output.stdout.is_empty(), "{line}");
    assert!(message.contains(part), "{line}: {part:?} is not in\n{message}");
    assert!(!message.contains("panicked"), "{line}\n{message}");
    assert_eq!(folder.listing(), before, "{line}");
}

/// The verbs that read a mesh, with all other arguments.
const VERBS: [(&str, &str); 7] = [
    ("segment", "--data D.npy --regions 2 --out out"),
    ("solve", "--costs S.npy --lambda 0.1 --out out"),
    ("evaluate", "--costs S.npy --lambda 0.1 --u U.npy"),
    ("operators", "--out out"),
    ("render", "--u U.npy --show labels --out out.png"),
    ("mesh info", ""),
    ("mesh convert", "--out out.ply"),
];
