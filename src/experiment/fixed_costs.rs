//! Instances whose costs are fixed, on vertices or on faces: given costs, and costs of class probabilities, which are
//! given or synthetic.

use std::path::Path;

use nalgebra::Point3;
use ndarray::{Array2, ArrayView1};

use super::spec::InstanceCell;
use crate::classes::carry::colors_to_vertices;
use crate::classes::costs::{DEFAULT_FLOOR, Found, of_probabilities, of_scores};
use crate::classes::most_probable;
use crate::classes::noisy::noisy_scores;
use crate::colormap::categorical;
use crate::costs;
use crate::counted::counted;
use crate::data::synthetic::wave_labels;
use crate::domain::Element;
use crate::error::Result;
use crate::mesh::{Mesh, Source};
use crate::npy;
use crate::operator::Mass;
use crate::regions;
use crate::solve::{check_rows, check_rows_of_faces};

/// Costs that no parameter changes.
pub struct FixedCosts {
    /// V x m or F x m.
    pub s: Array2<f64>,
    /// A color per vertex: that of the cheapest region, or the mean of those of the faces around; NaN where unknown.
    pub looks: Vec<[f64; 3]>,
    /// The labels that synthetic probabilities come from.
    pub labels: Option<Vec<usize>>,
}

impl FixedCosts {
    /// Costs of a file.
    pub fn given(mesh: &Mesh, path: &Path, on: Element) -> Result<Self> {
        let s = read_rows("costs", mesh, path, on)?;
        regions::check(s.ncols()).map_err(|error| error.of_file(path))?;
        costs::checked(&s, Mass::Barycentric).map_err(|error| error.of_file(path))?;
        Ok(FixedCosts::new(mesh, s, on, None))
    }

    /// Costs of the class probabilities of a file, see [`of_probabilities`].
    pub fn of_probabilities(mesh: &Mesh, path: &Path, on: Element) -> Result<Self> {
        let p = read_rows("probabilities", mesh, path, on)?;
        let Found { s, divided, .. } =
            of_probabilities(&p, DEFAULT_FLOOR).map_err(|error| error.of_file(path))?;
        if divided > 0 {
            let [one, many] = on.nouns();
            tracing::warn!(
                "{}: the probabilities of {} do not sum to 1 and were divided by their sum",
                path.display(),
                counted(divided, one, many)
            );
        }
        Ok(FixedCosts::new(mesh, s, on, None))
    }

    /// Costs of noisy probabilities of faces. The classes are the known parts of the surface, or else waves.
    pub fn of_classes(source: &Source, mesh: &Mesh, cell: &InstanceCell) -> Result<Self> {
        let parts = match source {
            Source::Shape(shape) => shape.part_of_faces(),
            Source::File(_) | Source::Spot => None,
        };
        let labels = parts.unwrap_or_else(|| {
            let centroid = |j: usize| {
                let [a, b, c] = mesh.corners(j).map(|x| x.coords);
                Point3::from((a + b + c) / 3.0)
            };
            let centroids: Vec<_> = (0..mesh.faces.len()).map(centroid).collect();
            wave_labels(&centroids, cell.regions)
        });
        let scores = noisy_scores(&labels, cell.regions, cell.noise, cell.seed);
        let Found { s, .. } = of_scores(&scores, DEFAULT_FLOOR)?;
        Ok(FixedCosts::new(mesh, s, cell.on, Some(labels)))
    }

    fn new(mesh: &Mesh, s: Array2<f64>, on: Element, labels: Option<Vec<usize>>) -> Self {
        let color = |s: ArrayView1<'_, f64>| match most_probable(s) {
            p if s[p].is_nan() => [f64::NAN; 3],
            p => categorical(p),
        };
        let looks = match on {
            Element::Vertices => s.outer_iter().map(color).collect(),
            Element::Faces => colors_to_vertices(mesh, |j| color(s.row(j))),
        };
        FixedCosts { s, looks, labels }
    }
}

fn read_rows(what: &str, mesh: &Mesh, path: &Path, on: Element) -> Result<Array2<f64>> {
    let rows = npy::read_rows(path)?;
    match on {
        Element::Vertices => check_rows(what, rows.nrows(), mesh),
        Element::Faces => check_rows_of_faces(what, rows.nrows(), mesh),
    }
    .map_err(|error| error.of_file(path))?;
    Ok(rows)
}
