//! Data models by name.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::{Data, DataModel, Gaussian, Histogram, L1, PiecewiseConstant};
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
    pub fn with<T: ModelTask>(self, data: &Data, task: T) -> Result<T::Output> {
        match self {
            ModelName::Constant => task.run(&PiecewiseConstant::new(data)),
            ModelName::L1 => task.run(&L1::new(data)),
            ModelName::Gaussian => task.run(&Gaussian::new(data)?),
            ModelName::Histogram => task.run(&Histogram::new(data)?),
        }
    }
}
