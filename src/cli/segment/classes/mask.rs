//! `--mask`: the part of the surface that counts. The rest is left out: it has no costs, no cuts and the label -1.

use std::path::Path;

use ndarray::{Array1, Array2, Axis};

use crate::counted::counted;
use crate::domain::Element;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::seeds::Seeds;
use crate::{Error, Result};

use super::input::{element, numbers};
use crate::cli::memory::Memory;

/// The label of what is left out.
const OUTSIDE: i32 = -1;

/// What counts of a mesh.
pub struct Mask {
    /// The mesh of the file.
    pub whole: Mesh,
    /// Its faces that count.
    kept: Vec<usize>,
    /// Whether each vertex is a corner of such a face.
    inside: Vec<bool>,
}

impl Mask {
    /// All faces of a mesh without a file; with one, those with a number other than 0, or whose corners all have one.
    ///
    /// # Errors
    /// The file cannot be read, has another number of rows than the mesh has vertices or faces, or leaves nothing.
    pub fn read(
        path: Option<&Path>,
        on: Option<Element>,
        whole: Mesh,
        memory: &Memory,
    ) -> Result<Self> {
        let faces = whole.faces.len();
        let Some(path) = path else {
            return Ok(Mask { kept: (0..faces).collect(), inside: Vec::new(), whole });
        };
        let mask = numbers(path, "mask", memory)?;
        if mask.ncols() != 1 {
            let message = format!(
                "has {}; a mask has one number per vertex or face, 0 where the surface is left out",
                counted(mask.ncols(), "column", "columns")
            );
            return Err(Error::malformed(path, message));
        }
        let counts = |k: usize| mask[[k, 0]] != 0.0 && !mask[[k, 0]].is_nan();
        let of = element(path, mask.nrows(), &whole, on)?;
        let is_kept = |j: &usize| match of {
            Element::Faces => counts(*j),
            Element::Vertices => whole.faces[*j].iter().all(|&v| counts(v as usize)),
        };
        let kept: Vec<usize> = (0..faces).filter(is_kept).collect();
        if kept.is_empty() {
            return Err(Error::malformed(
                path,
                "leaves no face: it is 0 where the surface is left out",
            ));
        }
        let mut inside = vec![false; whole.vertices.len()];
        for &j in &kept {
            whole.faces[j].iter().for_each(|&v| inside[v as usize] = true);
        }
        Ok(Mask { whole, kept, inside })
    }

    fn is_whole(&self) -> bool {
        self.kept.len() == self.whole.faces.len()
    }

    /// The number of faces that are left out.
    pub fn left_out(&self) -> usize {
        self.whole.faces.len() - self.kept.len()
    }

    /// The mesh of what counts, with all vertices.
    pub fn mesh(&self) -> Mesh {
        if self.is_whole() {
            return self.whole.clone();
        }
        Mesh {
            faces: self.of_faces(&self.whole.faces),
            face_colors: self.whole.face_colors.as_ref().map(|colors| self.of_faces(colors)),
            uv: None,
            materials: None,
            ..self.whole.clone()
        }
    }

    fn of_faces<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.kept.iter().map(|&j| all[j]).collect()
    }

    /// The rows of what counts. Vertices outside cost nothing, whatever their label.
    pub fn rows(&self, mut rows: Array2<f64>, of: Element) -> Array2<f64> {
        match of {
            _ if self.is_whole() => rows,
            Element::Faces => rows.select(Axis(0), &self.kept),
            Element::Vertices => {
                let outside = self.inside.iter().enumerate().filter(|(_, inside)| !**inside);
                outside.for_each(|(v, _)| rows.row_mut(v).fill(0.0));
                rows
            }
        }
    }

    /// The seeds of what counts.
    pub fn seeds(&self, seeds: Seeds, on: Element) -> Seeds {
        if seeds.is_empty() || self.is_whole() {
            return seeds;
        }
        let region = |k: usize| seeds.region(k).map(|p| p as u8);
        Seeds::new(match on {
            Element::Faces => self.kept.iter().map(|&j| region(j)).collect(),
            Element::Vertices => {
                (0..self.inside.len()).map(|v| region(v).filter(|_| self.inside[v])).collect()
            }
        })
    }

    /// The contrast of what counts.
    pub fn contrast(&self, contrast: Contrast) -> Contrast {
        match contrast {
            Contrast::Normals => Contrast::Normals,
            Contrast::Colors(colors) => Contrast::Colors(self.of_faces(&colors)),
            Contrast::Faces(weights) => Contrast::Faces(self.of_faces(&weights)),
        }
    }

    /// Labels of all faces.
    pub fn all_faces(&self, labels: &Array1<i32>) -> Array1<i32> {
        let mut all = Array1::from_elem(self.whole.faces.len(), OUTSIDE);
        self.kept.iter().zip(labels).for_each(|(&j, &label)| all[j] = label);
        all
    }

    /// Labels of all vertices.
    pub fn all_vertices(&self, mut labels: Array1<i32>) -> Array1<i32> {
        if !self.is_whole() {
            let outside = labels.iter_mut().zip(&self.inside).filter(|(_, inside)| !**inside);
            outside.for_each(|(label, _)| *label = OUTSIDE);
        }
        labels
    }

    /// The rows of U for the whole mesh; NaN outside.
    pub fn all_rows(&self, mut u: Array2<f64>, on: Element) -> Array2<f64> {
        match on {
            _ if self.is_whole() => u,
            Element::Faces => {
                let mut all = Array2::from_elem((self.whole.faces.len(), u.ncols()), f64::NAN);
                self.kept
                    .iter()
                    .zip(u.outer_iter())
                    .for_each(|(&j, row)| all.row_mut(j).assign(&row));
                all
            }
            Element::Vertices => {
                let outside = self.inside.iter().enumerate().filter(|(_, inside)| !**inside);
                outside.for_each(|(v, _)| u.row_mut(v).fill(f64::NAN));
                u
            }
        }
    }
}
