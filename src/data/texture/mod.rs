//! Texture images, and the colors they give to vertices.
//!
//! Colors are the stored sRGB values divided by their maximum, without any transfer function; alpha is ignored with a warning,
//! since what an atlas stores below it is the color that was meant. An image is read in `decode` (`shrink`: too
//! large ones; `upright`: photos that were stored turned), a face finds its colors in `sample`, which image it has says `paint`, and `vertices` adds up.

mod decode;
mod paint;
mod pyramid;
mod sample;
mod shrink;
#[cfg(test)]
mod tests;
mod upright;
mod vertices;

pub use decode::Turn;
pub use paint::{Content, Painted, Paints, color_of_face, images, is_same_image};
pub use pyramid::Texture;
pub use sample::Texel;
pub use vertices::{Sums, texels_a_face};
