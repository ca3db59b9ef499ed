//! Human segmentations of photographs, as in the Berkeley data set (BSDS500).
//!
//! A file holds a cell array `groundTruth` with one struct per human, whose field `Segmentation` is an image of labels.
//! The labels of vertices are those of their nearest pixels, where the image lies on the mesh as a photograph does with
//! `--data image:IMAGE` (`projection.rs`: onto the plane, covering the bounding box). Reference: P. Arbelaez, M. Maire,
//! C. Fowlkes, J. Malik, *Contour Detection and Hierarchical Image Segmentation*, PAMI 33, 2011.

mod mat;

use std::path::Path;

use ndarray::Array2;

use super::projection::{Fit, Projection};
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::Mesh;
use mat::{Value, find};

/// The label of a vertex without a pixel: one without faces.
pub const UNKNOWN: i64 = -1;

/// The segmentations in a `.mat` file, at least one, all of the same size: H x W labels, row by row from the top.
///
/// # Errors
/// The file cannot be read, is not a MATLAB file of version 5 to 7, is damaged, or holds no segmentations.
pub fn read(path: &Path) -> Result<Vec<Array2<u16>>> {
    parse(&file::read(path)?).map_err(|message| Error::malformed(path, message))
}

/// The segmentations at the vertices of a mesh: V labels per human, `UNKNOWN` at vertices without a face.
///
/// # Errors
/// As [`read`], or the mesh has no extent along x or y.
pub fn on_mesh(mesh: &Mesh, path: &Path) -> Result<Vec<Vec<i64>>> {
    let humans = read(path)?;
    let pixels = nearest_pixels(mesh, humans[0].dim())?;
    let label = |human: &Array2<u16>, pixel: Option<[usize; 2]>| {
        pixel.map_or(UNKNOWN, |pixel| i64::from(human[pixel]))
    };
    let labels = |human| pixels.iter().map(|&pixel| label(human, pixel)).collect();
    Ok(humans.iter().map(labels).collect())
}

/// Row and column of the pixel that contains each vertex, for an image of this many rows and columns.
fn nearest_pixels(mesh: &Mesh, (rows, columns): (usize, usize)) -> Result<Vec<Option<[usize; 2]>>> {
    let size = [columns as u32, rows as u32];
    let projected = Projection::XY.project(mesh, size, Fit::Cover)?;
    let mut pixels = vec![None; mesh.vertices.len()];
    for (face, uv) in mesh.faces.iter().zip(&projected.uv) {
        for (&k, &[u, v]) in face.iter().zip(uv) {
            // Pixel i covers [i, i + 1) / n; v points upwards.
            let pixel = |t: f64, n: usize| ((t * n as f64).max(0.0) as usize).min(n - 1);
            pixels[k as usize] = Some([pixel(1.0 - v, rows), pixel(u, columns)]);
        }
    }
    Ok(pixels)
}

fn parse(bytes: &[u8]) -> std::result::Result<Vec<Array2<u16>>, String> {
    let Some(truth) = find(bytes, "groundTruth")? else {
        return Err("has no variable groundTruth, so it is no file of human segmentations".into());
    };
    let Value::Cells(cells) = truth.value()? else {
        return Err("has a variable groundTruth that is not a cell array".into());
    };
    let mut humans: Vec<Array2<u16>> = Vec::new();
    for (i, cell) in cells.into_iter().enumerate() {
        let of_human = |message: String| format!("human {}: {message}", i + 1);
        let human = segmentation(&cell).map_err(of_human)?;
        if let Some(first) = humans.first()
            && first.dim() != human.dim()
        {
            let message = "the segmentation does not have the size of the first";
            return Err(of_human(message.into()));
        }
        humans.push(human);
    }
    match humans.is_empty() {
        false => Ok(humans),
        true => Err("holds no human segmentations".into()),
    }
}

fn segmentation(cell: &mat::Matrix) -> std::result::Result<Array2<u16>, String> {
    let Value::Struct(fields) = cell.value()? else {
        return Err("is not a struct".into());
    };
    let field = fields.into_iter().find(|(name, _)| name == "Segmentation");
    let Some((_, field)) = field else {
        return Err("the struct has no field Segmentation".into());
    };
    match field.value()? {
        Value::Labels(labels) => Ok(labels),
        _ => Err("Segmentation is not an array of numbers".into()),
    }
}

#[cfg(test)]
mod tests;
