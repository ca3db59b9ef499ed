//! `meshseg experiment`: experiment files, runs that survive crashes, figures with their sources.

mod classes;
mod cluster;
mod files;
mod labeling;
mod reconstruct;
mod report;
mod runs;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::{Folder, names};

/// Two instances, two solvers and two repetitions that take a moment.
pub const SMALL: &str = r#"# Which of two solvers is faster
# on two small tori?

repetitions = 2
stop = { gap = 1e-3, max-iterations = 300 }

[[instance]]
mesh = ["torus:20x12", "torus:24x16"]
data = "waves"
noise = 0.3
regions = 4
lambda = 0.01

[[solver]]
name = "chambolle-pock"
options = { rho = [1.9, 1.5] }

[[solver]]
label = "FISTA"
name = "fista"

[[exclude]]
mesh = "torus:24x16"
solver = "fista"

[[figure]]
name = "decay"
title = "A figure"
kind = "decay"

[[figure]]
name = "relation"
kind = "relation"
x = "options.rho"
y = "iterations"
gap = 1e-2
width = "column"

[[table]]
name = "time-to-gap"
kind = "time-to-gap"
gaps = [1e-1, 1e-2, 1e-9]

[[table]]
name = "cells"
kind = "cells"
columns = ["options.rho", "excess", "status"]
"#;

/// Number of its runs.
pub const SMALL_RUNS: usize = 10;

pub fn small() -> Folder {
    let folder = Folder::new();
    folder.write("small.toml", SMALL);
    folder
}

/// Everything in the runs of a results folder that does not depend on time and machine.
pub fn outcomes(results: &Path) -> BTreeMap<String, (String, Vec<Vec<u8>>)> {
    let runs = results.join("runs");
    let run = |id: String| {
        let folder = runs.join(&id);
        let mut summary: Value =
            serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap();
        summary["seconds"] = Value::Null;
        summary["rounding_seconds"] = Value::Null;
        let files = ["spec.toml", "labels.npy"].map(|name| {
            let path = folder.join(name);
            if path.exists() { fs::read(path).unwrap() } else { Vec::new() }
        });
        (id, (summary.to_string(), files.to_vec()))
    };
    names(&runs).into_iter().map(run).collect()
}
