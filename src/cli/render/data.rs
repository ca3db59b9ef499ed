//! The data to be shown, at the vertices of the mesh that is drawn.

use crate::Result;
use crate::data::input::{self, DataSource, InputData, Mapping, UnitRange};
use crate::data::range::robust_range;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Source};
use crate::render::panels::ShownData;

use crate::cli::{warn, welding};

/// Data at the vertices, see [`ShownData`].
pub enum Data {
    Colors(Vec<[f64; 3]>),
    Numbers { values: Vec<f64>, range: [f64; 2], label: String },
}

impl Data {
    pub fn shown(&self) -> ShownData<'_> {
        match self {
            Data::Colors(colors) => ShownData::Colors(colors),
            Data::Numbers { values, range, label } => {
                ShownData::Numbers { values, range: *range, label }
            }
        }
    }

    /// Those of the given vertices.
    pub fn at(&self, vertices: &[u32]) -> Self {
        match self {
            Data::Colors(colors) => {
                Data::Colors(vertices.iter().map(|&v| colors[v as usize]).collect())
            }
            Data::Numbers { values, range, label } => Data::Numbers {
                values: vertices.iter().map(|&v| values[v as usize]).collect(),
                range: *range,
                label: label.clone(),
            },
        }
    }

    /// Reads the data as `segment` does, and returns them with notes on which they are. Numbers are shown over their
    /// middle 96 %.
    ///
    /// # Errors
    /// The mesh does not have the data, or a file cannot be read or does not fit the mesh.
    pub fn read(
        source: &Source,
        mesh: &Mesh,
        choice: Option<&DataSource>,
        mapping: &Mapping,
    ) -> Result<(Self, Vec<String>)> {
        let weld = welding::weld(mesh, 0.0)?;
        let welded = weld.as_ref().map_or(mesh, |weld| &weld.mesh);
        let input = input::read(source, welded, weld.as_ref(), choice, mapping)?;
        warn(&input.warnings);
        let InputData { mut data, mut colors, name, unit_range, notes, .. } = input;
        if data.dimension == 1 {
            let range = match unit_range {
                None => robust_range(&data.values, &barycentric_areas(welded)),
                Some(UnitRange { ends: [low, high], .. }) => {
                    data.values.iter_mut().for_each(|t| *t = low + *t * (high - low));
                    [low, high]
                }
            };
            if let Some(weld) = &weld {
                data.values = weld.spread(&data.values);
            }
            return Ok((Data::Numbers { values: data.values, range, label: name }, notes));
        }
        if let Some(weld) = &weld {
            colors = weld.spread(&colors);
        }
        Ok((Data::Colors(colors), notes))
    }
}
