//! The appearance of a region.

#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    pub color: [f64; 3],
    /// Its mean in the colors of the data, if it has one.
    pub mean: Option<[f64; 3]>,
    /// Its text in the legend.
    pub text: String,
}
