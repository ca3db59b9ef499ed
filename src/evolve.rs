//! Surfaces that evolve: the mesh moves so that it and its labels explain the images of calibrated cameras.
//!
//! `metric` turns a gradient into a direction of descent, `smoothing` and `remesh` keep the faces well shaped, `folds`
//! counts what should not happen, `start` makes first surfaces, and `silhouette` compares a surface with masks.

pub mod folds;
mod metric;
pub mod remesh;
pub mod silhouette;
pub mod smoothing;
pub mod start;

pub use metric::Metric;
