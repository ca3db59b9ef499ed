//! Figures, tables and the page, all drawn from disk, and their sources.

use std::fs;

use super::{SMALL_RUNS, small};
use crate::support::{Folder, names, stderr};

fn reported() -> Folder {
    let folder = small();
    folder.done("experiment run small.toml");
    folder.done("experiment report results/small");
    folder
}

#[test]
fn a_report_has_every_format_of_every_figure_and_table() {
    let folder = reported();
    let results = folder.path("results/small");
    let figures = names(&results.join("figures"));
    for stem in ["decay", "relation"] {
        for extension in ["svg", "png", "pdf", "tex", "dat", "runs.json", "caption.txt"] {
            assert!(figures.contains(&format!("{stem}.{extension}")), "{figures:?}");
        }
    }
    let tables = names(&results.join("tables"));
    for stem in ["time-to-gap", "cells"] {
        for extension in ["csv", "md", "tex", "runs.json"] {
            assert!(tables.contains(&format!("{stem}.{extension}")), "{tables:?}");
        }
    }
    let text = |name: &str| fs::read_to_string(results.join(name)).unwrap();
    let csv = text("tables/time-to-gap.csv");
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 5);
    for row in &rows {
        let iterations = |i: usize| row[i].parse::<f64>();
        assert!(iterations(2).unwrap() <= iterations(3).unwrap(), "{row:?}");
        // A run that stops at 1e-3 does not reach 1e-9, so its cost is unknown.
        assert!(row[4].starts_with("> "), "{row:?}");
    }
    let cells = text("tables/cells.csv");
    assert!(cells.contains("converged") && cells.contains("1.5"), "{cells}");
    assert!(text("tables/cells.tex").contains("\\toprule"));
    let numbers = text("numbers.tex");
    assert!(
        numbers.contains("\\csname meshseg@\\detokenize{small/time-to-gap/torus:20x12"),
        "{numbers}"
    );
}

/// A report can be made without the experiment file and the data folder, and is the same again.
#[test]
fn a_report_needs_nothing_but_the_folder() {
    let folder = reported();
    let figures = folder.path("results/small/figures");
    let read = || -> Vec<Vec<u8>> {
        names(&figures).iter().map(|name| fs::read(figures.join(name)).unwrap()).collect()
    };
    let before = read();
    fs::remove_file(folder.path("small.toml")).unwrap();
    fs::remove_dir_all(&figures).unwrap();
    fs::rename(folder.path("results/small"), folder.path("results/moved")).unwrap();
    folder.done("experiment report results/moved");
    fs::rename(folder.path("results/moved"), folder.path("results/small")).unwrap();
    assert!(read() == before);
}

#[test]
fn every_number_can_be_traced_to_its_runs() {
    let folder = reported();
    for file in ["figures/decay.svg", "figures/relation.pdf", "tables/cells.tex"] {
        let why = folder.done(&format!("experiment why results/small/{file}"));
        assert_eq!(why.lines().count(), 1 + SMALL_RUNS, "{why}");
        for id in names(&folder.path("results/small/runs")) {
            let line = why.lines().find(|line| line.starts_with(&id)).unwrap();
            let (_, command) = line.split_once("meshseg ").unwrap();
            // Repetitions share a specification.
            let done = folder.done(command);
            let made = done.contains("made          1") || done.contains("already done  1");
            assert!(made, "{command}: {done}");
        }
        fs::remove_dir_all(folder.path("results/spec")).unwrap();
    }
    let output = folder.run("experiment why small.toml");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("not a figure or table"), "{}", stderr(&output));
}

/// A run of another host counts for iterations but not for times; a note reports runs on a loaded machine.
#[test]
fn times_of_other_hosts_are_left_out() {
    let folder = small();
    folder.write(
        "small.toml",
        super::SMALL.replace("kind = \"decay\"", "kind = \"decay\"\nx = \"seconds\""),
    );
    folder.done("experiment run small.toml");
    let runs = folder.path("results/small/runs");
    let mut manifests: Vec<(String, std::path::PathBuf)> = names(&runs)
        .iter()
        .map(|id| runs.join(id).join("manifest.json"))
        .map(|path| (fs::read_to_string(&path).unwrap(), path))
        .collect();
    let start = |text: &str| text.split("\"start\": ").nth(1).unwrap()[..30].to_owned();
    manifests.sort_by_key(|(text, _)| start(text));
    let change = |(text, path): &(String, std::path::PathBuf), from: &str, to: &str| {
        let value = text.split(&format!("\"{from}\": ")).nth(1).unwrap();
        let value = value.split([',', '\n']).next().unwrap();
        let text = text.replacen(&format!("\"{from}\": {value}"), &format!("\"{from}\": {to}"), 1);
        fs::write(path, text).unwrap();
    };
    for manifest in &manifests[..4] {
        change(manifest, "loaded", "false");
    }
    // The last repetitions of all solvers but one are from another host.
    for manifest in &manifests[8..] {
        change(manifest, "host", "\"another\"");
    }
    change(&manifests[1], "loaded", "true");
    folder.done("experiment report results/small");
    let caption = folder.path("results/small/figures/decay.caption.txt");
    let caption = fs::read_to_string(caption).unwrap();
    assert!(caption.contains("2 of 10 runs are of another machine and left out"), "{caption}");
    assert!(caption.contains("made while others used the machine"), "{caption}");
    assert!(caption.contains("Medians of 1 to 2 runs."), "{caption}");
    let why = folder.done("experiment why results/small/figures/decay.svg");
    assert_eq!(why.lines().count(), 1 + SMALL_RUNS - 2, "{why}");
    // Iterations do not depend on the host.
    let why = folder.done("experiment why results/small/figures/relation.svg");
    assert_eq!(why.lines().count(), 1 + SMALL_RUNS, "{why}");
}

#[test]
fn the_page_is_one_file_with_its_data() {
    let folder = reported();
    let page = fs::read_to_string(folder.path("results/small/report.html")).unwrap();
    let (_, rest) = page.split_once("id=\"report-data\"").unwrap();
    let (_, rest) = rest.split_once('>').unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let count = |key: &str| data[key].as_array().unwrap().len();
    assert_eq!((count("runs"), count("instances"), count("solvers")), (SMALL_RUNS, 2, 3));
    assert_eq!((count("figures"), count("tables"), count("machines")), (2, 2, 1));
    assert_eq!(data["scenes"].as_object().unwrap().len(), 2);
    for attribute in ["src=\"http", "href=\"http", "url(http", "@import"] {
        assert!(!page.contains(attribute), "{attribute}");
    }
}

#[test]
fn folders_without_results_are_refused() {
    let folder = small();
    fs::create_dir(folder.path("none")).unwrap();
    for (line, part) in [
        ("experiment report none", "experiment.toml"),
        ("experiment report small.toml", "experiment.toml"),
        ("experiment report nowhere", "experiment.toml"),
    ] {
        let output = folder.run(line);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(message.lines().count() == 1 && message.contains(part), "{message}");
    }
}
