//! Data models: which pointwise costs s_p(x) the data suggest for region p, and which region parameters mu_p
//! suit given labels. One likelihood a file; what all of them have to answer is [`DataModel`].

pub mod constant;
pub mod curved;
pub mod gaussian;
pub mod input;
pub mod kmeans;
pub mod l1;
mod model;
pub mod palette;
pub mod projection;
pub mod range;
pub mod synthetic;
pub mod texture;
mod values;

#[cfg(test)]
mod tests;

pub use constant::PiecewiseConstant;
pub use gaussian::Gaussian;
pub use l1::L1;
pub use model::{DataModel, Initial, Scale};
pub use values::Data;
