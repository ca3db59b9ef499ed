//! Pages as PNG files with their resolution (the chunk pHYs), so that they are placed in their size.

use image::{RgbImage, RgbaImage};

use super::page::DOTS_PER_INCH;
use crate::error::{Error, Result};

pub(super) enum Page {
    White(RgbImage),
    Transparent(RgbaImage),
}

/// The bytes of the file. Fails if there is no room for them.
pub(super) fn encoded(page: &Page) -> Result<Vec<u8>> {
    let (pixels, width, height, kind) = match page {
        Page::White(image) => (image.as_raw(), image.width(), image.height(), png::ColorType::Rgb),
        Page::Transparent(image) => {
            (image.as_raw(), image.width(), image.height(), png::ColorType::Rgba)
        }
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(kind);
    encoder.set_compression(png::Compression::Best);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let dots_per_meter = (DOTS_PER_INCH / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: dots_per_meter,
        yppu: dots_per_meter,
        unit: png::Unit::Meter,
    }));
    let write = |encoder: png::Encoder<_>| {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(pixels)?;
        writer.finish()
    };
    write(encoder).map_err(|error: png::EncodingError| Error::unsuitable(error.to_string()))?;
    Ok(bytes)
}
