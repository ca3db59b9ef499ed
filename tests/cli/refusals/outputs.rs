//! Output paths that cannot be written.

use std::fs;

use super::{VERBS, folder, refuse};
use crate::support::{Folder, stderr};

/// The verbs that write a folder fail before they compute anything.
#[test]
fn folders_that_cannot_be_created_are_refused() {
    let folder = folder();
    folder.write("file", "mine");
    for (verb, rest) in VERBS.iter().filter(|(_, rest)| rest.ends_with("--out out")) {
        for (out, part) in [
            ("file", "is a file"),
            ("file/below", "above it is a file"),
            ("file/far/below", "above it is a file"),
        ] {
            let rest = rest.replace("--out out", &format!("--out {out}"));
            refuse(&folder, &format!("{verb} square.obj {rest}"), &[out, part]);
        }
    }
    assert_eq!(fs::read(folder.path("file")).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn dangling_links_are_refused() {
    let folder = folder();
    std::os::unix::fs::symlink("nowhere", folder.path("link")).unwrap();
    refuse(&folder, "operators square.obj --out link", &["link", "is a dangling link"]);
}

/// Not even the superuser can write there.
#[cfg(target_os = "linux")]
#[test]
fn folders_that_cannot_be_written_to_are_refused() {
    let folder = folder();
    for out in ["/proc", "/proc/meshseg", "/proc/mesh/seg"] {
        refuse(&folder, &format!("operators square.obj --out {out}"), &[out, "cannot be written"]);
    }
}

#[test]
fn files_that_cannot_be_written_are_refused() {
    let folder = folder();
    folder.write("file", "mine");
    fs::create_dir(folder.path("folder.ply")).unwrap();
    for (out, part) in [
        ("out.xyz", ".obj, .ply, .off, .stl, .vtp and .vtu"),
        ("out", ".obj, .ply, .off, .stl, .vtp and .vtu"),
        (".ply", ".obj, .ply, .off, .stl, .vtp and .vtu"),
        ("missing/out.ply", "No such file"),
        ("file/out.ply", "Not a directory"),
        ("folder.ply", "folder.ply"),
    ] {
        refuse(&folder, &format!("mesh generate grid:2x2 --out {out}"), &[out, part]);
        refuse(&folder, &format!("mesh convert square.obj --out {out}"), &[out, part]);
    }
    let message = stderr(&folder.run("mesh generate grid:2x2 --out missing/out.ply"));
    assert!(!message.contains(".meshseg-"), "the temporary name: {message}");
    // Binary STL holds 32-bit coordinates.
    folder.write("large.obj", "v 0 0 0\nv 1e45 0 0\nv 0 1e45 0\nf 1 2 3\n");
    refuse(&folder, "mesh convert large.obj --out out.stl", &["out.stl"]);
}

/// A link stays a link: what it leads to is replaced, or made.
#[cfg(unix)]
#[test]
fn links_to_files_are_followed() {
    use std::os::unix::fs::symlink;

    let folder = Folder::new();
    std::fs::create_dir(folder.path("there")).unwrap();
    folder.write("there/old.ply", "old");
    symlink("there/old.ply", folder.path("link.ply")).unwrap();
    symlink(folder.path("link.ply"), folder.path("twice.ply")).unwrap();
    symlink("there/new.ply", folder.path("dangling.ply")).unwrap();
    symlink("round.ply", folder.path("round.ply")).unwrap();
    for (name, target) in [("link", "old"), ("twice", "old"), ("dangling", "new")] {
        folder.write("there/old.ply", "old");
        folder.done(&format!("mesh generate grid:3x2 --out {name}.ply"));
        assert!(folder.path(&format!("{name}.ply")).is_symlink());
        let written = std::fs::read(folder.path(&format!("there/{target}.ply"))).unwrap();
        assert!(written.starts_with(b"ply"), "{name}");
    }
    let output = folder.run("mesh generate grid:3x2 --out round.ply");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("too many links"), "{}", stderr(&output));
}
