//! Finished runs, read from disk.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::machine::{Machine, Program};
use super::manifest::Manifest;
use super::numbers::Numbers;
use super::store::{FRAMES, Store, lacking};
use crate::domain::Element;
use crate::error::{Error, Result};
use crate::file;
use crate::names::Named;
use crate::npy;

/// One finished run.
pub struct Done {
    /// The folder of the run.
    pub folder: PathBuf,
    /// `spec.toml`: an experiment file for this run alone.
    pub spec: toml::Table,
    /// `manifest.json`.
    pub manifest: Manifest,
    /// `summary.json`.
    pub summary: Numbers,
    /// `trace.csv`, in the order of the iterations or steps.
    pub trace: Vec<Point>,
    /// The label of each vertex, V bytes; kept for the first repetition on small meshes.
    pub labels: Option<Vec<u8>>,
    /// 255 max_p u_kp of each vertex, V bytes; kept with the labels.
    pub certainty: Option<Vec<u8>>,
    /// The surface on the way of a reconstruction, as the number of steps and the file; by these numbers.
    pub frames: Vec<(usize, PathBuf)>,
}

/// A row of `trace.csv`, of labels or of a surface.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Point {
    /// Or the number of steps.
    #[serde(alias = "step")]
    pub iteration: u64,
    pub seconds: f64,
    pub energy: f64,
    /// Of labels alone.
    #[serde(default)]
    pub relative_gap: Option<f64>,
    #[serde(default)]
    pub smoothed_energy: Option<f64>,
    /// Of a surface, as the next two: its mean distance to the truth, in shares of the diagonal.
    #[serde(default)]
    pub distance: Option<f64>,
    #[serde(default)]
    pub mislabeled: Option<f64>,
    #[serde(default)]
    pub silhouette_iou: Option<f64>,
}

impl Done {
    /// Reads the run in a folder. Fails if one of its files is missing or damaged.
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
        let spec: toml::Table = text
            .parse()
            .map_err(|error: toml::de::Error| Error::malformed(&path, error.message()))?;
        let path = folder.join("trace.csv");
        let bytes = file::read(&path)?;
        let trace = csv::Reader::from_reader(&bytes[..])
            .deserialize()
            .collect::<std::result::Result<Vec<Point>, _>>()
            .map_err(|error| Error::malformed(&path, error.to_string()))?;
        let path = folder.join("summary.json");
        let solver = key_of(&spec, "solver").and_then(toml::Value::as_str).unwrap_or_default();
        let summary = Numbers::parse(&file::read(&path)?, solver)
            .map_err(|error| Error::malformed(&path, error.to_string()))?;
        Ok(Done {
            spec,
            trace,
            manifest: json(&folder.join("manifest.json"))?,
            summary,
            labels: kept(&folder.join("labels.npy"))?,
            certainty: kept(&folder.join("certainty.npy"))?,
            frames: frames(&folder.join(FRAMES))?,
            folder: folder.to_owned(),
        })
    }

    /// What its labels are those of.
    pub fn on(&self) -> Element {
        match self.summary.labels().and_then(|summary| summary.on.as_deref()) {
            Some(on) if on == Element::Faces.name() => Element::Faces,
            _ => Element::Vertices,
        }
    }

    /// All runs of a store, sorted by the time they were made.
    ///
    /// # Errors
    /// A folder or a run cannot be read.
    pub fn all(store: &Store) -> Result<Vec<Self>> {
        Done::these(store, store.ids()?)
    }

    /// All runs except those that lack a file, which will be made again.
    ///
    /// # Errors
    /// A folder or a run cannot be read.
    pub fn complete(store: &Store) -> Result<Vec<Self>> {
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

    /// The value of a key of the cell, such as `lambda`, `options.epsilon` or `solver`.
    pub fn key(&self, key: &str) -> Option<&toml::Value> {
        key_of(&self.spec, key)
    }
}

/// The value of a key in the specification of a run.
fn key_of<'a>(spec: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    let first = |name: &str| spec.get(name)?.as_array()?.first()?.as_table();
    match key.strip_prefix("options.") {
        Some(option) => first("solver")?.get("options")?.as_table()?.get(option),
        None if key == "solver" => first("solver")?.get("name"),
        None => first("instance")?.get(key).or_else(|| first("solver")?.get(key)),
    }
}

/// The machine and the program that made a run, as far as they are compared.
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
    /// The origin of the run in a folder.
    ///
    /// # Errors
    /// The manifest is missing or damaged.
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

    /// Whether the origin is this program on this machine.
    pub fn is_here(&self, program: &Program, machine: &Machine) -> bool {
        *self == Origin::new(program, machine)
    }

    /// The origin in words.
    pub fn sentence(&self, machine: &Machine) -> String {
        // Different hosts may share a name, such as "localhost".
        let place = if self.host == machine.host && self.cpu == machine.cpu {
            "on this machine".to_owned()
        } else {
            format!("on another machine ({}, {})", self.host, self.cpu)
        };
        let commit = self.commit.get(..12).unwrap_or(&self.commit);
        let changes = if self.dirty { " with uncommitted changes" } else { "" };
        format!("{place} by version {} at commit {commit}{changes}", self.version)
    }
}

/// Adds a remedy to the error about a damaged file.
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

/// The files STEP.ply of a folder, which may not exist.
fn frames(folder: &Path) -> Result<Vec<(usize, PathBuf)>> {
    let mut frames = Vec::new();
    if folder.is_dir() {
        let io = |error| Error::io(folder, error);
        for entry in std::fs::read_dir(folder).map_err(io)? {
            let path = entry.map_err(io)?.path();
            let step = path.file_stem().and_then(|stem| stem.to_str()?.parse().ok());
            frames.extend(step.map(|step| (step, path)));
        }
    }
    frames.sort_unstable();
    Ok(frames)
}

fn kept(path: &Path) -> Result<Option<Vec<u8>>> {
    if path.exists() { npy::read_bytes(path).map(Some) } else { Ok(None) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For all committed results, including those of earlier versions.
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
            let summary = Done::read(&run).unwrap().summary;
            let again = serde_json::to_string_pretty(&summary).unwrap() + "\n";
            assert_eq!(again, std::fs::read_to_string(&path).unwrap(), "{}", path.display());
            count += 1;
        }
        assert!(count > 0);
    }
}
