//! Data models: the pointwise costs s_p(x) of the data for region p, and the region parameters mu_p that fit given
//! labels. One likelihood per file; all implement [`DataModel`].

pub mod constant;
pub mod curved;
pub mod gaussian;
pub mod histogram;
pub mod humans;
pub mod input;
pub mod kmeans;
pub mod l1;
pub mod lambertian;
mod model;
mod named;
pub mod palette;
pub mod pixels;
pub mod projection;
pub mod radiance;
pub mod range;
pub mod synthetic;
pub mod texture;
pub mod thresholds;
mod values;
pub mod views;
mod weights;

#[cfg(test)]
mod tests;

pub use constant::PiecewiseConstant;
pub use gaussian::Gaussian;
pub use histogram::Histogram;
pub use l1::L1;
pub use lambertian::Lambertian;
pub use model::{Cost, DataModel, Initial, Scale, cost_row, rows};
pub use named::{LitSurface, ModelName, ModelTask, Observed};
pub use radiance::Radiance;
pub use values::Data;
pub use weights::Weights;
