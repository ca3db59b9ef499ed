//! Texture images, and the colors they give to vertices.
//!
//! A texture covers [0, 1]^2, repeated over the plane; v points upwards (the convention of OBJ), so the
//! image's first row lies at v = 1. Texel (i, row) of an N x H image is centered at
//! ((i + 1/2) / N, 1 - (row + 1/2) / H), and between the centers colors are bilinear. Colors are the stored
//! sRGB values divided by their maximum, without any transfer function; alpha is ignored, since what an
//! atlas stores below it is the color that was meant.

use std::io::Cursor;
use std::path::Path;

use image::error::{ImageError, LimitErrorKind};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, ImageResult, Limits, Rgb};

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::Mesh;

/// Limits against images that unpack to far more than they are: each bounds the memory by some 600 MB.
const MAX_FILE_BYTES: u64 = 1 << 28;
const MAX_PIXELS: u64 = 1 << 26;

/// The color of what no texture covers.
const MID_GRAY: [f64; 3] = [0.5; 3];

/// A decoded image. Gray and 8-bit images are widened, which keeps their values in [0, 1].
pub struct Texture {
    texels: image::ImageBuffer<Rgb<u16>, Vec<u16>>,
}

impl Texture {
    /// Reads a PNG or JPEG file; its content decides which, not its name.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = file::read(path)?;
        Texture::decode(&bytes, path)
    }

    /// Decodes the content of a PNG or JPEG file; `name` is for the errors.
    pub fn decode(bytes: &[u8], name: &Path) -> Result<Self> {
        let malformed = |message: String| Error::malformed(name, message);
        if bytes.is_empty() {
            return Err(malformed("is empty; a PNG or JPEG image is needed".into()));
        }
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(malformed("is larger than 256 MiB".into()));
        }
        let format = match image::guess_format(bytes) {
            Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
            _ => return Err(malformed("is neither a PNG nor a JPEG image".into())),
        };
        match decode_within_limits(bytes, format) {
            Ok(Some(image)) => Ok(Texture { texels: image.into_rgb16() }),
            Ok(None) => Err(malformed("the image has no pixels".into())),
            Err(ImageError::Limits(error))
                if !matches!(error.kind(), LimitErrorKind::Unsupported { .. }) =>
            {
                let message = "the image is too large; shrink it below 64 megapixels";
                Err(malformed(message.into()))
            }
            Err(error) => {
                let reason = error.to_string().replace(['\n', '\r'], " ");
                Err(malformed(format!("cannot decode the image: {reason}")))
            }
        }
    }

    /// The RGB color in [0, 1] at texture coordinates (u, v), which must be finite.
    pub fn sample(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let (width, height) = self.texels.dimensions();
        let (i, s) = split(u, width);
        let (row, t) = split(1.0 - v, height);
        let texel = |i: u32, row: u32| {
            let Rgb(values) = self.texels.get_pixel(i % width, row % height);
            values.map(|value| f64::from(value) / f64::from(u16::MAX))
        };
        let (a, b) = (texel(i, row), texel(i + 1, row));
        let (c, d) = (texel(i, row + 1), texel(i + 1, row + 1));
        [0, 1, 2].map(|p| {
            let upper = a[p] + s * (b[p] - a[p]);
            let lower = c[p] + s * (d[p] - c[p]);
            upper + t * (lower - upper)
        })
    }
}

/// Where a repeated coordinate lies among n texel centers: the one before it, and the fraction to the next.
fn split(coordinate: f64, n: u32) -> (u32, f64) {
    let position = (coordinate.rem_euclid(1.0) * f64::from(n) - 0.5).rem_euclid(f64::from(n));
    let before = (position as u32).min(n - 1);
    (before, position - f64::from(before))
}

fn decode_within_limits(bytes: &[u8], format: ImageFormat) -> ImageResult<Option<DynamicImage>> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(8 * MAX_PIXELS);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        let kind = LimitErrorKind::DimensionError;
        return Err(ImageError::Limits(image::error::LimitError::from_kind(kind)));
    }
    if width == 0 || height == 0 {
        return Ok(None);
    }
    DynamicImage::from_decoder(decoder).map(Some)
}

