//! The kinds of curvature, all of the principal curvatures k1 >= k2.

use strum::{EnumString, IntoStaticStr, VariantNames};

/// A curvature of a surface at a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum CurvatureKind {
    /// H = (k1 + k2) / 2 by the cotangent Laplacian, in 1/length.
    #[default]
    Mean,
    /// H = (k1 + k2) / 2 of a quadric fitted to the vertices around, in 1/length.
    MeanQuadric,
    /// K = k1 k2 by the angle defect, in 1/length^2.
    Gaussian,
    /// S = (2 / pi) atan((k1 + k2) / (k1 - k2)) of the fitted quadric, in [-1, 1], without a unit.
    ShapeIndex,
}

impl CurvatureKind {
    /// Its name in messages and captions.
    pub fn words(self) -> &'static str {
        match self {
            CurvatureKind::Mean => "mean curvature",
            CurvatureKind::MeanQuadric => "mean curvature (quadric)",
            CurvatureKind::Gaussian => "Gaussian curvature",
            CurvatureKind::ShapeIndex => "shape index",
        }
    }

    /// n if the unit is 1/length^n.
    pub fn inverse_lengths(self) -> i32 {
        match self {
            CurvatureKind::Mean | CurvatureKind::MeanQuadric => 1,
            CurvatureKind::Gaussian => 2,
            CurvatureKind::ShapeIndex => 0,
        }
    }

    /// The sign in words, if it depends on the side of the surface.
    pub fn sign(self) -> Option<&'static str> {
        match self {
            CurvatureKind::Mean | CurvatureKind::MeanQuadric => {
                Some("positive where the surface is convex as seen from outside")
            }
            CurvatureKind::ShapeIndex => Some(
                "positive where the surface is convex as seen from outside: 1 on caps, 0.5 on ridges, 0 on saddles, \
                 -0.5 in ruts, -1 in cups",
            ),
            CurvatureKind::Gaussian => None,
        }
    }
}
