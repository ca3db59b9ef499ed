//! Data models by name.

use nalgebra::Vector3;
use strum::{EnumString, IntoStaticStr, VariantNames};

use super::lambertian::Illumination;
use super::pixels::Evidence;
use super::{Data, DataModel, Gaussian, Histogram, L1, Lambertian, PiecewiseConstant, Radiance};
use crate::error::{Error, Result};

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
    /// [`Lambertian`].
    Albedo,
}

/// The data of a mesh: numbers at the vertices and, if they are means of pixels, what else the pixels say.
#[derive(Clone, Copy)]
pub struct Observed<'a> {
    /// V rows.
    pub data: &'a Data,
    /// The pixels, which the models constant and albedo see; the others see their means alone.
    pub evidence: Option<&'a Evidence>,
    /// What the model albedo needs to know of the surface.
    pub lit: Option<LitSurface<'a>>,
}

/// A surface on which light shines.
#[derive(Clone, Copy)]
pub struct LitSurface<'a> {
    /// V outward normals.
    pub normals: &'a [Vector3<f64>],
    /// The light, as far as it is given.
    pub illumination: Illumination,
}

impl<'a> From<&'a Data> for Observed<'a> {
    fn from(data: &'a Data) -> Self {
        Observed { data, evidence: None, lit: None }
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
            ModelName::Albedo => {
                let Some(LitSurface { normals, illumination }) = observed.lit else {
                    return Err(Error::unsuitable(
                        "the model albedo needs the normals of the surface",
                    ));
                };
                task.run(&Lambertian::new(data, observed.evidence, normals, illumination)?)
            }
        }
    }
}
