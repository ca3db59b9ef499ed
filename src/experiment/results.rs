//! Runs as they lie on disk.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::machine::{Machine, Program};
use super::manifest::Manifest;
use super::store::{Store, lacking};
use crate::error::{Error, Result};
use crate::file;
use crate::npy;
use crate::solve::Summary;

/// One finished run.
pub struct Done {
    /// The folder of the run.
    pub folder: PathBuf,
    /// `spec.toml`: an experiment file of this run alone.
    pub spec: toml::Table,
    /// `manifest.json`.
    pub manifest: Manifest,
    /// `summary.json`.
    pub summary: Summary,
    /// `trace.csv`, in the order of the iterations.
    pub trace: Vec<Point>,
    /// The label of each vertex, V bytes, where they were kept: for the first repetition on small meshes.
    pub labels: Option<Vec<u8>>,
    /// 255 max_p u_kp of each vertex, V bytes, where they were kept.
    pub certainty: Option<Vec<u8>>,
}

/// A row of `trace.csv`.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Point {
    pub iteration: u64,
    pub seconds: f64,
    pub energy: f64,
    pub dual_bound: f64,
    pub relative_gap: f64,
    #[serde(default)]
    pub smoothed_energy: Option<f64>,
}

impl Done {
    /// The run in a folder. Fails if a file of it is missing or damaged.
    pub fn read(folder: &Path) -> Result<Self> {
        if let Some(name) = lacking(folder) {
            let message = format!("lacks {name}; `meshseg experiment run` makes the run again");
            return Err(Error::malformed(folder, message));
        }
        Done::read_files(folder).map_err(damaged)
    }

    fn read_files(folder: &Path) -> Result<Self> {
        let path = folder.join("spec.toml");
        let text = String::from_utf8(file::read(&path)?)
            .map_err(|error| Error::malformed(&path, error.to_string()))?;
        let spec = text
            .parse()
            .map_err(|error: toml::de::Error| Error::malformed(&path, error.message()))?;
        let path = folder.join("trace.csv");
        let bytes = file::read(&path)?;
        let trace = csv::Reader::from_reader(&bytes[..])
            .deserialize()
            .collect::<std::result::Result<Vec<Point>, _>>()
            .map_err(|error| Error::malformed(&path, error.to_string()))?;
        Ok(Done {
            spec,
            trace,
            manifest: json(&folder.join("manifest.json"))?,
            summary: json(&folder.join("summary.json"))?,
            labels: kept(&folder.join("labels.npy"))?,
            certainty: kept(&folder.join("certainty.npy"))?,
            folder: folder.to_owned(),
        })
    }

    /// All runs of a store, by the time they were made.
    ///
    /// # Errors
    /// A folder or a run that cannot be read.
    pub fn all(store: &Store) -> Result<Vec<Self>> {
        Done::these(store, store.ids()?)
    }

    /// The same without those that lack a file, which are made again.
    ///
    /// # Errors
    /// A folder or a run that cannot be read.
    pub fn whole(store: &Store) -> Result<Vec<Self>> {
        let ids = store.ids()?;
        Done::these(store, ids.into_iter().filter(|id| store.has(id)))
    }

    fn these(store: &Store, ids: impl IntoIterator<Item = String>) -> Result<Vec<Self>> {
        let read = |id: String| Done::read(&store.run(&id));
        let mut all = ids.into_iter().map(read).collect::<Result<Vec<_>>>()?;
        let key = |done: &Done| (done.manifest.start.clone(), done.manifest.id.clone());
        all.sort_by_key(key);
        Ok(all)
    }

    /// A value of the cell: `lambda`, `options.epsilon`, `solver`.
    pub fn key(&self, key: &str) -> Option<&toml::Value> {
        let first = |name: &str| self.spec.get(name)?.as_array()?.first()?.as_table();
        match key.strip_prefix("options.") {
            Some(option) => first("solver")?.get("options")?.as_table()?.get(option),
            None if key == "solver" => first("solver")?.get("name"),
            None => first("instance")?.get(key).or_else(|| first("solver")?.get(key)),
        }
    }
}

/// Where and by what a run was made.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Origin {
    /// [`Machine::host`].
    pub host: String,
    /// [`Machine::cpu`].
    pub cpu: String,
    /// [`Program::version`].
    pub version: String,
    /// [`Program::commit`].
    pub commit: String,
    /// [`Program::dirty`].
    pub dirty: bool,
}

impl Origin {
    /// Of the run in a folder.
    ///
    /// # Errors
    /// A manifest that is missing or damaged.
    pub fn of(folder: &Path) -> Result<Self> {
        let Manifest { program, machine, .. } =
            json(&folder.join("manifest.json")).map_err(damaged)?;
        Ok(Origin::new(&program, &machine))
    }

    fn new(program: &Program, machine: &Machine) -> Self {
        Origin {
            host: machine.host.clone(),
            cpu: machine.cpu.clone(),
            version: program.version.clone(),
            commit: program.commit.clone(),
            dirty: program.dirty,
        }
    }

    /// Whether this machine and this program would make the same run.
    pub fn is_here(&self, program: &Program, machine: &Machine) -> bool {
        *self == Origin::new(program, machine)
    }

    /// In words.
    pub fn sentence(&self, machine: &Machine) -> String {
        // Hosts of one name, such as "localhost", may be different ones.
        let place = if self.host == machine.host && self.cpu == machine.cpu {
            "on this machine".to_owned()
        } else {
            format!("on another machine ({}, {})", self.host, self.cpu)
        };
        let commit = self.commit.get(..12).unwrap_or(&self.commit);
        let changes = if self.dirty { " and changes" } else { "" };
        format!("{place} by version {} at commit {commit}{changes}", self.version)
    }
}

/// A file of a run that is not what it was, and the way out.
fn damaged(error: Error) -> Error {
    match error {
        Error::Malformed { path, message } => Error::malformed(
            &path,
            format!(
                "{message}; remove the folder of the run, and `meshseg experiment run` makes it again"
            ),
        ),
        other => other,
    }
}

fn json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    serde_json::from_slice(&file::read(path)?)
        .map_err(|error| Error::malformed(path, error.to_string()))
}

fn kept(path: &Path) -> Result<Option<Vec<u8>>> {
    if path.exists() { npy::read_bytes(path).map(Some) } else { Ok(None) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All of the results that came with the program, those of earlier versions of it included.
    #[test]
    fn summaries_are_read_as_they_were_written() {
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
        let folders = |path: PathBuf| {
            let entries = std::fs::read_dir(path).into_iter().flatten();
            entries.map(|entry| entry.unwrap().path())
        };
        let mut count = 0;
        for run in folders(results).flat_map(|results| folders(results.join("runs"))) {
            let path = run.join("summary.json");
            let summary: Summary = json(&path).unwrap();
            let again = serde_json::to_string_pretty(&summary).unwrap() + "\n";
            assert_eq!(again, std::fs::read_to_string(&path).unwrap(), "{}", path.display());
            count += 1;
        }
        assert!(count > 0);
    }
}
