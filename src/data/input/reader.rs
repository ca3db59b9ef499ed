//! The data that were read, and the mesh and options that they were read by.

use std::path::PathBuf;

use super::source::Mapping;
use crate::data::pixels::Evidence;
use crate::data::views::Coverage;
use crate::data::{Data, Observed};
use crate::error::Result;
use crate::mesh::{Mesh, Source};

/// The data of a mesh, with their colors and their name.
pub struct InputData {
    /// V x d values.
    pub data: Data,
    /// A color per vertex; NaN where the data are unknown.
    pub colors: Vec<[f64; 3]>,
    /// Such as `mean curvature`, `colors`, or the path of an array; for captions.
    pub name: String,
    /// The values that were mapped to 0 and 1, if the data were mapped.
    pub unit_range: Option<UnitRange>,
    /// Which data were chosen and which others can be, one line each.
    pub notes: Vec<String>,
    /// The meaning of the sign of the data, if it needs an explanation.
    pub sign: Option<&'static str>,
    /// Warnings, one sentence each.
    pub warnings: Vec<String>,
    /// What the pixels of views say beyond their means, which are the data.
    pub evidence: Option<Evidence>,
    /// Who saw what, if the data are views.
    pub coverage: Option<Coverage>,
}

impl InputData {
    /// The data for a model.
    pub fn observed(&self) -> Observed<'_> {
        Observed { data: &self.data, evidence: self.evidence.as_ref(), lit: None }
    }
}

/// The values that were mapped to 0 and 1, in 1/length^n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitRange {
    /// Those of 0 and of 1, with the length unit of the mesh.
    pub ends: [f64; 2],
    /// n.
    pub inverse_lengths: i32,
}

impl UnitRange {
    /// The ends on the mesh scaled by a factor.
    pub fn on_scaled(&self, factor: f64) -> [f64; 2] {
        self.ends.map(|end| end / factor.powi(self.inverse_lengths))
    }

    /// The unit, if there is one.
    pub fn unit(&self) -> Option<&'static str> {
        match self.inverse_lengths {
            0 => None,
            1 => Some("1/length"),
            _ => Some("1/length^2"),
        }
    }
}

/// A mesh whose data are to be read.
pub struct Reader<'a> {
    pub source: &'a Source,
    pub mesh: &'a Mesh,
    pub mapping: &'a Mapping,
}

impl Reader<'_> {
    pub fn name(&self) -> PathBuf {
        self.source.to_string().into()
    }
}

pub fn colored(colors: Vec<[f64; 3]>, name: String) -> Result<InputData> {
    let data = Data::new(3, colors.as_flattened().to_vec())?;
    Ok(InputData {
        data,
        colors,
        name,
        unit_range: None,
        notes: Vec::new(),
        sign: None,
        warnings: Vec::new(),
        evidence: None,
        coverage: None,
    })
}
