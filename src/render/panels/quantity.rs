//! A quantity on a surface, in colors.

use crate::colormap::sequential;
use crate::render::layer::{Layer, Paint, UNKNOWN_COLOR, linear};
use crate::render::scene::Scene;

/// What a panel shows. Colors are sRGB in [0, 1].
pub(super) struct Quantity<'a> {
    pub values: Values<'a>,
    /// The color of the cut, if it is drawn.
    pub cut: Option<[f64; 3]>,
}

pub(super) enum Values<'a> {
    /// A color per vertex; unknown where NaN.
    Colors(&'a [[f64; 3]]),
    /// A number in [0, 1] at each vertex; unknown where NaN.
    Numbers(Box<dyn Fn(usize) -> f64 + 'a>),
    /// The region of each vertex, and a color for each region.
    Regions(Box<dyn Fn(usize) -> usize + 'a>, Vec<[f64; 3]>),
}

impl Quantity<'_> {
    /// As a layer of a picture.
    pub fn layer(&self, scene: &Scene) -> Layer {
        let paint = match &self.values {
            Values::Colors(colors) => scene.colors(colors),
            Values::Numbers(number) => scene.numbers(number),
            Values::Regions(_, colors) => Paint::regions(colors),
        };
        Layer { paint, cut: self.cut.map(linear) }
    }

    /// The color of vertex k.
    pub fn color(&self, k: usize) -> [f64; 3] {
        let color = match &self.values {
            Values::Colors(colors) => colors[k],
            Values::Numbers(number) => {
                Some(number(k)).filter(|t| !t.is_nan()).map_or([f64::NAN; 3], sequential)
            }
            Values::Regions(region, colors) => colors[region(k)],
        };
        if color.iter().any(|c| c.is_nan()) { UNKNOWN_COLOR } else { color }
    }
}
