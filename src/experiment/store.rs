//! The results folder of an experiment. Several processes may write to it, and any of them may be killed.
//!
//! ```text
//! results/NAME/experiment.toml                               the most recent experiment file
//!              runs/ID/spec.toml trace.csv summary.json manifest.json  [labels.npy certainty.npy] or [frames/STEP.ply photographs.png]
//!              instances/ID.ply                              the surface and its data, for the page
//!              figures/ tables/ report.html                  written by `report`
//! ```
//!
//! A run is made in `runs/.ID` under a lock, and renamed to `runs/ID` when it is complete. The operating system frees
//! the locks of a dead process, and the next one removes what it left in `runs/.ID`.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::spec::Spec;
use crate::error::{Error, Result};
use crate::file;

/// Labels and surfaces of meshes with more vertices are not kept.
pub const MAX_KEPT_VERTICES: usize = 200_000;

/// Surfaces with more vertices are not on the page.
pub const MAX_SHOWN_VERTICES: usize = 60_000;

/// The folder of a run with the surface on the way of a reconstruction, `STEP.ply` after this number of steps.
pub const FRAMES: &str = "frames";

/// The last surface of a reconstruction in some photographs.
pub const PHOTOGRAPHS: &str = "photographs.png";

/// The files that every run has.
const RUN_FILES: [&str; 4] = ["spec.toml", "trace.csv", "summary.json", "manifest.json"];

/// The first of these files that the folder of a run lacks.
pub fn lacking(run: &Path) -> Option<&'static str> {
    RUN_FILES.into_iter().find(|name| !run.join(name).is_file())
}

/// The results folder of one experiment.
pub struct Store {
    /// Its path, such as `results/NAME`.
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
    /// Opens a results folder, and creates it if it is missing. Fails if it cannot be created.
    pub fn open(folder: PathBuf) -> Result<Self> {
        let runs = folder.join("runs");
        fs::create_dir_all(&runs).map_err(|error| Error::io(&runs, error))?;
        Ok(Store { folder })
    }

    /// Keeps a copy of the experiment file with the results.
    ///
    /// # Errors
    /// The copy cannot be written.
    pub fn keep(&self, spec: &Spec) -> Result<()> {
        file::write(&self.folder.join("experiment.toml"), |out| out.write_all(spec.text.as_bytes()))
    }

    /// The folder of a run, whether it exists or not.
    pub fn run(&self, id: &str) -> PathBuf {
        self.folder.join("runs").join(id)
    }

    /// Whether a run exists with all its files.
    pub fn has(&self, id: &str) -> bool {
        lacking(&self.run(id)).is_none()
    }

    /// The runs that exist, including incomplete ones.
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
            // Hidden folders are runs in progress.
            if !name.starts_with('.') && entry.path().is_dir() {
                ids.push(name);
            }
        }
        Ok(ids)
    }

    /// The right to make a run that is missing, or any run if `again`; `None` if it exists by now or another process
    /// is making it.
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
    /// The folder for the files of the run.
    pub fn folder(&self) -> &Path {
        &self.unfinished
    }

    /// Makes the complete run visible.
    ///
    /// # Errors
    /// Its folder cannot be renamed.
    pub fn finish(self) -> Result<()> {
        if self.finished.exists() {
            remove(&self.finished)?;
        }
        fs::rename(&self.unfinished, &self.finished)
            .map_err(|error| Error::io(&self.finished, error))
    }
}

impl Drop for Claim {
    /// A process that opened the lock file before its removal finds the run finished once the lock is free.
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
