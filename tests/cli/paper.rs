//! `meshseg paper check`: papers whose results are those of their runs, and every way in which they may not be.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

use crate::experiment::SMALL;
use crate::support::{Folder, PROGRAM, names, stderr};

const MAIN: &str = r"\documentclass{article}
\usepackage{results}
\resultsof{small}
\begin{document}
\input{text}
\end{document}
";

const TEXT: &str = r"FISTA took \result{small/time-to-gap/torus:20x12, waves, 4 regions, lambda 0.01/FISTA/iterations
to 1e-2} iterations, with version \result{small/made/version}~\cite{known}. % 12 s in a comment
\resultfigure[width=3in] {small}{decay}\resulttable{small}{time-to-gap}\resultcaption{small}{decay}
It took \fact{200 s}{known} before, in section 2, with 4 regions.
";

const BIBLIOGRAPHY: &str = "@article{known,\n  title = {A title},\n}\n";

/// A folder with an experiment, its results and a paper about them.
fn written() -> Folder {
    let folder = Folder::new();
    for name in ["experiments", "paper"] {
        fs::create_dir(folder.path(name)).unwrap();
    }
    folder.write("experiments/small.toml", SMALL);
    folder.done("experiment run experiments/small.toml");
    for id in names(&folder.path("results/small/runs")) {
        change(&manifest(&folder, &id), "\"dirty\": true", "\"dirty\": false");
    }
    folder.done("experiment report results/small");
    folder.write("paper/main.tex", MAIN);
    folder.write("paper/text.tex", TEXT);
    folder.write("paper/references.bib", BIBLIOGRAPHY);
    folder
}

fn manifest(folder: &Folder, id: &str) -> PathBuf {
    folder.path(&format!("results/small/runs/{id}/manifest.json"))
}

fn change(path: &Path, from: &str, to: &str) {
    let mut bytes = fs::read(path).unwrap();
    let found = bytes.windows(from.len()).position(|window| window == from.as_bytes());
    if let Some(at) = found {
        bytes.splice(at..at + from.len(), to.bytes());
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_paper_with_current_results_passes() {
    let folder = written();
    let checked = folder.done("paper check");
    assert_eq!(checked, "3 names, 1 figure and 1 table of 1 experiment, as their runs give them\n");
}

#[test]
fn every_fault_is_named_with_its_remedy() {
    let folder = written();
    let first = names(&folder.path("results/small/runs")).into_iter().next().unwrap();
    let run = format!("results/small/runs/{first}");
    for (file, from, to, sentence) in [
        ("results/small/numbers.tex", "}\\endcsname{1", "}\\endcsname{7", "numbers.tex, line "),
        ("results/small/tables/time-to-gap.tex", " & ", " & 1", "is not what the runs give"),
        (
            "results/small/figures/decay.svg",
            "<path",
            "<!-- --><path",
            "report results/small` renews it",
        ),
        (
            &format!("{run}/summary.json"),
            "\"energy\": 0",
            "\"energy\": 1",
            "is not what the runs give",
        ),
        (
            "experiments/small.toml",
            "lambda = 0.01",
            "lambda = 0.02",
            "has changed since results/small",
        ),
        (&format!("{run}/manifest.json"), "\"dirty\": false", "\"dirty\": true", "in no commit"),
        (&format!("{run}/manifest.json"), "\"host\": \"", "\"host\": \"0", "from 2 machines"),
        (&format!("{run}/manifest.json"), "\"version\": \"", "\"version\": \"9", "of the versions"),
        (
            "paper/text.tex",
            "in section 2",
            "in 12\\,s",
            "text.tex, line 4: \"12 s\" is typed by hand",
        ),
        ("paper/text.tex", "4 regions.", "4\\,\\% more.", "\"4 %\" is typed by hand"),
        ("paper/text.tex", "to 1e-2", "to 1e-9", "there is no result \"small/time-to-gap/torus"),
        (
            "paper/text.tex",
            "small}{decay}",
            "small}{rise}",
            "there is no results/small/figures/rise.pdf",
        ),
        ("paper/text.tex", "table{small}", "table{large}", "needs \\resultsof{large}"),
        (
            "paper/text.tex",
            "caption{small}{decay}",
            "caption{small}{rise}",
            "no result \"small/rise/caption\"",
        ),
        (
            "paper/text.tex",
            "\\fact{",
            "\\newcommand{\\r}[1]{\\result{#1}}\\fact{",
            "cannot be checked",
        ),
        (
            "paper/text.tex",
            "\\fact{",
            "\\input {gone}\\fact{",
            "text.tex, line 4: paper/gone cannot be read",
        ),
        ("paper/text.tex", "\\fact{200 s}{known}", "\\fact{200 s}", "\\fact needs two arguments"),
        ("results/small/figures/decay.pdf", "%PDF", "%PDG", "decay.pdf: is not what the runs give"),
        ("paper/text.tex", "cite{known}", "cite{unknown}", "has no entry \"unknown\""),
        ("paper/text.tex", "s}{known}", "s}{nobody}", "has no entry \"nobody\""),
        ("paper/text.tex", "made/version}", "made/cores}", "does not name the version"),
        (
            "paper/main.tex",
            "of{small}",
            "of{small}\\resultsof{none}",
            "there are no results of \"none\"",
        ),
    ] {
        let path = folder.path(file);
        let before = fs::read(&path).unwrap();
        change(&path, from, to);
        assert_ne!(fs::read(&path).unwrap(), before, "{file}: {from}");
        let output = folder.run("paper check paper");
        let messages = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{file}: {to}: {messages}");
        assert!(messages.contains(sentence), "{sentence}: {messages}");
        assert!(messages.lines().last().unwrap().starts_with("error: paper: "), "{messages}");
        fs::write(path, before).unwrap();
    }
    for (name, sentence) in [
        (
            "results/small/tables/extra.tex",
            "extra.tex is not of a figure or table in results/small/experiment.toml",
        ),
        ("results/small/tables/cells.csv", "tables/cells.csv is missing"),
    ] {
        let path = folder.path(name);
        let before = fs::read(&path).ok();
        match &before {
            Some(_) => fs::remove_file(&path).unwrap(),
            None => fs::write(&path, "faster by 99").unwrap(),
        }
        let messages = stderr(&folder.run("paper check"));
        assert!(messages.contains(sentence), "{messages}");
        match before {
            Some(before) => fs::write(&path, before).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
    }
    fs::remove_dir_all(folder.path(&run)).unwrap();
    let messages = stderr(&folder.run("paper check"));
    assert!(messages.contains("runs are missing"), "{messages}");
    fs::remove_file(folder.path("paper/text.tex")).unwrap();
    let messages = stderr(&folder.run("paper check"));
    assert!(messages.contains("main.tex, line 5: paper/text cannot be read"), "{messages}");
}

/// The paper of this project.
#[test]
fn the_paper_of_the_project_is_current() {
    let output = Command::new(PROGRAM)
        .args(["paper", "check", "paper"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}
