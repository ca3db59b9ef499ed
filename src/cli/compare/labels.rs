//! The labels that are compared: those of a file, or those of a result folder, which may have some for vertices and some
//! for faces.

use std::path::Path;

use ndarray::Ix1;
use serde_json::Value;

use crate::domain::Element;
use crate::names::Named;
use crate::{Error, Result, file, npy};

/// Labels, and what they are those of; `None` if that is not known.
pub struct Labels {
    pub labels: Vec<i64>,
    pub on: Option<Element>,
}

/// All labels of a file or a result folder. What the run has labeled comes first.
pub fn read(path: &Path) -> Result<Vec<Labels>> {
    if !path.is_dir() {
        return Ok(vec![Labels { labels: integers(path)?, on: None }]);
    }
    let of = |on: Element| {
        path.join(match on {
            Element::Vertices => "labels.npy",
            Element::Faces => "face_labels.npy",
        })
    };
    if !of(Element::Vertices).exists() {
        let message = "has no labels.npy; name a result folder or a .npy file of labels";
        return Err(Error::malformed(path, message));
    }
    let on = [Element::Vertices, Element::Faces];
    let is_on_faces = is_on_faces(path)?;
    if is_on_faces && !of(Element::Faces).exists() {
        // A run of an experiment, which keeps those of its instance only.
        let labels = integers(&of(Element::Vertices))?;
        return Ok(vec![Labels { labels, on: Some(Element::Faces) }]);
    }
    let on = if is_on_faces { [on[1], on[0]] } else { on };
    let there = on.into_iter().filter(|on| of(*on).exists());
    there.map(|on| Ok(Labels { labels: integers(&of(on))?, on: Some(on) })).collect()
}

/// The first of both that are equally many; if there are none, the first ones.
pub fn pair(labels: Vec<Labels>, truth: Vec<Labels>) -> [Labels; 2] {
    let fits = |a: &Labels| truth.iter().position(|b| b.labels.len() == a.labels.len());
    let found = labels.iter().enumerate().find_map(|(i, a)| Some((i, fits(a)?)));
    let (i, j) = found.unwrap_or((0, 0));
    let take = |mut all: Vec<Labels>, i: usize| all.swap_remove(i);
    [take(labels, i), take(truth, j)]
}

fn is_on_faces(folder: &Path) -> Result<bool> {
    let path = folder.join("summary.json");
    if !path.exists() {
        return Ok(false);
    }
    let summary: Value = serde_json::from_slice(&file::read(&path)?)
        .map_err(|error| Error::malformed(&path, error.to_string()))?;
    Ok(summary.get("on").and_then(Value::as_str) == Some(Element::Faces.name()))
}

fn integers(path: &Path) -> Result<Vec<i64>> {
    let labels = npy::integers::<Ix1>(path, &file::read(path)?)?;
    match labels.is_empty() {
        false => Ok(labels.to_vec()),
        true => Err(Error::malformed(path, "has no labels")),
    }
}
