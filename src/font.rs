//! The one font of figures and pictures: Source Sans 3, SIL Open Font License 1.1. Nothing depends on the fonts of
//! the machine.

use std::sync::LazyLock;

use rustybuzz::{Face, GlyphBuffer, UnicodeBuffer};

pub static BYTES: &[u8] = include_bytes!("../assets/fonts/SourceSans3-Regular.ttf");
pub const FAMILY: &str = "Source Sans 3";

pub(crate) static FACE: LazyLock<Face<'static>> =
    LazyLock::new(|| Face::from_slice(BYTES, 0).expect("the bundled font is a font"));

/// The glyphs of a line, with kerning and ligatures, in units of the font.
pub(crate) fn shape(text: &str) -> GlyphBuffer {
    let mut buffer = UnicodeBuffer::new();
    buffer.push_str(text);
    rustybuzz::shape(&FACE, &[], buffer)
}

/// The width of a line as it is shown.
pub fn width(text: &str, size: f64) -> f64 {
    let glyphs = shape(text);
    let advance: i64 =
        glyphs.glyph_positions().iter().map(|glyph| i64::from(glyph.x_advance)).sum();
    advance as f64 * scale(size)
}

/// The length of a unit of the font at a size.
pub(crate) fn scale(size: f64) -> f64 {
    size / f64::from(FACE.units_per_em())
}
