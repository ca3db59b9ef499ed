//! Convex multi-region segmentation of data on triangle meshes.

pub mod data;
pub mod error;
pub mod evaluate;
pub mod field;
pub mod file;
pub mod mesh;
pub mod npy;
pub mod operator;
pub mod outcome;
pub mod problem;
pub mod prox;
pub mod regions;
pub mod render;
pub mod run;
pub mod segment;
pub mod solve;
pub mod solver;
pub mod start;
pub mod sweep;

pub use error::{Error, Result};
pub use mesh::Mesh;
