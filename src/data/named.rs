//! Data models by name.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::radiance::Evidence;
use super::{Data, DataModel, Gaussian, Histogram, L1, PiecewiseConstant, Radiance};
use crate::error::Result;

/// The models of data that are numbers at the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum ModelName {
    /// [`PiecewiseConstant`].
    #[default]
    Constant,
    /// [`L1`].
    L1,
    /// [`Gaussian`].
    Gaussian,
    /// [`Histogram`].
    Histogram,
}

/// The data of a mesh: numbers at the vertices and, if they are means of pixels, what else the pixels say.
#[derive(Clone, Copy)]
pub struct Observed<'a> {
    /// V rows.
    pub data: &'a Data,
    /// The pixels, which the piecewise constant model sees; the others see their means alone.
    pub evidence: Option<&'a Evidence>,
}

impl<'a> From<&'a Data> for Observed<'a> {
    fn from(data: &'a Data) -> Self {
        Observed { data, evidence: None }
    }
}

/// A computation for a data model of any type.
pub trait ModelTask {
    /// Its result.
    type Output;

    /// Runs it.
    ///
    /// # Errors
    /// Those of the computation.
    fn run<D: DataModel>(self, model: &D) -> Result<Self::Output>;
}

impl ModelName {
    /// Runs a computation for the model of these data.
    ///
    /// # Errors
    /// Data that the model cannot describe, and the errors of the computation.
    pub fn with<T: ModelTask>(self, observed: Observed<'_>, task: T) -> Result<T::Output> {
        let data = observed.data;
        match self {
            ModelName::Constant => match observed.evidence {
                Some(evidence) => task.run(&Radiance::new(data, evidence)),
                None => task.run(&PiecewiseConstant::new(data)),
            },
            ModelName::L1 => task.run(&L1::new(data)),
            ModelName::Gaussian => task.run(&Gaussian::new(data)?),
            ModelName::Histogram => task.run(&Histogram::new(data)?),
        }
    }
}
