//! Experiments of reconstructions: surfaces that evolve, from photographs.

use std::fs;

use serde_json::Value;

use super::outcomes;
use crate::support::{Folder, names, stderr};

/// A peanut of two colors from a sphere, with and without one part of the method; photographs of a moment.
const SURFACES: &str = r#"# Does a surface evolve?

[[instance]]
label = "peanut"
mesh = "peanut:3"
normalize = "none"
data = "photographs:8:60x45"
background = "0.9,0.9,0.9"
regions = 2
lambda = 0.0005

[[solver]]
label = "full"
name = "reconstruct"
options = { start = "sphere:0,0,0,1.1", levels = 2, steps = 12 }

[[solver]]
label = "contour"
name = "reconstruct"
options = { start = "sphere:2", levels = 1, steps = 3, gradient = "contour" }

[[figure]]
name = "distance"
kind = "decay"
x = "steps"
y = "distance"

[[figure]]
name = "way"
kind = "evolution"
steps = [0, 5]
views = ["front"]

[[figure]]
name = "seen"
kind = "photographs"
solvers = "full"

[[table]]
name = "surfaces"
kind = "cells"
columns = ["steps", "distance", "distance-95", "largest-distance", "silhouette-iou", "mislabeled", "folds", "lambda", "gap", "bound", "status"]
"#;

fn made() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SURFACES);
    let printed = folder.done("experiment run s.toml");
    assert!(printed.contains("made          2"), "{printed}");
    folder
}

/// Every number of a run is in its files, and describes the surface after a number of steps.
#[test]
fn a_surface_is_reconstructed_and_its_way_is_kept() {
    let folder = made();
    let runs = folder.path("results/s/runs");
    let mut found = 0;
    for id in names(&runs) {
        let read = |name: &str| fs::read(runs.join(&id).join(name)).unwrap();
        let json = |name: &str| -> Value { serde_json::from_slice(&read(name)).unwrap() };
        let (manifest, summary) = (json("manifest.json"), json("summary.json"));
        let trace = read("trace.csv");
        let mut csv = csv::Reader::from_reader(&trace[..]);
        let header = csv.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
        let column = |name: &str| header.iter().position(|column| column == name).unwrap();
        let numbers = |name: &str| -> Vec<Option<f64>> {
            rows.iter().map(|row| row[column(name)].parse().ok()).collect()
        };
        let steps = summary["steps"].as_u64().unwrap() as usize;
        let counted: Vec<f64> = numbers("step").into_iter().flatten().collect();
        assert_eq!(counted, (0..=steps).map(|step| step as f64).collect::<Vec<_>>());
        assert!(!header.iter().any(|name| ["dual_bound", "relative_gap"].contains(&name)));
        // The surface before the first step, and the last one, are compared with the truth.
        let distances = numbers("distance");
        assert_eq!(distances[steps], summary["distances"]["mean"].as_f64());
        assert!(distances[0].unwrap() > 0.03 && distances[1].is_some() && distances[2].is_none());
        assert_eq!(numbers("silhouette_iou")[steps], summary["silhouette_iou"].as_f64());
        assert_eq!(numbers("mislabeled")[steps], manifest["mislabeled"].as_f64());
        assert_eq!(numbers("energy")[steps], summary["energy"].as_f64());
        let seconds: Vec<f64> = numbers("seconds").into_iter().flatten().collect();
        assert!(seconds[0] == 0.0 && seconds.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(summary["labels"]["relative_gap"].as_f64().unwrap() <= 1e-4);
        let frames = names(&runs.join(&id).join("frames"));
        if manifest["solver"] == "full" {
            found += 1;
            assert!(distances[steps].unwrap() < 0.01, "{distances:?}");
            assert!(manifest["mislabeled"].as_f64().unwrap() < 0.1, "{manifest}");
            assert!(["0.ply", "5.ply", "10.ply"].iter().all(|name| frames.contains(*name)));
        }
        assert!(frames.contains(&format!("{steps}.ply")), "{frames:?}");
        folder.done(&format!("mesh info results/s/runs/{id}/frames/{steps}.ply"));
    }
    assert_eq!(found, 1);
}

/// The report has its figures and tables; what a surface does not have is left empty.
#[test]
fn reports_have_no_bounds_of_surfaces() {
    let folder = made();
    folder.done("experiment report results/s");
    let text = |name: &str| fs::read_to_string(folder.path("results/s").join(name)).unwrap();
    let table = text("tables/surfaces.csv");
    let mut csv = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let number = |i: usize| row[2 + i].parse::<f64>().unwrap();
        assert!(number(0) >= 3.0 && number(1) > 0.0 && number(1) < number(2), "{row:?}");
        assert!(number(2) <= number(3) && number(4) <= 1.0 && number(5) < 0.5, "{row:?}");
        assert_eq!(number(7), 0.0005);
        assert_eq!((&row[2 + 8], &row[2 + 9]), ("", ""), "{row:?}");
        assert!(["settled", "step-limit"].contains(&&row[2 + 10]), "{row:?}");
    }
    assert!(text("figures/distance.svg").contains("distance to the truth"));
    let page = text("report.html");
    assert!(page.contains("\"relative_gap\":null") && page.contains("\"silhouette_iou\":["));
    let film = text("figures/way.html");
    assert!(film.contains("\"film\":true") && film.contains("\"5 steps\",\"10 steps\""));
    let way = image::open(folder.path("results/s/figures/way.png")).unwrap().into_rgb8();
    assert!(way.pixels().any(|pixel| pixel.0 != [255; 3]));
    // Two by two photographs of 60 x 45 pixels.
    let seen = image::open(folder.path("results/s/figures/seen.png")).unwrap();
    assert_eq!((seen.width(), seen.height()), (126, 96));
    // A report that nobody asked for anything special.
    folder.write("plain.toml", &SURFACES[..SURFACES.find("[[figure]]").unwrap()]);
    folder.done("experiment run plain.toml");
    folder.done("experiment report results/plain");
    assert!(folder.path("results/plain/figures/decay-steps.svg").is_file());
    assert!(folder.path("results/plain/tables/surfaces.md").is_file());
    // Without the surfaces, which are large, the figure stays as it is.
    for id in names(&folder.path("results/s/runs")) {
        fs::remove_dir_all(folder.path(&format!("results/s/runs/{id}/frames"))).unwrap();
    }
    let output = folder.run("experiment report results/s");
    assert!(stderr(&output).contains("way.png is unchanged"), "{}", stderr(&output));
}

