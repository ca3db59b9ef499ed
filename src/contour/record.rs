//! The numbers of the cut, as in `summary.json`.

use ndarray::ArrayView1;
use serde::{Deserialize, Serialize};

use super::cells::Cells;
use super::labels::cut_length;
use super::polylines::Contours;
use crate::mesh::Mesh;

/// The cut of U beside that of the labels, in units of the mesh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CutRecord {
    /// The length of the contour.
    pub contour_length: f64,
    /// [`cut_length`] of the labels.
    pub cut_length: f64,
    /// The area of the cell of each region.
    pub cell_areas: Vec<f64>,
    /// [`Cells::share_that_differs`] from the labels.
    pub cells_differ_share: f64,
}

impl CutRecord {
    /// The numbers of labels of the faces of a mesh, whose cells are the faces.
    pub fn of_faces(
        mesh: &Mesh,
        contours: &Contours,
        labels: ArrayView1<'_, i32>,
        m: usize,
    ) -> Self {
        let mut cell_areas = vec![0.0; m];
        for (j, &label) in labels.iter().enumerate() {
            cell_areas[label as usize] += mesh.face_area(j);
        }
        let length = contours.length();
        CutRecord {
            contour_length: length,
            cut_length: length,
            cell_areas,
            cells_differ_share: 0.0,
        }
    }

    /// The numbers of the cells of U, their contours, and labels of the vertices.
    pub fn new(cells: &Cells, contours: &Contours, labels: ArrayView1<'_, i32>) -> Self {
        CutRecord {
            contour_length: contours.length(),
            cut_length: cut_length(cells.mesh, labels),
            cell_areas: cells.areas(),
            cells_differ_share: cells.share_that_differs(labels),
        }
    }
}
