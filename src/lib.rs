//! Convex multi-region segmentation of data on triangle meshes.

pub mod atomic;
pub mod data;
pub mod error;
pub mod field;
pub mod mesh;
pub mod operator;
pub mod problem;
pub mod prox;
pub mod regions;
pub mod render;
pub mod run;
#[cfg(test)]
mod samples;
pub mod segment;
pub mod solve;
pub mod solver;
pub mod start;
pub mod sweep;

pub use error::{Error, Result};
pub use mesh::Mesh;
