//! PNG and JPEG files as texels of three channels.
//!
//! Images are shrunk while they are decoded, by the smallest 2^k that brings them to at most [`MAX_BYTES`]: PNG images
//! are read row by row, and of JPEG images only the low frequencies are transformed back, which approximates the means
//! of boxes. Gray and palette images are expanded, alpha is dropped with a warning if any pixel is not opaque, and 16
//! bits are kept. The EXIF orientation of a JPEG image is applied to photos and ignored for textures, whose coordinates
//! refer to the pixels as stored (as in glTF and in mesh viewers). A header is trusted only if the file can hold what
//! it declares: deflate compresses 1032 : 1 at best, and JPEG needs at least one bit per block.

use std::io::{BufRead, Cursor};
use std::path::Path;

use image::codecs::jpeg::JpegDecoder;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder};
use jpeg_decoder::PixelFormat;
use png::{BitDepth, Transformations};

use super::shrink::{Channel, Shrink};
use super::upright::Upright;
use crate::error::{Error, Result};

/// Memory for the texels of an image: 2^26 pixels of 8 bits.
const MAX_BYTES: u64 = 3 << 26;

/// Larger images are refused.
const MAX_PIXELS: u64 = 1 << 32;

/// Limits for images that must be in memory as a whole: interlaced PNG images, the coefficients of progressive JPEG
/// images.
const MAX_PIXELS_INTERLACED: u64 = 1 << 26;
const MAX_PIXELS_PROGRESSIVE: u64 = 1 << 26;

/// Upper bounds on what a byte of a file can hold: bytes of a PNG image, pixels of a JPEG image.
const MAX_DEFLATED: u64 = 1040;
const MAX_PIXELS_PER_BYTE: u64 = 2048;

/// The texels of an image, row by row from the upper left corner.
pub enum Texels {
    Eight(Vec<[u8; 3]>),
    Sixteen(Vec<[u16; 3]>),
}

/// The orientation in which an image is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// The EXIF orientation is ignored.
    AsStored,
    /// The EXIF orientation is applied.
    Upright,
    /// The EXIF orientation is ignored without a warning: cameras are calibrated for the pixels as stored.
    Calibrated,
}

pub struct Decoded {
    /// The size of the image in the file, after the orientation is applied.
    pub width: u32,
    pub height: u32,
    /// The texels are means of 2^k x 2^k pixels.
    pub k: u32,
    pub texels: Texels,
}

/// Decodes a PNG file of the given length; `name` is for error messages.
pub fn png(file: impl BufRead, length: u64, name: &Path) -> Result<Decoded> {
    let failed = |error: png::DecodingError| cannot_decode(name, &error);
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(failed)?;
    let info = reader.info();
    let (width, height) = info.size();
    let pixels = check_size(width, height, name)?;
    let packed = info.raw_row_length() as u64 * u64::from(height);
    if packed > MAX_DEFLATED.saturating_mul(length) {
        return Err(declares_too_much(width, height, length, name));
    }
    let interlaced = info.interlaced;
    if interlaced && pixels > MAX_PIXELS_INTERLACED {
        let message = "save it without interlacing, which can be read row by row";
        return Err(too_large(width, height, message, name));
    }
    let (color, depth) = reader.output_color_type();
    let channels = color.samples();
    let deep = depth == BitDepth::Sixteen;
    let k = shrinking(pixels * if deep { 6 } else { 3 });
    let mut rows = Rows::new(width, height, k, deep, channels);
    let pixel = channels * if deep { 2 } else { 1 };
    let has_alpha = matches!(color, png::ColorType::GrayscaleAlpha | png::ColorType::Rgba);
    let alpha = if has_alpha { pixel / channels } else { 0 };
    let mut transparent = 0;
    let mut push = |row: &[u8]| {
        transparent += hidden(row, pixel, alpha);
        rows.push(row);
    };
    if interlaced {
        let mut whole = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut whole).map_err(failed)?;
        whole.chunks(reader.output_line_size(width)).for_each(push);
    } else {
        while let Some(row) = reader.next_row().map_err(failed)? {
            push(row.data());
        }
    }
    if transparent > 0 {
        tracing::warn!(
            "{}: {transparent} of {pixels} pixels are fully or partly transparent; transparency is ignored",
            name.display()
        );
    }
    Ok(Decoded { width, height, k, texels: rows.finish() })
}

/// The number of pixels of a row that are not opaque. Each has `pixel` bytes, of which the last `alpha` are the alpha
/// channel.
fn hidden(row: &[u8], pixel: usize, alpha: usize) -> u64 {
    if alpha == 0 {
        return 0;
    }
    let is_hidden = |pixel: &[u8]| pixel[pixel.len() - alpha..].iter().any(|&byte| byte != u8::MAX);
    row.chunks_exact(pixel).filter(|pixel| is_hidden(pixel)).count() as u64
}

