//! Surfaces that evolve until they look like their images.
#![allow(dead_code)]

mod area;
mod bins;
mod coloring;
mod contour;
mod covered;
mod edges;
mod energy;
pub mod images;
mod interior;
mod length;
mod lit;
mod roughness;
mod scene;
mod statistics;

#[cfg(test)]
mod tests;
