//! Convex multi-region segmentation of data on triangle meshes.

pub mod atomic;
pub mod data;
pub mod error;
pub mod mesh;
pub mod render;

pub use error::{Error, Result};
pub use mesh::Mesh;