/// Decodes a JPEG file; `name` is for error messages.
pub fn jpeg(bytes: &[u8], name: &Path, turn: Turn) -> Result<Decoded> {
    let failed = |error: image::ImageError| cannot_decode(name, &error);
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let pixels = check_size(width, height, name)?;
    if pixels > MAX_PIXELS_PER_BYTE.saturating_mul(bytes.len() as u64) {
        return Err(declares_too_much(width, height, bytes.len() as u64, name));
    }
    if pixels > MAX_PIXELS_PROGRESSIVE && is_progressive(bytes) {
        let message = "save it as baseline JPEG or as PNG, which can be read row by row";
        return Err(too_large(width, height, message, name));
    }
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::La8 => 2,
        ColorType::Rgba8 => 4,
        _ => 3,
    };
    let orientation = match (decoder.orientation().map_err(failed)?, turn) {
        (Orientation::NoTransforms, _) => Orientation::NoTransforms,
        (orientation, Turn::Upright) => orientation,
        (_, Turn::Calibrated) => Orientation::NoTransforms,
        (_, Turn::AsStored) => {
            tracing::warn!(
                "{}: its EXIF orientation is ignored, because textures are used as stored; --data image:FILE turns \
                 photos upright",
                name.display()
            );
            Orientation::NoTransforms
        }
    };
    let k = shrinking(3 * pixels);
    let (stored, channels) = if k == 0 {
        let mut whole = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut whole).map_err(failed)?;
        (whole, channels)
    } else {
        low_frequencies(bytes, [width, height], k, name)?
    };
    let [columns, rows] = [width, height].map(|length| length.div_ceil(1 << k));
    let shrunk = Upright { width: columns, height: rows, orientation };
    let (columns, rows) = shrunk.size();
    let mut texels = Rows::new(columns, rows, 0, false, channels);
    shrunk.rows(&stored, channels, |row| texels.push(row));
    let (width, height) = Upright { width, height, orientation }.size();
    Ok(Decoded { width, height, k, texels: texels.finish() })
}

/// A JPEG image at 2^-k of its size, 1 <= k <= 3, from the lowest (8 / 2^k)^2 frequencies of each block, and its number
/// of channels.
fn low_frequencies(bytes: &[u8], size: [u32; 2], k: u32, name: &Path) -> Result<(Vec<u8>, usize)> {
    let failed = |error: jpeg_decoder::Error| cannot_decode(name, &error);
    let mut decoder = jpeg_decoder::Decoder::new(bytes);
    let [width, height] = size.map(|length| length.div_ceil(1 << k) as u16);
    let scaled = decoder.scale(width, height).map_err(failed)?;
    assert_eq!(scaled, (width, height), "a block has 8 x 8 pixels");
    let channels = match decoder.info().map(|info| info.pixel_format) {
        Some(PixelFormat::L8) => 1,
        Some(PixelFormat::RGB24) => 3,
        _ => return Err(too_large(size[0], size[1], "save it as RGB instead of CMYK", name)),
    };
    Ok((decoder.decode().map_err(failed)?, channels))
}

/// Whether a JPEG image is progressive, so that all its coefficients must be in memory at once.
fn is_progressive(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, marker, high, low]) = bytes.get(at..at + 4) {
        match marker {
            // Start of frame: baseline, extended, progressive and others; the excluded markers in this range are
            // tables.
            0xc2 | 0xc6 | 0xca | 0xce => return true,
            0xc0 | 0xc1 | 0xda => return false,
            0xff => at += 1,
            _ => at += 2 + usize::from(u16::from_be_bytes([high, low])),
        }
    }
    false
}

fn check_size(width: u32, height: u32, name: &Path) -> Result<u64> {
    let pixels = u64::from(width) * u64::from(height);
    match pixels {
        0 => Err(Error::malformed(name, "the image has no pixels")),
        1..=MAX_PIXELS => Ok(pixels),
        _ => Err(too_large(width, height, "shrink it", name)),
    }
}

fn too_large(width: u32, height: u32, what_to_do: &str, name: &Path) -> Error {
    Error::malformed(
        name,
        format!("the image of {width} x {height} pixels is too large; {what_to_do}"),
    )
}

fn declares_too_much(width: u32, height: u32, length: u64, name: &Path) -> Error {
    Error::malformed(
        name,
        format!(
            "is damaged: it declares {width} x {height} pixels, too many for its {length} bytes; save it again"
        ),
    )
}

fn cannot_decode(name: &Path, error: &dyn std::fmt::Display) -> Error {
    let reason = error.to_string().replace(['\n', '\r'], " ");
    Error::malformed(name, format!("cannot decode the image: {reason}"))
}

/// The smallest k for which an image of that many bytes fits after averaging over boxes of 2^k x 2^k pixels.
fn shrinking(bytes: u64) -> u32 {
    (0..).find(|k| bytes >> (2 * k) <= MAX_BYTES).unwrap_or_default()
}

/// Rows of bytes as texels.
enum Rows {
    Eight(Shrink<u8>, usize),
    Sixteen(Shrink<u16>, usize),
}

impl Rows {
    fn new(width: u32, height: u32, k: u32, deep: bool, channels: usize) -> Self {
        if deep {
            Rows::Sixteen(Shrink::new(width, height, k), channels)
        } else {
            Rows::Eight(Shrink::new(width, height, k), channels)
        }
    }

    fn push(&mut self, row: &[u8]) {
        match self {
            Rows::Eight(shrink, 3) => {
                shrink.push(row.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
            }
            Rows::Eight(shrink, channels) => {
                shrink.push(row.chunks_exact(*channels).map(|c| rgb(c, |c, i| c[i])));
            }
            Rows::Sixteen(shrink, channels) => {
                let value = |c: &[u8], i: usize| u16::from_be_bytes([c[2 * i], c[2 * i + 1]]);
                shrink.push(row.chunks_exact(2 * *channels).map(|c| rgb(c, value)));
            }
        }
        /// The color of a pixel with 1 (gray), 2 (and alpha), 3 or 4 channels.
        fn rgb<T: Channel>(pixel: &[u8], value: impl Fn(&[u8], usize) -> T) -> [T; 3] {
            let channels = pixel.len() / size_of::<T>();
            if channels < 3 { [value(pixel, 0); 3] } else { [0, 1, 2].map(|i| value(pixel, i)) }
        }
    }

    fn finish(self) -> Texels {
        match self {
            Rows::Eight(shrink, _) => Texels::Eight(shrink.finish()),
            Rows::Sixteen(shrink, _) => Texels::Sixteen(shrink.finish()),
        }
    }
}
