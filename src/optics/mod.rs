//! What a camera sees of a mesh: which face each sample of every pixel shows, which vertices are hidden.
//!
//! Below whatever looks at surfaces: pictures, and data that images show.

pub(crate) mod bands;
pub(crate) mod camera;
pub(crate) mod visibility;
