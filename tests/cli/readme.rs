//! README.md for a new user: every command runs as printed, in order, and gives the output that is printed below it.
//!
//! Blocks of `sh` are scripts; in blocks of `text`, lines that begin with `$` are commands and the others their output;
//! a row of a table that ends with a command is one, too. Commands that build or install are skipped, since the program
//! is built. Numbers may differ in their last digits, and times are not compared.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{Folder, PROGRAM};

fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The fenced blocks with their languages; between them, the commands in the last column of tables as scripts.
fn blocks() -> Vec<(String, String)> {
    let readme = fs::read_to_string(project().join("README.md")).unwrap();
    let mut found = Vec::new();
    for (i, part) in readme.split("```").enumerate() {
        if i % 2 == 1 {
            let (language, text) = part.split_once('\n').unwrap();
            found.push((language.to_owned(), text.to_owned()));
            continue;
        }
        let rows = part.lines().filter_map(|line| line.strip_prefix('|')?.strip_suffix("` |"));
        for row in rows {
            let (_, command) = row.rsplit_once('`').unwrap();
            if command.starts_with("meshseg ") {
                found.push(("sh".to_owned(), command.to_owned()));
            }
        }
    }
    found
}

/// A clone without build results: it contains the files that commands read, but none that they write.
fn clone() -> Folder {
    let folder = Folder::new();
    for name in ["assets", "experiments", "Cargo.toml", "README.md"] {
        std::os::unix::fs::symlink(project().join(name), folder.path(name)).unwrap();
    }
    folder
}

/// Runs a script with the program and a Python with NumPy on the path; returns its standard output.
fn run(folder: &Folder, script: &str) -> String {
    let python = Command::new(project().join("experiments/reference/run"))
        .args(["python", "-c", "import sys; print(sys.prefix)"])
        .output()
        .unwrap();
    let prefix = String::from_utf8(python.stdout).unwrap();
    let mut path = vec![Path::new(PROGRAM).parent().unwrap().to_owned()];
    path.push(PathBuf::from(prefix.trim()).join("bin"));
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    let output = Command::new("bash")
        .args(["-euo", "pipefail", "-c", script])
        .current_dir(folder.path(""))
        .env("PATH", std::env::join_paths(path).unwrap())
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script}\n{stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Whether two words are equal, as texts or as numbers.
fn same(printed: &str, actual: &str) -> bool {
    let number = |word: &str| word.trim_matches(|c| c == ',' || c == '%').parse::<f64>();
    match (number(printed), number(actual)) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-2 * b.abs() + 1e-12,
        _ => printed == actual,
    }
}

fn assert_printed(command: &str, output: &str, printed: &str) {
    let mut actual = output.lines();
    for line in printed.lines() {
        if line == "..." {
            return;
        }
        let other = actual.next().unwrap_or_else(|| panic!("{command}: nothing for {line:?}"));
        if line.starts_with("time ") {
            continue;
        }
        let words = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
        let (a, b) = (words(line), words(other));
        let equal = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same(a, b));
        assert!(equal, "{command}\nREADME: {line}\nprogram: {other}");
    }
    assert_eq!(actual.next(), None, "{command}: more than README prints");
}

#[test]
fn every_command_runs_as_printed() {
    let commands = run_blocks(|text| !text.contains(EXPERIMENT));
    assert!(commands > 60, "{commands}");
}

/// These take longest, and need nothing of the others.
#[test]
fn every_experiment_runs_as_printed() {
    let commands = run_blocks(|text| text.contains(EXPERIMENT));
    assert!(commands >= 2, "{commands}");
}

const EXPERIMENT: &str = "meshseg experiment ";

/// Runs the chosen blocks in a clone of their own; the number of commands.
fn run_blocks(is_chosen: impl Fn(&str) -> bool) -> usize {
    let folder = clone();
    let mut commands = 0;
    for (language, text) in blocks().into_iter().filter(|(_, text)| is_chosen(text)) {
        match language.as_str() {
            "sh" => {
                let builds = |line: &str| {
                    ["cargo ", "make ", "pip "].iter().any(|start| line.starts_with(start))
                };
                let built = |line: &&str| !builds(line);
                let script: Vec<&str> = text.lines().filter(built).collect();
                run(&folder, &script.join("\n"));
                commands += script.len();
            }
            "text" => {
                for part in text.split("$ ").filter(|part| !part.trim().is_empty()) {
                    let (command, printed) = part.split_once('\n').unwrap();
                    let output = run(&folder, command);
                    assert_printed(command, &output, printed.trim_end());
                    commands += 1;
                }
            }
            _ => {}
        }
    }
    commands
}
