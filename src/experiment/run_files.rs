//! What a run makes, and its files.

use std::fs;
use std::path::Path;

use ndarray::Array1;

use super::labeled::Made;
use super::manifest::Manifest;
use super::numbers::Numbers;
use super::plan::Planned;
use super::reconstructed::{Frame, Reconstructed};
use super::store::{FRAMES, MAX_KEPT_VERTICES, PHOTOGRAPHS, Store};
use super::surface_trace;
use crate::error::{Error, Result};
use crate::evolve::End;
use crate::mesh::{Mesh, io};
use crate::outcome::{write_png, write_trace};
use crate::run::Status;
use crate::solve::Solution;
use crate::{file, npy};

/// What a run made.
pub enum Outcome {
    /// Labels of an instance.
    Labels(Made),
    /// A surface.
    Surface(Reconstructed),
}

impl Outcome {
    /// Its numbers.
    pub fn numbers(&self) -> Numbers {
        match self {
            Outcome::Labels(made) => Numbers::Labels(Box::new(made.solution.summary.clone())),
            Outcome::Surface(found) => Numbers::Surface(Box::new(found.summary.clone())),
        }
    }

    /// Whether the observer ended the run.
    pub fn is_interrupted(&self) -> bool {
        match self {
            Outcome::Labels(made) => made.solution.summary.status == Status::Interrupted,
            Outcome::Surface(found) => found.summary.status == End::Interrupted,
        }
    }
}

/// Writes all files of a run into its folder.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    run: &Planned<'_>,
    outcome: &Outcome,
    numbers: &Numbers,
    manifest: &Manifest,
) -> Result<()> {
    let json = |name: &str, value: &dyn Fn(&mut dyn std::io::Write) -> serde_json::Result<()>| {
        file::write(&folder.join(name), |out| {
            value(out)?;
            out.write_all(b"\n")
        })
    };
    file::write(&folder.join("spec.toml"), |out| out.write_all(run.toml.as_bytes()))?;
    json("summary.json", &|out| serde_json::to_writer_pretty(out, numbers))?;
    match outcome {
        Outcome::Labels(made) => write_labels(folder, run, &made.solution)?,
        Outcome::Surface(found) => write_surfaces(folder, run, found)?,
    }
    json("manifest.json", &|out| serde_json::to_writer_pretty(out, manifest))
}

/// Writes the trace and the surface on the way.
fn write_surfaces(folder: &Path, run: &Planned<'_>, found: &Reconstructed) -> Result<()> {
    surface_trace::write(&folder.join("trace.csv"), &found.rows)?;
    if run.repetition > 0 {
        return Ok(());
    }
    write_png(&folder.join(PHOTOGRAPHS), &found.photographs)?;
    let folder = folder.join(FRAMES);
    fs::create_dir(&folder).map_err(|error| Error::io(&folder, error))?;
    let small = |frame: &&Frame| frame.mesh.vertices.len() <= MAX_KEPT_VERTICES;
    for Frame { step, mesh } in found.frames.iter().filter(small) {
        io::write(&folder.join(format!("{step}.ply")), mesh)?;
    }
    Ok(())
}

/// Writes the trace and the labels.
fn write_labels(folder: &Path, run: &Planned<'_>, solution: &Solution) -> Result<()> {
    write_trace(&folder.join("trace.csv"), &solution.trace)?;
    if run.repetition == 0 && solution.labels.len() <= MAX_KEPT_VERTICES {
        let labels: Array1<u8> = solution.labels.iter().map(|&label| label as u8).collect();
        let certainty: Array1<u8> = (solution.u.outer_iter())
            .map(|u| (255.0 * u.iter().fold(0.0, |a: f64, &b| a.max(b))).round() as u8)
            .collect();
        npy::write(&folder.join("labels.npy"), &labels)?;
        npy::write(&folder.join("certainty.npy"), &certainty)?;
    }
    Ok(())
}

/// Writes the surface and its data for the page, once per instance.
///
/// # Errors
/// The file cannot be written.
pub fn keep_surface(
    store: &Store,
    run: &Planned<'_>,
    mesh: &Mesh,
    color: impl Fn(usize) -> [f64; 3],
) -> Result<()> {
    let folder = store.folder.join("instances");
    let path = folder.join(format!("{}.ply", run.instance_id));
    if mesh.vertices.len() > MAX_KEPT_VERTICES || path.exists() {
        return Ok(());
    }
    fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, error))?;
    let Mesh { vertices, faces, .. } = mesh.clone();
    // Unknown colors become gray.
    let known = |k: usize| color(k).map(|c| if c.is_nan() { 0.5 } else { c });
    let colors = Some((0..vertices.len()).map(known).collect());
    io::write(&path, &Mesh { vertices, faces, colors, ..Mesh::default() })
}
