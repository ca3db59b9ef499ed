//! What is drawn: a mesh, and its data and regions as far as they are known.

use std::path::Path;

use meshseg::mesh::{Mesh, Source};
use meshseg::render::panels::{Regions, Shown, Surface};
use meshseg::solve::check_mesh;
use meshseg::{Error, Result, file, npy, regions};
use ndarray::{Array1, Axis, Ix1};

use super::data::Data;
use super::{Arguments, run_folder};

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
    /// Fails if a file cannot be read, or does not belong to the mesh.
    pub fn read(arguments: &Arguments) -> Result<Self> {
        let path = &arguments.surface;
        let input =
            if path.is_dir() { run_folder::read(path, arguments)? } else { of_mesh(arguments)? };
        check_mesh(&input.mesh).map_err(|error| error.of_file(path))?;
        Ok(input)
    }

    pub fn surface(&self) -> Surface<'_> {
        Surface {
            mesh: &self.mesh,
            data: self.data.as_ref().map(Data::shown),
            regions: self.regions.clone(),
            means: self.means.clone(),
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

/// A mesh with the data and the regions that the arguments name.
fn of_mesh(arguments: &Arguments) -> Result<Input> {
    let source = Source::parse(&arguments.surface)?;
    let mesh = source.mesh()?;
    let count = mesh.vertices.len();
    let regions = match (&arguments.u, &arguments.labels) {
        (Some(path), _) => Some(of_u(path, count)?),
        (None, Some(path)) => Some(of_labels(path, count, 1, None)?),
        (None, None) => None,
    };
    let data = Data::read(&source, &mesh, arguments.data.as_ref(), &arguments.mapping());
    let mut lacking_data = String::new();
    let (data, notes) = match data {
        Ok((data, notes)) => (Some(data), notes),
        // Regions can be shown without the data that come with the mesh.
        Err(error) if regions.is_some() && arguments.data.is_none() => {
            lacking_data = error.to_string();
            (None, Vec::new())
        }
        Err(error) => return Err(error),
    };
    Ok(Input {
        mesh,
        data,
        regions,
        means: None,
        notes,
        lacking: [
            lacking_data,
            "there are no regions; supply them with --u U.npy or --labels LABELS.npy, or name the folder of a run"
                .into(),
        ],
    })
}

/// The regions of U in a file.
pub fn of_u(path: &Path, vertices: usize) -> Result<Regions> {
    let u = npy::read_matrix(path)?;
    npy::check_rows(path, &u, vertices)?;
    regions::check(u.ncols()).map_err(|error| error.of_file(path))?;
    let m = u.ncols();
    Ok(Regions::of_u(u.as_standard_layout().iter().copied().collect(), m))
}

/// The regions of labels in a file, at least `m`, with max_p u_p if it is known.
pub fn of_labels(
    path: &Path,
    vertices: usize,
    m: usize,
    certainty: Option<Vec<f64>>,
) -> Result<Regions> {
    let found: Array1<i64> = npy::integers::<Ix1>(path, &file::read(path)?)?;
    npy::check_rows(path, &found.mapv(|label| label as f64).insert_axis(Axis(1)), vertices)?;
    let largest = *regions::REGIONS.end() - 1;
    let label = |(row, &label): (usize, &i64)| {
        usize::try_from(label).ok().filter(|&label| label <= largest).ok_or_else(|| {
            let message = format!("label {label} in row {row}; labels must be from 0 to {largest}");
            Error::malformed(path, message)
        })
    };
    let labels = found.iter().enumerate().map(label).collect::<Result<Vec<_>>>()?;
    let m = labels.iter().max().map_or(m, |largest| m.max(largest + 1));
    Ok(Regions::of_labels(&labels, m, certainty))
}