#[test]
fn a_reconstruction_is_repeated_from_its_own_file() {
    let folder = made();
    let runs = folder.path("results/s/runs");
    let second = folder.done("experiment run s.toml");
    assert!(second.contains("already done  2"), "{second}");
    let id = names(&runs).into_iter().next().unwrap();
    folder.write("alone.toml", fs::read(runs.join(&id).join("spec.toml")).unwrap());
    folder.done("experiment run alone.toml");
    let numbers = |results: &str, id: &str| {
        let (summary, _) = &outcomes(&folder.path(results))[id];
        let mut summary: Value = serde_json::from_str(summary).unwrap();
        summary["labels"]["seconds"] = Value::Null;
        summary["labels"]["rounding_seconds"] = Value::Null;
        summary
    };
    assert_eq!(numbers("results/alone", &id), numbers("results/s", &id));
    // The ID depends on the mesh that the surface starts from.
    folder.done("mesh convert sphere:2 --out start.ply");
    let file = SURFACES.replace("sphere:2", "start.ply");
    folder.write("s.toml", &file);
    assert!(folder.done("experiment list s.toml").contains("2, 1 missing"));
    folder.done("experiment run s.toml");
    assert!(folder.done("experiment list s.toml").contains("2, 0 missing"));
    folder.done("mesh convert sphere:1 --out start.ply");
    assert!(folder.done("experiment list s.toml").contains("2, 1 missing"));
}

#[test]
fn impossible_reconstructions_are_refused_at_their_positions() {
    let refuse = |from: &str, to: &str, parts: &[&str]| {
        assert!(SURFACES.contains(from), "{from}");
        let folder = Folder::new();
        folder.write("e.toml", SURFACES.replacen(from, to, 1));
        let output = folder.run("experiment run e.toml");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{to}: {message}");
        assert!(message.starts_with("error: e.toml, line "), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{to}: {message}");
    };
    let photographs = "data = \"photographs:8:60x45\"\nbackground = \"0.9,0.9,0.9\"";
    let data = "line 7, column 8";
    refuse("steps = 12", "steps = 0", &["line 15", "from 1 to 65535"]);
    refuse("levels = 2", "levels = 9", &["line 15", "from 1 to 8"]);
    refuse("levels = 2", "metric = -1.0", &["line 15", "0 or more"]);
    refuse("levels = 2", "split = 0.5", &["line 15", "1 or more"]);
    refuse("levels = 2", "split = true", &["line 15", "number"]);
    refuse("levels = 2", "rho = 1.5", &["line 15", "no option \"rho\"", "gradient"]);
    refuse("levels = 2", "gradient = \"contours\"", &["line 15", "did you mean \"contour\""]);
    refuse("levels = 2", "background = \"masks\"", &["line 15", "\"none\""]);
    refuse("sphere:0,0,0,1.1", "sphere:0,0,0,-1", &["line 15, column 21", "radius R above 0"]);
    refuse("label = \"full\"", "every = 3", &["line 13, column 9", "does not apply"]);
    refuse("name = \"reconstruct\"", "name = \"reconstuct\"", &["did you mean \"reconstruct\""]);
    refuse(photographs, "data = \"waves\"", &[data, "photographs:N:WxH"]);
    refuse(photographs, "data = \"photographs:8:60x45\"\npure = 2", &[data, "pure does not apply"]);
    refuse("0.9,0.9,0.9", "masks", &["line 8, column 14", "in front of a color"]);
    refuse("0.9,0.9,0.9", "0.9,0.9", &["line 8, column 14", "three numbers"]);
    refuse("lambda = 0.0005", "lambda = \"auto\"", &[data, "a number as lambda"]);
    refuse("regions = 2", "regions = 2\nmodel = \"albedo\"", &[data, "with a light"]);
    refuse("regions = 2", "regions = 2\nmodel = \"l1\"", &[data, "\"constant\" or \"albedo\""]);
    refuse("regions = 2", "regions = 2\npattern = \"dots\"", &["line 10", "checkerboard"]);
    refuse("mesh = \"peanut:3\"\n", "", &["line 3, column 1", "needs mesh"]);
    refuse("name = \"reconstruct\"", "name = \"fista\"", &["start"]);
    let solver = "name = \"fista\"\n#";
    let single = SURFACES.replacen("regions = 2", "regions = 1", 1);
    let folder = Folder::new();
    folder.write("e.toml", single.replace("name = \"reconstruct\"\noptions", solver));
    let message = stderr(&folder.run("experiment run e.toml"));
    assert!(message.contains("no end"), "{message}");
    let stopped = format!("stop = {{ gap = 1e-3 }}\n{single}");
    folder.write("e.toml", stopped.replace("name = \"reconstruct\"\noptions", solver));
    let message = stderr(&folder.run("experiment run e.toml"));
    assert!(message.contains("one region is for reconstructions alone"), "{message}");
}
