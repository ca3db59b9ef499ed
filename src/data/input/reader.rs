//! What is read, and from what.

use std::path::PathBuf;

use super::source::Mapping;
use crate::data::Data;
use crate::error::Result;
use crate::mesh::{Mesh, Source};

/// The data, how it looks, and what to call it.
pub struct InputData {
    /// V x d values.
    pub data: Data,
    /// A color per vertex; NaN where the data are unknown.
    pub colors: Vec<[f64; 3]>,
    /// Such as `mean curvature`, `colors`, or the path of an array; for captions.
    pub name: String,
    /// What 0 and 1 stand for, if the data was mapped.
    pub unit_range: Option<[f64; 2]>,
    /// What was chosen, and what else there is to choose, a line each.
    pub notes: Vec<String>,
    /// What the sign of the data means, if it has a meaning that is not plain.
    pub sign: Option<&'static str>,
    /// What the user should know, a sentence each.
    pub warnings: Vec<String>,
}

/// A mesh whose data are read.
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
    })
}
