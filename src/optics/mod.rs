//! What a camera sees of a mesh: the face at each sample of every pixel, and which vertices are hidden.
//!
//! A separate layer, for anything that views surfaces: pictures (`camera`, `visibility`), and data taken from images of
//! calibrated cameras (`pinhole`, `zbuffer`).

#[cfg(feature = "experiments")]
pub(crate) mod bands;
#[cfg(feature = "experiments")]
pub(crate) mod camera;
pub(crate) mod edge;
pub mod pinhole;
#[cfg(feature = "experiments")]
pub(crate) mod visibility;
pub(crate) mod zbuffer;
