//! What is drawn: a mesh, and its data and regions as far as they are known.

use std::path::Path;

use ndarray::{Array1, Ix1};

use crate::counted::counted;
use crate::domain::Element;
use crate::mesh::{Mesh, Split};
use crate::render::panels::{Regions, Shown, Surface};
use crate::{Error, Result, file, npy, regions};

use super::data::Data;

pub struct Input {
    pub mesh: Mesh,
    pub data: Option<Data>,
    pub regions: Option<Regions>,
    /// The mean color of each region, where the data are not known.
    pub means: Option<Vec<[f64; 3]>>,
    pub notes: Vec<String>,
    /// Why there are no data or no regions, and what to do.
    pub lacking: [String; 2],
}

impl Input {
    pub fn surface(&self) -> Surface<'_> {
        Surface {
            mesh: &self.mesh,
            data: self.data.as_ref().map(Data::shown),
            regions: self.regions.clone(),
            means: self.means.clone(),
            frame: None,
        }
    }

    /// What is shown by default.
    pub fn default(&self) -> Vec<Shown> {
        let means = self.data.is_some() || self.means.is_some();
        let mut shown = Vec::new();
        shown.extend(self.data.as_ref().map(|_| Shown::Data { cut: false }));
        if self.regions.is_some() {
            shown.extend(means.then_some(Shown::Means));
            shown.push(Shown::Labels);
        }
        shown
    }

    /// Fails if a quantity cannot be shown; the message says what to do.
    pub fn check(&self, surface: &Surface, shown: Shown) -> Result<()> {
        let [data, regions] = &self.lacking;
        let needs_data =
            matches!(shown, Shown::Data { .. }) || shown == Shown::Means && self.means.is_none();
        if needs_data && self.data.is_none() {
            return Err(Error::unsuitable(data));
        }
        if shown.needs_regions() && self.regions.is_none() {
            return Err(Error::unsuitable(format!("{shown} cannot be shown: {regions}")));
        }
        surface.check(shown)
    }
}

/// The regions of U in a file.
pub fn of_u(path: &Path, vertices: usize) -> Result<Regions> {
    let u = npy::read_matrix(path)?;
    npy::check_rows(path, &u, vertices)?;
    regions::check(u.ncols()).map_err(|error| error.of_file(path))?;
    let m = u.ncols();
    Ok(Regions::of_u(u.as_standard_layout().iter().copied().collect(), m))
}

/// A mesh as it is drawn with labels, and its regions, at least `m`.
pub struct Labeled {
    pub mesh: Mesh,
    pub regions: Regions,
    /// The vertex that each one was before the mesh was divided between labels of faces.
    of: Option<Vec<u32>>,
}

impl Labeled {
    /// With labels of its vertices, of which max_p u_p may be known, or of its faces.
    pub fn new(
        mesh: Mesh,
        (on, labels): (Element, &[usize]),
        m: usize,
        certainty: Option<Vec<f64>>,
    ) -> Self {
        let m = labels.iter().max().map_or(m, |largest| m.max(largest + 1));
        match on {
            Element::Vertices => {
                Labeled { mesh, regions: Regions::of_labels(labels, m, certainty), of: None }
            }
            Element::Faces => {
                let labels: Vec<u16> = labels.iter().map(|&label| label as u16).collect();
                let Split { mesh, labels, of } = mesh.split(&labels);
                let labels: Vec<usize> = labels.into_iter().map(usize::from).collect();
                Labeled { mesh, regions: Regions::of_labels(&labels, m, None), of: Some(of) }
            }
        }
    }

    /// Data of the mesh that was given, on the one that is drawn.
    pub fn data(&self, data: Data) -> Data {
        match &self.of {
            None => data,
            Some(of) => data.at(of),
        }
    }
}

/// The labels in a file, one per vertex or face of the mesh, from 0 to 63.
pub fn labels(path: &Path, of: Element, count: usize) -> Result<Vec<usize>> {
    checked(path, integers(path)?, of, count)
}

/// The same for whichever the file has as many of.
pub fn labels_of(path: &Path, mesh: &Mesh) -> Result<(Element, Vec<usize>)> {
    let found = integers(path)?;
    let [vertices, faces] = [mesh.vertices.len(), mesh.faces.len()];
    let is_of_faces = found.len() == faces && faces != vertices;
    let of = if is_of_faces { Element::Faces } else { Element::Vertices };
    Ok((of, checked(path, found, of, of.count(mesh))?))
}

fn integers(path: &Path) -> Result<Array1<i64>> {
    npy::integers::<Ix1>(path, &file::read(path)?)
}

/// Labels from 0 to 63, as many as there are vertices or faces.
pub fn checked(path: &Path, found: Array1<i64>, of: Element, count: usize) -> Result<Vec<usize>> {
    let [one, many] = of.nouns();
    if found.len() != count {
        let message = format!(
            "has {}, but the mesh has {}; supply one row per {one}",
            counted(found.len(), "row", "rows"),
            counted(count, one, many)
        );
        return Err(Error::malformed(path, message));
    }
    let largest = *regions::REGIONS.end() - 1;
    let label = |(row, &label): (usize, &i64)| {
        usize::try_from(label).ok().filter(|&label| label <= largest).ok_or_else(|| {
            let message = format!("label {label} in row {row}; labels must be from 0 to {largest}");
            Error::malformed(path, message)
        })
    };
    found.iter().enumerate().map(label).collect()
}
