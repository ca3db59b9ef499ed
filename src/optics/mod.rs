//! What a camera sees of a mesh: which face each sample of every pixel shows, which vertices are hidden.
//!
//! Below whatever looks at surfaces: pictures, and data that images show.

pub mod bands;
pub mod camera;
pub mod visibility;
