//! The folder of a run: the result of `segment` or `solve`, or a run of an experiment.

use std::path::{Path, PathBuf};

use ndarray::Ix1;
use serde_json::Value;

use crate::data::input::DataSource;
use crate::domain::Element;
use crate::mesh::curvature::CurvatureKind;
use crate::mesh::{Mesh, Source, io};
use crate::names::Named;
use crate::render::panels::Regions;
use crate::solve::check_mesh;
use crate::{Error, Result, counted, file, npy, regions};

use super::arguments::Arguments;
use super::data::Data;
use super::input::{Input, Labeled, checked, labels, labels_of, of_u};

/// Reads the folder of a run. Fails if it is not one, or one of its files is missing or broken.
pub fn read(arguments: &Arguments) -> Result<Input> {
    let folder = arguments.surface.as_path();
    if !folder.join("labels.npy").is_file() {
        let message = if folder.join("manifest.json").is_file() {
            "holds no labels, which experiments keep of the first repetition on up to 200,000 vertices; name another \
             run, or a mesh"
        } else {
            "is a folder without labels.npy; name a result folder of segment or solve, runs/ID of an experiment, or a \
             mesh file"
        };
        return Err(Error::malformed(folder, message));
    }
    if arguments.u.is_some() || arguments.labels.is_some() {
        let message =
            "is the folder of a run, which has its own labels; name a mesh with --u or --labels";
        return Err(Error::malformed(folder, message));
    }
    if folder.join("segmented.ply").is_file() {
        of_result(folder, arguments)
    } else {
        of_experiment(folder, arguments)
    }
}

/// The mesh of a result folder of `segment` or `solve`. Fails if the folder is not one.
pub fn mesh(folder: &Path) -> Result<PathBuf> {
    let path = folder.join("segmented.ply");
    if path.is_file() && folder.join("labels.npy").is_file() {
        return Ok(path);
    }
    Err(Error::malformed(
        folder,
        "is not a result folder of segment, with segmented.ply and labels.npy",
    ))
}

/// A result folder of `segment` or `solve`.
fn of_result(folder: &Path, arguments: &Arguments) -> Result<Input> {
    let path = folder.join("segmented.ply");
    let mut mesh = io::read(&path)?;
    check_mesh(&mesh).map_err(|error| error.of_file(&path))?;
    // These are the colors of the regions.
    mesh.colors = None;
    mesh.face_colors = None;
    let summary = json(&folder.join("summary.json"))?;
    let on_faces = summary.get("on").and_then(Value::as_str) == Some(Element::Faces.name());
    let face_labels = folder.join("face_labels.npy");
    let face_labels = match on_faces || face_labels.is_file() {
        true => Some(unmasked(&face_labels, &mut mesh)?),
        false => None,
    };
    let notes = face_labels.as_ref().and_then(|found| found.note.clone()).into_iter();
    if let (true, Some(found)) = (on_faces, &face_labels) {
        let lacking = of_faces(folder, mesh, &found.labels, &summary, arguments)?;
        return Ok(Input { notes: notes.collect(), ..lacking });
    }
    let regions = match face_labels.as_ref().is_some_and(|found| found.note.is_some()) {
        true => of_masked_u(&folder.join("u.npy"), mesh.vertices.len())?,
        false => of_u(&folder.join("u.npy"), mesh.vertices.len())?,
    };
    let threshold = summary.get("cut_threshold").and_then(Value::as_f64);
    let regions = match regions.count() {
        2 => regions.with_threshold(threshold),
        _ => regions,
    };
    let lacking_data = format!(
        "{}: does not keep the data; draw the mesh that has them: meshseg render MESH --u {}",
        folder.display(),
        folder.join("u.npy").display()
    );
    let source = Source::File(path);
    let read = |choice: &DataSource| Data::read(&source, &mesh, Some(choice), &arguments.mapping());
    let found = match &arguments.data {
        Some(DataSource::Colors | DataSource::Texture(None)) => {
            return Err(Error::unsuitable(lacking_data));
        }
        Some(choice) => Some(read(choice)?),
        None => segmented(&summary).and_then(|choice| {
            let (data, mut notes) = read(&choice).ok()?;
            notes.push(format!("the data are read again: {choice}"));
            Some((data, notes))
        }),
    };
    let (data, of_data) = found.map_or((None, Vec::new()), |(data, notes)| (Some(data), notes));
    let notes = notes.chain(of_data).collect();
    let means = if data.is_none() { means(&summary, regions.count()) } else { None };
    Ok(Input {
        mesh,
        data,
        regions: Some(regions),
        means,
        notes,
        lacking: [lacking_data, String::new()],
    })
}

/// Labels of the faces that a mask has not left out.
struct Unmasked {
    labels: Vec<usize>,
    /// How many are left out.
    note: Option<String>,
}

/// Reads the labels of the faces, and removes those without one from the mesh.
fn unmasked(path: &Path, mesh: &mut Mesh) -> Result<Unmasked> {
    let found = npy::integers::<Ix1>(path, &file::read(path)?)?;
    let all = mesh.faces.len();
    let is_left_out = |j: usize| found[j] == -1;
    if found.len() != all || !(0..all).any(is_left_out) {
        return Ok(Unmasked { labels: labels(path, Element::Faces, all)?, note: None });
    }
    let kept: Vec<usize> = (0..all).filter(|&j| !is_left_out(j)).collect();
    let faces = kept.iter().map(|&j| mesh.faces[j]).collect();
    *mesh = Mesh::new(std::mem::take(&mut mesh.vertices), faces);
    check_mesh(mesh).map_err(|error| error.of_file(path))?;
    let note = format!("{} of {all} faces are left out by the mask", all - kept.len());
    let kept = kept.into_iter().map(|j| found[j]).collect();
    Ok(Unmasked {
        labels: checked(path, kept, Element::Faces, mesh.faces.len())?,
        note: Some(note),
    })
}

