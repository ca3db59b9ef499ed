//! The code is organized as DESIGN.md says: it lists every room, imports point downwards, and there are no circular
//! imports in any of the three languages.

mod graph;
mod python;
mod rust;
mod typescript;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use graph::{Edges, cycles};
use rust::Crate;

/// The rooms of section 2 of DESIGN.md, from the top: files and folders of `src`.
fn floors() -> Vec<String> {
    let design = fs::read_to_string("DESIGN.md").expect("the map");
    let house =
        design.split("\n## ").find(|part| part.starts_with("2. The house")).expect("section 2");
    let rooms = house.lines().skip_while(|line| !line.starts_with("    src/lib.rs"));
    let rooms = rooms.skip(1).take_while(|line| line.starts_with("        "));
    let names = rooms.map(|line| line[8..].split_once(' ').expect("what it is").0);
    let names =
        names.filter_map(|name| name.strip_suffix(".rs").or_else(|| name.strip_suffix('/')));
    names.map(str::to_owned).collect()
}

fn library() -> Crate {
    Crate::read(Path::new("src/lib.rs"))
}

fn program() -> Crate {
    Crate::read(Path::new("src/main.rs"))
}

#[test]
fn the_map_has_every_room_once() {
    let floors = floors();
    let named: BTreeSet<&String> = floors.iter().collect();
    assert_eq!(named.len(), floors.len(), "DESIGN.md lists a room twice");
    let there: BTreeSet<String> = library().rooms().chain(program().rooms()).collect();
    assert_eq!(named, there.iter().collect(), "DESIGN.md and the files of src");
}

#[test]
fn no_import_points_upwards() {
    let floors = floors();
    let floor = |room: &str| floors.iter().position(|name| name == room);
    let library = library();
    let mut named = library.named(None);
    named.extend(program().named(Some(&library)));
    let upwards: Vec<String> = named
        .iter()
        .filter(|(from, to)| floor(from) > floor(to))
        .map(|(from, to)| format!("{from} imports {to}, which stands above it"))
        .collect();
    assert!(upwards.is_empty(), "{}", upwards.join("\n"));
}

#[test]
fn no_files_of_the_crate_import_each_other_circularly() {
    let library = library();
    let mut edges = library.edges(None);
    edges.extend(program().edges(Some(&library)));
    assert_no_cycles(cycles(&edges));
}

#[test]
fn no_files_of_the_page_import_each_other_circularly() {
    let edges = typescript::edges(Path::new("assets/report/src"));
    assert!(edges.contains(&("chart/curves.ts".into(), "chart/samples.ts".into())));
    assert_no_cycles(cycles(&edges));
}

#[test]
fn no_reference_solvers_import_each_other_circularly() {
    let edges = python::edges(Path::new("experiments/reference/meshseg_reference"));
    // Also if it is imported inside a function.
    assert!(edges.contains(&("__main__".into(), "check".into())));
    assert_no_cycles(cycles(&edges));
}

fn assert_no_cycles(cycles: Vec<Vec<String>>) {
    let listed: Vec<String> = cycles.iter().map(|files| files.join(" and ")).collect();
    assert!(listed.is_empty(), "circular imports: {}", listed.join("\n"));
}

/// Ensures that the other tests see the imports.
#[test]
fn imports_are_followed_to_the_files_that_define_the_items() {
    let edges = library().edges(None);
    let has = |from: &str, to: &str| edges.contains(&(format!("src/{from}"), format!("src/{to}")));
    assert!(has("solve.rs", "coarse.rs"));
    // Re-exported by `solve`, by `data`, by the root.
    assert!(has("segment.rs", "request.rs"));
    assert!(
        has("experiment/instance.rs", "data/constant.rs") && !has("segment.rs", "data/constant.rs")
    );
    assert!(has("solver/chambolle_pock/rows.rs", "solver/interface.rs"));
    // Without a `use`; a macro; from a parent.
    assert!(has("evaluate.rs", "request.rs"));
    assert!(has("evaluate.rs", "regions.rs"));
    assert!(has("mesh/weld/near.rs", "mesh/weld/table.rs"));
    // Imported only by tests, and named only in a comment.
    assert!(!edges.iter().any(|(_, to)| to == "src/samples.rs"));
    assert!(!has("regions.rs", "run.rs"));
}

#[test]
fn cycles_are_found() {
    let edges = |pairs: &[(&str, &str)]| -> Edges {
        pairs.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect()
    };
    let line = edges(&[("a", "b"), ("b", "c"), ("a", "c"), ("d", "c")]);
    assert!(cycles(&line).is_empty());
    let circle = edges(&[("a", "b"), ("b", "c"), ("c", "b"), ("c", "d"), ("x", "y"), ("y", "x")]);
    assert_eq!(cycles(&circle), [["b", "c"], ["x", "y"]]);
}
