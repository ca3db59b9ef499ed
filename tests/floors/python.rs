//! Which modules of a Python package import which, at the top of the file or later.

use std::fs;
use std::path::Path;

use crate::graph::Edges;

/// The imports among the modules in a folder that has the name of the package.
pub fn edges(folder: &Path) -> Edges {
    let package = folder.file_name().expect("a name").to_string_lossy().into_owned();
    let mut edges = Edges::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|end| end != "py") {
            continue;
        }
        let from = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let text = fs::read_to_string(&path).expect("a text");
        for line in text.lines().map(str::trim) {
            let Some((module, names)) =
                line.strip_prefix("from ").and_then(|rest| rest.split_once(" import "))
            else {
                continue;
            };
            if module == package {
                // The imported names are modules.
                edges.extend(names.split(", ").map(|to| (from.clone(), to.to_owned())));
            } else if let Some(to) = module.strip_prefix(&format!("{package}.")) {
                edges.insert((from.clone(), to.to_owned()));
            }
        }
    }
    edges
}
