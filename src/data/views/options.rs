//! Which pixels of views count, and how much.

use std::path::PathBuf;

use strum::{EnumString, IntoStaticStr, VariantNames};

/// omega, what a pixel weighs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum PixelWeights {
    /// 1: all pixels are equal evidence. The default.
    #[default]
    Pixel,
    /// 1 / det K, the area of a pixel on the normalized image plane: cameras of different focal lengths are equal
    /// evidence.
    Angle,
    /// The weights of all vertices that are seen are their areas: the mean color of its pixels is the evidence of a
    /// vertex, however many there are.
    Unit,
}

/// How images of calibrated cameras become data.
#[derive(Clone, Debug)]
pub struct ViewOptions {
    /// The folder of the images, if they are not next to the file of the views.
    pub images: Option<PathBuf>,
    /// What a pixel weighs.
    pub weights: PixelWeights,
    /// S: a pixel has S x S samples, at least 1.
    pub samples: usize,
    /// R: a pixel counts if the surface is at every sample of the R - 1 rings of pixels around it, without a jump of
    /// depth; 1 for no such test.
    pub pure: usize,
    /// A sample counts if the cosine of the angle between its ray and the normal is at least this.
    pub grazing: f64,
    /// Pixels at each border of the image that do not count.
    pub border: usize,
}

impl Default for ViewOptions {
    fn default() -> Self {
        ViewOptions {
            images: None,
            weights: PixelWeights::default(),
            samples: 1,
            pure: 1,
            grazing: 0.0,
            border: 0,
        }
    }
}
