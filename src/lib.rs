//! Convex multi-region segmentation of data on triangle meshes, with certified optimality gaps.
//!
//! A mesh has V vertices and F triangles; face j has area A_j. The labels U in R^{V x m} have rows u_k in the
//! unit simplex. Delaunoy, Fundana, Prados and Heyden (*Convex Multi-Region Segmentation on Manifolds*,
//! ICCV 2009) minimize
//!
//! ```text
//! E(U) = sum_k <u_k, f_k> + lambda sum_j |(K U)_j|              (K U)_j = A_j grad_j U in R^{2 x m}
//! D(q) = sum_k min_p ( f_k + (K^T q)_k )_p,   |q_j| <= lambda   D(q) <= E* <= E(U)
//! ```
//!
//! | symbol | meaning | where |
//! |---|---|---|
//! | K, `k` | per-face gradient times area | [`operator`] |
//! | M, a_k | consistent and lumped mass | [`operator::mass`] |
//! | u, q | labels, dual field | [`field::Row`], [`field::Tangent`] |
//! | f, s | integrated and pointwise costs | [`problem`], [`data`] |
//! | mu | region parameters | [`data`] |
//! | j, k or v, p | face, vertex, region | everywhere |
//!
//! [`solve::solve`] solves one convex problem, [`segment::segment`] segments data, and [`evaluate::evaluate`] scores a
//! given U. Every solver behind them is a [`solver::Solver`], run by [`run::Run`].
//!
//! The feature `experiments` adds pictures, figures, result folders, exchange and experiments; `cli` adds the program.
//! Without it the library sets nothing process-wide, and all threads are those of [`sweep::with_threads`].

#![warn(missing_docs)]

pub mod agreement;
pub mod certificate;
pub mod classes;
#[cfg(feature = "cli")]
pub mod cli;
pub mod coarse;
pub mod colormap;
mod constant;
pub mod contour;
pub mod costs;
#[doc(hidden)]
pub mod counted;
pub mod data;
pub mod domain;
pub mod empty_regions;
pub mod error;
pub mod evaluate;
pub mod evolve;
#[cfg(feature = "experiments")]
pub mod exchange;
#[cfg(feature = "experiments")]
pub mod experiment;
pub mod field;
#[cfg(feature = "experiments")]
pub mod figure;
pub mod file;
#[cfg(feature = "experiments")]
mod font;
pub mod format_error;
#[cfg(feature = "experiments")]
pub mod labeling;
pub mod level_sets;
pub mod mesh;
pub mod names;
pub mod npy;
#[cfg(feature = "experiments")]
pub mod npz;
mod one_line;
pub mod operator;
pub mod optics;
#[cfg(feature = "experiments")]
pub mod outcome;
#[cfg(feature = "experiments")]
pub mod paper;
pub mod problem;
pub mod prox;
pub mod regions;
pub mod relaxation;
#[cfg(feature = "experiments")]
pub mod render;
pub mod request;
pub mod rounding;
pub mod run;
#[cfg(test)]
mod samples;
pub mod seeds;
pub mod segment;
pub mod solve;
pub mod solver;
pub mod start;
pub mod sweep;
mod transfer;
pub mod triple;
mod units;
mod unreached;

pub use error::{Error, Result};
pub use mesh::Mesh;

/// The examples of README.md are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
