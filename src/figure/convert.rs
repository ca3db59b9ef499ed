//! From SVG to PNG and PDF, with the bundled font only.

use std::sync::Arc;

use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use svg2pdf::{ConversionOptions, PageOptions};

use super::{Result, unsuitable};
use crate::font;

const DOTS_PER_INCH: f64 = 300.0;

/// Parses the SVG. The unit of length is a point.
pub fn tree(svg: &str) -> Result<Tree> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(font::BYTES.to_vec());
    fonts.set_sans_serif_family(font::FAMILY);
    let options = Options { dpi: 72.0, fontdb: Arc::new(fonts), ..Options::default() };
    Tree::from_str(svg, &options).map_err(unsuitable)
}

pub fn png(tree: &Tree) -> Result<Vec<u8>> {
    let scale = (DOTS_PER_INCH / 72.0) as f32;
    let dots = |points: f32| (points * scale).round() as u32;
    let (width, height) = (dots(tree.size().width()), dots(tree.size().height()));
    let mut pixels =
        Pixmap::new(width, height).ok_or_else(|| unsuitable("it is too high for an image"))?;
    // The page may cover the last row only partially.
    pixels.fill(Color::WHITE);
    resvg::render(tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    let colors: Vec<u8> =
        pixels.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let dots_per_meter = (DOTS_PER_INCH / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: dots_per_meter,
        yppu: dots_per_meter,
        unit: png::Unit::Meter,
    }));
    let write = |encoder: png::Encoder<_>| {
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&colors)?;
        writer.finish()
    };
    write(encoder).map_err(unsuitable)?;
    Ok(bytes)
}

pub fn pdf(tree: &Tree) -> Result<Vec<u8>> {
    let mut pdf = svg2pdf::to_pdf(tree, ConversionOptions::default(), PageOptions::default())
        .map_err(unsuitable)?;
    sort_transparencies(&mut pdf);
    Ok(pdf)
}

/// Sorts the transparencies of the page, which svg2pdf lists one per line in the random order of a hash map.
fn sort_transparencies(pdf: &mut [u8]) {
    let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what);
    let head = b"/ExtGState <<\n";
    let Some(begin) = find(pdf, head).map(|at| at + head.len()) else { return };
    let Some(length) = find(&pdf[begin..], b">>") else { return };
    let list = &mut pdf[begin..begin + length];
    let mut lines: Vec<&[u8]> = list.split_inclusive(|&byte| byte == b'\n').collect();
    // The text before the closing brackets is not an entry.
    let entries = lines.len().saturating_sub(1);
    lines[..entries].sort_unstable();
    let sorted = lines.concat();
    list.copy_from_slice(&sorted);
}
