//! Temporary folders, runs of the program in them, and access to its results.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use assert_cmd::Command;
use ndarray::{Array1, Array2};
use ndarray_npy::{read_npy, write_npy};
use serde_json::Value;

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_meshseg");

/// A run that takes longer hangs.
pub const HANGS: Duration = Duration::from_secs(120);

/// A temporary folder in which the program runs, so that command lines need no long paths.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub fn array(&self, name: &str, array: &Array2<f64>) {
        write_npy(self.path(name), array).unwrap();
    }

    /// Runs a command line. A space within a word is written as `%20`.
    pub fn run(&self, line: &str) -> Output {
        let words = line.split_whitespace().map(|word| word.replace("%20", " "));
        Command::new(PROGRAM)
            .args(words)
            .current_dir(self.0.path())
            .timeout(HANGS)
            .output()
            .unwrap()
    }

    /// Runs a command line that must succeed; its standard output.
    pub fn done(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(0), "{line}\n{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs `solve`, which must succeed; its results.
    pub fn solve(&self, arguments: &str, out: &str) -> Answer {
        self.done(&format!("solve {arguments} --out {out}"));
        self.answer(out)
    }

    pub fn answer(&self, out: &str) -> Answer {
        Answer::read(&self.path(out))
    }

    /// All files and folders below, including hidden ones, with the sizes of the files.
    pub fn listing(&self) -> BTreeSet<(PathBuf, u64)> {
        fn list(folder: &Path, found: &mut BTreeSet<(PathBuf, u64)>) {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let metadata = entry.metadata().unwrap();
                found.insert((entry.path(), if metadata.is_file() { metadata.len() } else { 0 }));
                if metadata.is_dir() {
                    list(&entry.path(), found);
                }
            }
        }
        let mut found = BTreeSet::new();
        list(self.0.path(), &mut found);
        found
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The names in a folder, including hidden ones.
pub fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// The results of a run, except for the mesh and the picture.
pub struct Answer {
    pub summary: Value,
    pub header: Vec<String>,
    pub trace: Vec<Vec<Option<f64>>>,
    pub u: Array2<f64>,
    pub labels: Array1<i32>,
}

impl Answer {
    pub fn read(folder: &Path) -> Self {
        let mut csv = csv::Reader::from_path(folder.join("trace.csv")).unwrap();
        let header = csv.headers().unwrap().iter().map(String::from).collect();
        let number = |cell: &str| (!cell.is_empty()).then(|| cell.parse().unwrap());
        let trace = csv.records().map(|row| row.unwrap().iter().map(number).collect()).collect();
        Answer {
            summary: serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap())
                .unwrap(),
            header,
            trace,
            u: read_npy(folder.join("u.npy")).unwrap(),
            labels: read_npy(folder.join("labels.npy")).unwrap(),
        }
    }

    pub fn number(&self, key: &str) -> f64 {
        self.summary[key].as_f64().unwrap_or_else(|| panic!("{key}: {}", self.summary))
    }

    pub fn status(&self) -> &str {
        self.summary["status"].as_str().unwrap()
    }

    /// The cells of a column of the trace.
    pub fn column(&self, name: &str) -> Vec<Option<f64>> {
        let at = self.header.iter().position(|column| column == name).unwrap();
        self.trace.iter().map(|row| row[at]).collect()
    }

    /// Checks properties of every result.
    pub fn assert_consistent(&self) {
        for row in self.u.outer_iter() {
            assert!((row.sum() - 1.0).abs() <= 1e-12 && row.iter().all(|&x| x >= 0.0), "{row}");
        }
        assert_eq!(self.labels.len(), self.u.nrows());
        if self.summary["rounding"] == "argmax" {
            for (row, &label) in self.u.outer_iter().zip(&self.labels) {
                assert!(row.iter().all(|&x| x <= row[label as usize]), "{row}, label {label}");
            }
        }
        assert!(self.number("rounded_energy") <= self.number("argmax_energy"));
        assert!(self.number("dual_bound") <= self.number("energy"));
        let gap = self.number("energy") - self.number("dual_bound");
        assert!((self.number("gap") - gap).abs() <= 1e-12 * self.number("energy").abs());
        let last = |name| self.column(name).last().unwrap().unwrap();
        assert_eq!(last("iteration"), self.number("iterations"));
        for key in ["energy", "dual_bound", "gap", "relative_gap", "seconds"] {
            assert_eq!(last(key), self.number(key), "{key}");
        }
    }

    /// Checks that energy and bound only improve from row `first` on.
    pub fn assert_monotone_from(&self, first: usize) {
        let energy = self.column("energy");
        let bound = self.column("dual_bound");
        assert!(energy[first..].windows(2).all(|pair| pair[1] <= pair[0]));
        assert!(bound[first..].windows(2).all(|pair| pair[1] >= pair[0]));
    }
}

/// Costs of m regions, smooth with a little noise, and equal on every machine.
pub fn costs(vertices: usize, m: usize) -> Array2<f64> {
    Array2::from_shape_fn((vertices, m), |(k, p)| {
        let wave = (k as f64 / vertices as f64 * 6.0 - 2.0 * p as f64).cos();
        let rough = ((k * 7919 + p * 104_729) % 1000) as f64 / 1000.0;
        1.0 + wave + rough
    })
}

/// A square of two triangles.
pub const SQUARE_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
