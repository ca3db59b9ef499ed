//! The folder of results of an experiment, which several processes may write to, and any may die.
//!
//! ```text
//! results/NAME/experiment.toml                               the file that was run last
//!              runs/ID/spec.toml trace.csv summary.json manifest.json  [labels.npy certainty.npy]
//!              instances/ID.ply                              the surface and its data, for the page
//!              figures/ tables/ report.html                  what `report` makes of it
//! ```
//!
//! A run is made in `runs/.ID` under a lock, and renamed to `runs/ID` when it is whole. Locks are the operating
//! system's: those of a dead process are free, and what it left in `runs/.ID` goes to the next one's bin.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::spec::Spec;
use crate::error::{Error, Result};
use crate::file;

/// The files that every run has.
const RUN_FILES: [&str; 4] = ["spec.toml", "trace.csv", "summary.json", "manifest.json"];

/// Of these files the first that the folder of a run lacks.
pub fn lacking(run: &Path) -> Option<&'static str> {
    RUN_FILES.into_iter().find(|name| !run.join(name).is_file())
}

/// The folder of results of one experiment.
pub struct Store {
    /// Such as `results/NAME`.
    pub folder: PathBuf,
}

/// The right to make one run.
pub struct Claim {
    lock: File,
    lock_path: PathBuf,
    unfinished: PathBuf,
    finished: PathBuf,
}

impl Store {
    /// A folder of results, made if it is missing. Fails if it cannot be made.
    pub fn open(folder: PathBuf) -> Result<Self> {
        let runs = folder.join("runs");
        fs::create_dir_all(&runs).map_err(|error| Error::io(&runs, error))?;
        Ok(Store { folder })
    }

    /// Keeps a copy of the file, for those who find the results without it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn keep(&self, spec: &Spec) -> Result<()> {
        file::write(&self.folder.join("experiment.toml"), |out| out.write_all(spec.text.as_bytes()))
    }

    /// The folder of a run, whether it is there or not.
    pub fn run(&self, id: &str) -> PathBuf {
        self.folder.join("runs").join(id)
    }

    /// Whether a run is there, with all its files.
    pub fn has(&self, id: &str) -> bool {
        lacking(&self.run(id)).is_none()
    }

    /// The runs that are there, or what is left of them.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn ids(&self) -> Result<Vec<String>> {
        let runs = self.folder.join("runs");
        let io = |error| Error::io(&runs, error);
        let mut ids = Vec::new();
        for entry in fs::read_dir(&runs).map_err(io)? {
            let entry = entry.map_err(io)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            // Hidden ones are under way.
            if !name.starts_with('.') && entry.path().is_dir() {
                ids.push(name);
            }
        }
        Ok(ids)
    }

    /// The right to make a run that is missing, or any if `again`; `None` if it is there by now or another
    /// process is at it.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn claim(&self, id: &str, again: bool) -> Result<Option<Claim>> {
        let lock_path = self.folder.join("runs").join(format!(".{id}.lock"));
        let io = |error| Error::io(&lock_path, error);
        let mut options = File::options();
        let lock = options.create(true).truncate(false).write(true).open(&lock_path).map_err(io)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => return Err(io(error)),
        }
        let unfinished = self.folder.join("runs").join(format!(".{id}"));
        let claim = Claim { lock, lock_path, unfinished, finished: self.run(id) };
        if self.has(id) && !again {
            return Ok(None);
        }
        if claim.unfinished.exists() {
            remove(&claim.unfinished)?;
        }
        fs::create_dir(&claim.unfinished).map_err(|error| Error::io(&claim.unfinished, error))?;
        Ok(Some(claim))
    }
}

impl Claim {
    /// Where the files of the run go.
    pub fn folder(&self) -> &Path {
        &self.unfinished
    }

    /// The run is whole.
    ///
    /// # Errors
    /// It cannot be moved to its place.
    pub fn finish(self) -> Result<()> {
        if self.finished.exists() {
            remove(&self.finished)?;
        }
        fs::rename(&self.unfinished, &self.finished)
            .map_err(|error| Error::io(&self.finished, error))
    }
}

impl Drop for Claim {
    /// A process that opened the lock file before it is removed finds the run finished once the lock is free.
    fn drop(&mut self) {
        let leftovers = [fs::remove_dir_all(&self.unfinished), fs::remove_file(&self.lock_path)];
        for error in leftovers.into_iter().filter_map(std::result::Result::err) {
            if error.kind() != std::io::ErrorKind::NotFound {
                tracing::warn!("{}: {error}", self.unfinished.display());
            }
        }
        if let Err(error) = self.lock.unlock() {
            tracing::warn!("{}: {error}", self.lock_path.display());
        }
    }
}

fn remove(folder: &Path) -> Result<()> {
    fs::remove_dir_all(folder).map_err(|error| Error::io(folder, error))
}
