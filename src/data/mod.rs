//! Data on the vertices, and models of how a region explains them.

pub mod kmeans;
pub mod range;
pub mod texture;