/// The regions of U in a file; rows of NaN belong to vertices that are not drawn.
fn of_masked_u(path: &Path, vertices: usize) -> Result<Regions> {
    let u = npy::read_rows(path)?;
    npy::check_rows(path, &u, vertices)?;
    regions::check(u.ncols()).map_err(|error| error.of_file(path))?;
    let m = u.ncols();
    Ok(Regions::of_u(u.iter().map(|&u| if u.is_nan() { 0.0 } else { u }).collect(), m))
}

/// Labels of faces, drawn on a mesh that is divided between them.
fn of_faces(
    folder: &Path,
    mesh: Mesh,
    labels: &[usize],
    summary: &Value,
    arguments: &Arguments,
) -> Result<Input> {
    let lacking_data = format!(
        "{}: the run has labels of faces, and no data are drawn beside these; show labels",
        folder.display()
    );
    if arguments.data.is_some() {
        return Err(Error::unsuitable(lacking_data));
    }
    let m = summary.get("regions").and_then(Value::as_u64).unwrap_or(1);
    let m = m.clamp(1, *regions::REGIONS.end() as u64) as usize;
    let Labeled { mesh, regions, .. } = Labeled::new(mesh, (Element::Faces, labels), m, None);
    Ok(Input {
        mesh,
        regions: Some(regions),
        data: None,
        means: None,
        notes: Vec::new(),
        lacking: [lacking_data, String::new()],
    })
}

/// The data that were segmented, if they can be read again.
fn segmented(summary: &Value) -> Option<DataSource> {
    let name = summary.get("data")?.as_str()?;
    let mut kinds = CurvatureKind::names().iter().filter_map(|name| CurvatureKind::named(name));
    if let Some(kind) = kinds.find(|kind| kind.words() == name) {
        return Some(DataSource::Curvature(kind));
    }
    let path = Path::new(name);
    let is_data = name.ends_with(".npy") || io::names_values(path);
    (is_data && path.is_file()).then(|| DataSource::File(name.into()))
}

/// The mean color of each region in the data that were segmented, gray for empty regions.
fn means(summary: &Value, m: usize) -> Option<Vec<[f64; 3]>> {
    let regions = summary.get("region_parameters")?.as_array()?;
    let color = |region: &Value| -> Option<[f64; 3]> {
        let numbers = region.get("color")?.as_array()?.iter().map(Value::as_f64);
        numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()
    };
    let colors: Vec<Option<[f64; 3]>> = regions.iter().map(color).collect();
    let known = colors.len() == m && colors.iter().any(Option::is_some);
    known.then(|| colors.into_iter().map(|color| color.unwrap_or([0.72; 3])).collect())
}

/// A run of an experiment, whose surface is kept beside the runs.
fn of_experiment(folder: &Path, arguments: &Arguments) -> Result<Input> {
    let manifest = folder.join("manifest.json");
    if !manifest.is_file() {
        let message = "is a folder with labels.npy, but without segmented.ply, so its mesh is unknown; draw the mesh \
                       with --labels";
        return Err(Error::malformed(folder, message));
    }
    let id = json(&manifest)?.get("instance_id").and_then(Value::as_str).map(str::to_owned);
    let id = id.ok_or_else(|| {
        Error::malformed(&manifest, "has no instance_id; run the experiment again")
    })?;
    // Not by `..`, which leads elsewhere if the folder is a link.
    let whole = folder.canonicalize().map_err(|error| Error::io(folder, error))?;
    let experiment = whole.parent().and_then(Path::parent).unwrap_or(&whole);
    let path: PathBuf = experiment.join("instances").join(format!("{id}.ply"));
    let mut mesh: Mesh = io::read(&path)?;
    check_mesh(&mesh).map_err(|error| error.of_file(&path))?;
    let (on, labels) = labels_of(&folder.join("labels.npy"), &mesh)?;
    let certainty = folder.join("certainty.npy");
    let certainty = match on == Element::Vertices && certainty.is_file() {
        true => {
            let bytes = npy::read_bytes(&certainty)?;
            if bytes.len() != mesh.vertices.len() {
                let message = format!(
                    "has {}, but the mesh has {}; run the experiment again",
                    counted::counted(bytes.len(), "row", "rows"),
                    counted::counted(mesh.vertices.len(), "vertex", "vertices")
                );
                return Err(Error::malformed(&certainty, message));
            }
            Some(bytes.into_iter().map(|byte| f64::from(byte) / 255.0).collect())
        }
        false => None,
    };
    let m = json(&folder.join("summary.json"))?.get("regions").and_then(Value::as_u64);
    let m = m.unwrap_or(1).clamp(1, *regions::REGIONS.end() as u64) as usize;
    let (data, notes) = match &arguments.data {
        None => (mesh.colors.take().map(Data::Colors), Vec::new()),
        Some(choice) => {
            let source = Source::File(path.clone());
            let (data, notes) = Data::read(&source, &mesh, Some(choice), &arguments.mapping())?;
            (Some(data), notes)
        }
    };
    let lacking = [format!("{}: has no colors", path.display()), String::new()];
    let labeled = Labeled::new(mesh, (on, &labels), m, certainty);
    let data = data.map(|data| labeled.data(data));
    let Labeled { mesh, regions, .. } = labeled;
    Ok(Input { mesh, data, regions: Some(regions), means: None, notes, lacking })
}

/// A JSON file of a run.
pub fn json(path: &Path) -> Result<Value> {
    serde_json::from_slice(&file::read(path)?).map_err(|error| {
        Error::malformed(path, format!("is not JSON: {error}; make the run again"))
    })
}
