//! The scale of the mesh to which lambda refers.

use strum::{EnumString, IntoStaticStr, VariantNames};

/// Whether a mesh is scaled to area 1, so that one lambda means the same for every mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Normalize {
    /// Area 1.
    Area,
    /// The mesh keeps its size.
    None,
}

impl Normalize {
    /// The scale factor for a mesh of the given area; 1 if the area is zero or not finite.
    pub fn scale(self, area: f64) -> f64 {
        match self {
            Normalize::Area if area > 0.0 && area.is_finite() => 1.0 / area.sqrt(),
            Normalize::Area | Normalize::None => 1.0,
        }
    }
}