/// The texture's color at the V vertices: every corner is sampled at its own coordinates, and a vertex takes
/// the mean of its corners weighted by the areas of their faces, so that seams split no vertex. Vertices
/// without area get mid gray.
///
/// Fails if the mesh has no texture coordinates, or some that are not finite.
pub fn colors_at_vertices(mesh: &Mesh, texture: &Texture) -> Result<Vec<[f64; 3]>> {
    let uv = mesh.uv.as_ref().ok_or_else(|| {
        Error::unsuitable(
            "the mesh has no texture coordinates; only an OBJ file with vt lines takes a texture",
        )
    })?;
    assert_eq!(uv.len(), mesh.faces.len());
    let mut sums = vec![[0.0; 3]; mesh.vertices.len()];
    let mut areas = vec![0.0; mesh.vertices.len()];
    for (j, (face, coordinates)) in mesh.faces.iter().zip(uv).enumerate() {
        if coordinates.iter().flatten().any(|c| !c.is_finite()) {
            return Err(Error::unsuitable(format!(
                "face {} has a texture coordinate that is not finite",
                j + 1
            )));
        }
        let area = mesh.face_area(j);
        for (&k, &corner) in face.iter().zip(coordinates) {
            let color = texture.sample(corner);
            for (sum, value) in sums[k as usize].iter_mut().zip(color) {
                *sum += area * value;
            }
            areas[k as usize] += area;
        }
    }
    let mean = |(sum, &area): (&[f64; 3], &f64)| {
        if area > 0.0 { sum.map(|value| (value / area).min(1.0)) } else { MID_GRAY }
    };
    Ok(sums.iter().zip(&areas).map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, Luma, RgbImage, Rgba, RgbaImage};
    use nalgebra::Point3;

    fn encode(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn texture(image: impl Into<DynamicImage>) -> Texture {
        Texture::decode(&encode(image, ImageFormat::Png), Path::new("t.png")).unwrap()
    }

    /// 2 x 2: red, green above blue, white.
    fn four() -> Texture {
        let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
        texture(RgbImage::from_raw(2, 2, texels.concat()).unwrap())
    }

    fn error(bytes: &[u8]) -> String {
        let message = Texture::decode(bytes, Path::new("t.png")).err().unwrap().to_string();
        assert!(message.starts_with("t.png: ") && !message.contains('\n'));
        message
    }

    #[test]
    fn texel_centers_return_their_texels_and_v_points_up() {
        let texture = four();
        assert_eq!(texture.sample([0.25, 0.75]), [1.0, 0.0, 0.0]);
        assert_eq!(texture.sample([0.75, 0.75]), [0.0, 1.0, 0.0]);
        assert_eq!(texture.sample([0.25, 0.25]), [0.0, 0.0, 1.0]);
        assert_eq!(texture.sample([0.75, 0.25]), [1.0, 1.0, 1.0]);
    }

    #[test]
    fn between_the_centers_colors_are_bilinear_and_the_plane_is_periodic() {
        let texture = four();
        for uv in [[0.5, 0.5], [0.0, 0.0], [1.0, 1.0]] {
            assert_eq!(texture.sample(uv), [0.5; 3]);
        }
        for uv in [[0.3, 0.9], [-0.1, 0.4], [0.99, 0.01]] {
            let shifted = texture.sample([uv[0] + 3.0, uv[1] - 2.0]);
            for (a, b) in texture.sample(uv).iter().zip(shifted) {
                assert!((a - b).abs() < 1e-12);
            }
        }
        assert!(texture.sample([-1e-300, -1e-300])[0].is_finite());
        assert!(texture.sample([1e300, -1e300])[0].is_finite());
    }

    #[test]
    fn gray_deep_and_transparent_images_keep_their_values() {
        let gray = texture(GrayImage::from_pixel(3, 1, Luma([51])));
        assert_eq!(gray.sample([0.4, 0.2]), [0.2; 3]);
        let deep: ImageBuffer<Rgb<u16>, _> = ImageBuffer::from_pixel(1, 1, Rgb([1, 0, 65535]));
        assert_eq!(texture(deep).sample([0.0, 0.0]), [1.0 / 65535.0, 0.0, 1.0]);
        let clear = RgbaImage::from_pixel(2, 2, Rgba([255, 51, 0, 0]));
        assert_eq!(texture(clear).sample([0.1, 0.1]), [1.0, 0.2, 0.0]);
    }

    #[test]
    fn jpeg_is_read_too() {
        let bytes = encode(RgbImage::from_pixel(16, 16, Rgb([128; 3])), ImageFormat::Jpeg);
        let color = Texture::decode(&bytes, Path::new("t.jpg")).unwrap().sample([0.5, 0.5]);
        assert!(color.iter().all(|c| (c - 0.5).abs() < 0.02));
    }

    #[test]
    fn what_is_no_image_is_one_clear_line() {
        assert!(error(b"").contains("is empty"));
        assert!(error(b"solid cube").contains("neither"));
        assert!(error(b"GIF89a0000000000").contains("neither"));
        let png = encode(RgbImage::new(64, 64), ImageFormat::Png);
        let jpeg = encode(RgbImage::new(64, 64), ImageFormat::Jpeg);
        for cut in [8, 20, 40, png.len() / 2] {
            assert!(error(&png[..cut]).contains("cannot decode"));
        }
        assert!(error(&jpeg[..20]).contains("cannot decode"));
        let folder = Texture::open(Path::new(".")).err().unwrap().to_string();
        assert!(!folder.contains('\n'));
        let missing = Texture::open(Path::new("no-such.png")).err().unwrap();
        assert!(missing.to_string().starts_with("no-such.png: "));
    }

    #[test]
    fn a_header_that_promises_gigapixels_is_refused() {
        let mut png = encode(RgbImage::new(1, 1), ImageFormat::Png);
        let ihdr = 12..29;
        png[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 0, 0x80, 0]);
        let checksum = crc(&png[ihdr.clone()]);
        png[ihdr.end..ihdr.end + 4].copy_from_slice(&checksum.to_be_bytes());
        assert!(error(&png).contains("too large"));
    }

    /// CRC-32 of a PNG chunk.
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |mut c: u32, &byte| {
            c ^= u32::from(byte);
            for _ in 0..8 {
                c = if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
            }
            c
        })
    }

    #[test]
    fn a_seam_averages_its_sides_by_area() {
        let corners =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -3.0, 0.0], [9.0, 9.0, 9.0]];
        let mut mesh = Mesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [0, 3, 1]]);
        let texture = four();
        assert!(colors_at_vertices(&mesh, &texture).is_err());
        mesh.uv = Some(vec![[[0.25, 0.75]; 3], [[0.75, 0.75]; 3]]);
        let colors = colors_at_vertices(&mesh, &texture).unwrap();
        assert_eq!(colors[2], [1.0, 0.0, 0.0]);
        assert_eq!(colors[3], [0.0, 1.0, 0.0]);
        assert_eq!(colors[0], [0.25, 0.75, 0.0]);
        assert_eq!(colors[4], MID_GRAY);
        mesh.uv = Some(vec![[[f64::NAN; 2]; 3]; 2]);
        assert!(colors_at_vertices(&mesh, &texture).is_err());
    }
}
