//! What is written around the picture: a caption above each half, and below what each region is: its color, its mean
//! in the colors of the data, and words.

use image::{Rgb, RgbImage};

use super::{Region, text};
use crate::font::width;

/// The height of the captions.
pub(super) const CAPTION: usize = 38;
const SIZE: f64 = 18.0;
/// From one line of the legend to the next.
const LINE: usize = 28;
/// The side of a swatch.
const SWATCH: usize = 18;
/// Between a swatch and what follows.
const GAP: usize = 6;
/// Around the legend, and between its columns.
const MARGIN: usize = 20;
/// The line around a swatch, sRGB.
const BORDER: Rgb<u8> = Rgb([90; 3]);

pub(super) struct Legend<'a> {
    regions: &'a [Region],
    left: usize,
    columns: usize,
    column: usize,
}

impl<'a> Legend<'a> {
    /// As many columns as a picture of this width has room for, in the middle.
    pub fn new(regions: &'a [Region], picture: usize) -> Self {
        let texts = regions.iter().map(|region| width(&region.text, SIZE).ceil() as usize);
        let swatches = 2 * (SWATCH + GAP);
        let column = texts.max().unwrap_or(0) + swatches + MARGIN;
        let room = picture.saturating_sub(MARGIN);
        let most = (room / column).clamp(1, regions.len().max(1));
        // No column fewer than the lines need.
        let columns = regions.len().div_ceil(regions.len().div_ceil(most)).max(1);
        let left = MARGIN.max((picture + MARGIN).saturating_sub(columns * column) / 2);
        Legend { regions, left, columns, column }
    }

    pub fn height(&self) -> usize {
        self.regions.len().div_ceil(self.columns) * LINE + MARGIN
    }

    /// Below `top`, row by row.
    pub fn draw(&self, picture: &mut RgbImage, top: usize) {
        for (p, region) in self.regions.iter().enumerate() {
            let mut x = self.left + p % self.columns * self.column;
            let y = top + GAP + p / self.columns * LINE;
            for color in [Some(region.color), region.mean].into_iter().flatten() {
                swatch(picture, [x, y], color);
                x += SWATCH + GAP;
            }
            let baseline = y as f64 + 0.5 * SWATCH as f64 + 0.33 * SIZE;
            text::write(picture, &region.text, [x as f64, baseline], SIZE);
        }
    }
}

fn swatch(picture: &mut RgbImage, [left, top]: [usize; 2], color: [f64; 3]) {
    let color = Rgb(color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8));
    for y in 0..SWATCH {
        for x in 0..SWATCH {
            let edge = x == 0 || y == 0 || x == SWATCH - 1 || y == SWATCH - 1;
            let place = ((left + x) as u32, (top + y) as u32);
            if place.0 < picture.width() && place.1 < picture.height() {
                picture.put_pixel(place.0, place.1, if edge { BORDER } else { color });
            }
        }
    }
}

/// A line in the middle of a half, cut off where it is too long.
pub(super) fn caption(picture: &mut RgbImage, words: &str, left: usize, half: usize) {
    let room = (half - MARGIN) as f64;
    let mut words = words.to_owned();
    if width(&words, SIZE) > room {
        while words.pop().is_some() && width(&(words.clone() + "…"), SIZE) > room {}
        words.push('…');
    }
    let x = left as f64 + (half as f64 - width(&words, SIZE)) / 2.0;
    text::write(picture, &words, [x, CAPTION as f64 - 14.0], SIZE);
}
