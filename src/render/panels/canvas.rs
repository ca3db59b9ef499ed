//! The page: pixels with straight alpha, on which pictures, texts and color bars are put.
//!
//! Colors are mixed as every viewer mixes a transparent picture with its background, on the sRGB values. A white
//! page is the transparent one on white, so that both look the same on white paper.

use image::{RgbImage, RgbaImage};

use crate::render::text::{self, Direction};

pub(super) struct Canvas(RgbaImage);

impl Canvas {
    pub fn new(width: usize, height: usize) -> Self {
        Canvas(RgbaImage::from_pixel(width as u32, height as u32, image::Rgba([255, 255, 255, 0])))
    }

    /// The pixels, transparent where there is nothing.
    pub fn transparent(self) -> RgbaImage {
        self.0
    }

    /// The pixels on white.
    pub fn on_white(&self) -> RgbImage {
        let mut page = RgbImage::new(self.0.width(), self.0.height());
        for (to, from) in page.chunks_exact_mut(3).zip(self.0.chunks_exact(4)) {
            let alpha = u32::from(from[3]);
            for (to, &c) in to.iter_mut().zip(from) {
                *to = ((u32::from(c) * alpha + 255 * (255 - alpha) + 127) / 255) as u8;
            }
        }
        page
    }

    /// Puts a picture on the page where that is empty.
    pub fn picture(&mut self, picture: &RgbaImage, [left, top]: [usize; 2]) {
        let (length, stride) = (4 * picture.width() as usize, 4 * self.0.width() as usize);
        let rows = self.0.chunks_exact_mut(stride).skip(top);
        for (to, from) in rows.zip(picture.chunks_exact(length)) {
            to[4 * left..][..length].copy_from_slice(from);
        }
    }

    /// Fills the pixels of a rectangle, as far as it lies on the page.
    pub fn rectangle(
        &mut self,
        [left, top]: [usize; 2],
        [width, height]: [usize; 2],
        color: [f64; 3],
    ) {
        let [r, g, b] = color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8);
        let (right, bottom) = (left + width, top + height);
        for y in top..bottom.min(self.0.height() as usize) {
            for x in left..right.min(self.0.width() as usize) {
                self.0.put_pixel(x as u32, y as u32, image::Rgba([r, g, b, 255]));
            }
        }
    }

    /// Writes a line of text from the start of its baseline.
    pub fn text(&mut self, text: &str, start: [f64; 2], size: f64, direction: Direction) {
        let extent = [self.0.width() as usize, self.0.height() as usize];
        let page = &mut self.0;
        text::cover(text, start, size, direction, extent, |[x, y], coverage| {
            let image::Rgba(pixel) = page.get_pixel_mut(x as u32, y as u32);
            let below = f64::from(pixel[3]) / 255.0 * (1.0 - coverage);
            let alpha = coverage + below;
            for c in &mut pixel[..3] {
                *c = ((255.0 * text::INK * coverage + f64::from(*c) * below) / alpha).round() as u8;
            }
            pixel[3] = (255.0 * alpha).round() as u8;
        });
    }
}
