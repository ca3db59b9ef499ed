//! The cut of U as a curve: its numbers, its file and the mesh that is divided along it.

use meshseg::Result;
use meshseg::contour::{Cells, Contours, CutRecord};
use meshseg::counted::counted;
use meshseg::mesh::{Mesh, io};
use meshseg::outcome::Looks;
use meshseg::solve::Solution;

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
    if let Some(path) = &solving.cut_mesh {
        let cells = Cells::new(mesh, solution.u.view(), solution.summary.cut_threshold);
        let (cut, labels) = cells.cut_mesh();
        let (vertices, faces) = (cut.vertices.len(), cut.faces.len());
        let colors: Vec<[f64; 3]> = looks.regions.iter().map(|region| region.color).collect();
        io::write_labeled_faces(path, cut, &labels, &colors)?;
        lines.push((
            "cut mesh",
            format!(
                "{}: {}, {}",
                path.display(),
                counted(vertices, "vertex", "vertices"),
                counted(faces, "face", "faces")
            ),
        ));
    }
    Ok(lines)
}
