//! Texture images, and the colors they give to vertices.
//!
//! Colors are the stored sRGB values divided by their maximum, without a transfer function. Alpha is ignored with a
//! warning: an atlas stores the intended color even where it is transparent. `decode` reads images (`shrink`: large
//! ones; `upright`: rotated photos), `pyramid` halves them, `paint` assigns them to faces (`udim`: in tiles), `sample` evaluates the
//! colors of a face, and `vertices` averages those of a vertex.

mod decode;
mod paint;
mod pyramid;
mod sample;
mod shrink;
#[cfg(test)]
mod tests;
mod udim;
mod upright;
mod vertices;

pub use decode::Turn;
pub(in crate::data) use decode::{Decoded, Texels};
pub use paint::{Content, Painted, Paints, color_of_face, images, replaced};
pub use pyramid::Texture;
pub(in crate::data) use pyramid::decode_file;
pub use sample::Texel;
pub use vertices::{Sums, texels_per_face};
