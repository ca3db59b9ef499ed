//! The imports among the files of the report page.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::graph::Edges;

/// The imports among all files below a folder, named relative to it.
pub fn edges(folder: &Path) -> Edges {
    let mut edges = Edges::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(&at).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "ts") {
                let text = fs::read_to_string(&path).expect("a text");
                // `import { ... } from "./name";`
                for part in text.split("from \".").skip(1) {
                    let target =
                        at.join(format!(".{}.ts", part.split('"').next().expect("a name")));
                    edges.insert((name(&path, folder), name(&target, folder)));
                }
            }
        }
    }
    edges
}

fn name(path: &Path, folder: &Path) -> String {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    let below = plain.strip_prefix(folder).expect("a file of the page");
    below.display().to_string().replace('\\', "/")
}
