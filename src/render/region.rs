//! The appearance of a region.

/// The color of a region, and what the legend says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// sRGB in [0, 1].
    pub color: [f64; 3],
    /// Its mean in the colors of the data, if it has one.
    pub mean: Option<[f64; 3]>,
    /// Its text in the legend.
    pub text: String,
}
