//! The cut of U as a curve: its numbers, its file and the mesh that is divided along it.

use std::path::Path;

use ndarray::Array1;

use crate::Result;
use crate::contour::{Cells, Contours, CutRecord};
use crate::counted::counted;
use crate::mesh::{Mesh, io};
use crate::outcome::Looks;
use crate::solve::Solution;

use super::solving::Solving;
use super::{note, table};

/// Traces the cut on the mesh to which U belongs, in the units of its file, and adds its numbers to the summary.
pub fn traced(mesh: &Mesh, solution: &mut Solution) -> Contours {
    let summary = &mut solution.summary;
    let cells = Cells::new(mesh, solution.u.view(), summary.cut_threshold);
    let contours = cells.contours();
    summary.cut = Some(CutRecord::new(&cells, &contours, solution.labels.view()));
    contours
}

/// The contour, if it is to be written.
pub fn requested<'a>(contours: &'a Contours, solving: &Solving) -> Option<&'a Contours> {
    Some(contours).filter(|contours| solving.contours && !contours.polylines.is_empty())
}

/// Writes the divided mesh, if it is requested, and the lines that report on it and on the contour.
pub fn report(
    mesh: &Mesh,
    solution: &Solution,
    contours: &Contours,
    looks: &Looks,
    solving: &Solving,
) -> Result<Vec<(&'static str, String)>> {
    let mut lines = of_contours(contours, solving);
    if let Some(path) = &solving.cut_mesh {
        let cells = Cells::new(mesh, solution.u.view(), solution.summary.cut_threshold);
        let (cut, labels) = cells.cut_mesh();
        lines.push(write_cut_mesh(path, cut, &labels, looks)?);
    }
    Ok(lines)
}

/// The same for labels of faces, which are all in one region.
pub fn report_of_faces(
    mesh: &Mesh,
    labels: &Array1<i32>,
    contours: &Contours,
    looks: &Looks,
    solving: &Solving,
) -> Result<Vec<(&'static str, String)>> {
    let mut lines = of_contours(contours, solving);
    if let Some(path) = &solving.cut_mesh {
        let labels: Vec<u8> = labels.iter().map(|&p| p as u8).collect();
        lines.push(write_cut_mesh(path, mesh.clone(), &labels, looks)?);
    }
    Ok(lines)
}

fn of_contours(contours: &Contours, solving: &Solving) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if solving.contours && contours.polylines.is_empty() {
        note(
            "contours.obj is not written: U has no cut, since each component of the mesh is in one region; a smaller \
             --lambda gives more cuts",
        );
    } else if solving.contours {
        lines.push((
            "contours",
            format!(
                "{} of length {}",
                counted(contours.polylines.len(), "polyline", "polylines"),
                table::number(contours.length())
            ),
        ));
    }
    lines
}

fn write_cut_mesh(
    path: &Path,
    cut: Mesh,
    labels: &[u8],
    looks: &Looks,
) -> Result<(&'static str, String)> {
    let (vertices, faces) = (cut.vertices.len(), cut.faces.len());
    let colors: Vec<[f64; 3]> = looks.regions.iter().map(|region| region.color).collect();
    io::write_labeled_faces(path, cut, labels, &colors)?;
    Ok((
        "cut mesh",
        format!(
            "{}: {}, {}",
            path.display(),
            counted(vertices, "vertex", "vertices"),
            counted(faces, "face", "faces")
        ),
    ))
}
