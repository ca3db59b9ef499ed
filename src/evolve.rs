//! Surfaces that evolve until they look like their images.
#![allow(dead_code)]

mod area;
mod bins;
mod coloring;
mod contour;
mod covered;
mod edges;
mod energy;
pub mod folds;
pub mod images;
mod interior;
mod length;
mod lit;
mod metric;
pub mod remesh;
mod roughness;
mod scene;
pub mod silhouette;
pub mod smoothing;
pub mod start;
mod statistics;

pub use metric::Metric;

#[cfg(test)]
mod tests;
