//! What a camera sees of a mesh: the face at each sample of every pixel, and which vertices are hidden.
//!
//! A separate layer, for anything that views surfaces: pictures, and data taken from images.

pub mod bands;
pub mod camera;
pub mod visibility;
