//! Layers: what the pictures of one view show on the surface. Colors are in linear light.

use std::sync::LazyLock;

use nalgebra::Vector3;

use super::shading::linear_from_srgb;
use crate::colormap::sequential;

/// The color of the cut between regions in the colors of the palette, sRGB: darker than any region.
pub(super) const CUT_COLOR: [f64; 3] = [0.09, 0.09, 0.11];
/// The color of the cut on data and on mean colors, sRGB.
pub(super) const RED: [f64; 3] = [0.9, 0.0, 0.0];
/// The color of vertices without data, sRGB.
pub(super) const UNKNOWN_COLOR: [f64; 3] = [0.72; 3];

/// The colors of the surface, and of the cut if it is drawn.
pub(super) struct Layer {
    pub paint: Paint,
    pub cut: Option<Vector3<f32>>,
}

/// The colors of the surface.
pub(super) enum Paint {
    /// A color at each vertex, interpolated.
    Colors(Vec<Vector3<f32>>),
    /// A number in [0, 1] at each vertex, interpolated and then mapped to a color; NaN is unknown.
    Numbers(Vec<f32>),
    /// The color of each region.
    Regions(Vec<Vector3<f32>>),
}

impl Paint {
    pub fn regions(colors: &[[f64; 3]]) -> Self {
        Paint::Regions(colors.iter().copied().map(linear).collect())
    }
}

/// A layer's values at the corners of the visible faces, each contiguous in memory.
pub(super) enum Corners<'a> {
    Colors(Vec<[Vector3<f32>; 3]>),
    Numbers(Vec<[f32; 3]>),
    Regions(&'a [Vector3<f32>]),
}

pub(super) fn linear(color: [f64; 3]) -> Vector3<f32> {
    linear_from_srgb(color).into()
}

/// The color of a vertex; gray where it is NaN.
pub(super) fn linear_or_unknown(color: [f64; 3]) -> Vector3<f32> {
    let known = color.iter().all(|c| !c.is_nan());
    linear(if known { color } else { UNKNOWN_COLOR })
}

/// Steps of the color map.
const STEPS: usize = 1024;

static COLOR_MAP: LazyLock<Vec<Vector3<f32>>> =
    LazyLock::new(|| (0..=STEPS).map(|i| linear(sequential(i as f64 / STEPS as f64))).collect());

/// The color of a number in [0, 1], as [`sequential`] but for the unknown, which is gray.
#[inline(always)]
pub(super) fn mapped(t: f32) -> Vector3<f32> {
    if t.is_nan() {
        return linear(UNKNOWN_COLOR);
    }
    COLOR_MAP[(t.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize]
}
