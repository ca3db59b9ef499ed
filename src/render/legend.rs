//! The text around the picture: a caption above each half, and a legend below with each region's color, its mean in the
//! colors of the data, and a description.

use image::{Rgb, RgbImage};

use super::{Region, text};
use crate::font::width;

/// The height of the captions.
pub(super) const CAPTION_HEIGHT: usize = 38;
const FONT_SIZE: f64 = 18.0;
/// The distance between lines of the legend.
const LINE_HEIGHT: usize = 28;
/// The side of a swatch.
const SWATCH_SIZE: usize = 18;
/// The space after a swatch.
const GAP: usize = 6;
/// The space around the legend and between its columns.
const MARGIN: usize = 20;
/// The border of a swatch, sRGB.
const BORDER_COLOR: Rgb<u8> = Rgb([90; 3]);

pub(super) struct Legend<'a> {
    regions: &'a [Region],
    left: usize,
    columns: usize,
    column: usize,
}

impl<'a> Legend<'a> {
    /// As many columns as fit into a picture of the given width, centered.
    pub fn new(regions: &'a [Region], picture: usize) -> Self {
        let texts = regions.iter().map(|region| width(&region.text, FONT_SIZE).ceil() as usize);
        let swatches = 2 * (SWATCH_SIZE + GAP);
        let column = texts.max().unwrap_or(0) + swatches + MARGIN;
        let room = picture.saturating_sub(MARGIN);
        let fitting = (room / column).clamp(1, regions.len().max(1));
        // The fewest columns that need no more lines than that.
        let columns = regions.len().div_ceil(regions.len().div_ceil(fitting)).max(1);
        let left = MARGIN.max((picture + MARGIN).saturating_sub(columns * column) / 2);
        Legend { regions, left, columns, column }
    }

    pub fn height(&self) -> usize {
        self.regions.len().div_ceil(self.columns) * LINE_HEIGHT + MARGIN
    }

    /// Draws the legend below `top`, row by row.
    pub fn draw(&self, picture: &mut RgbImage, top: usize) {
        for (p, region) in self.regions.iter().enumerate() {
            let mut x = self.left + p % self.columns * self.column;
            let y = top + GAP + p / self.columns * LINE_HEIGHT;
            for color in [Some(region.color), region.mean].into_iter().flatten() {
                swatch(picture, [x, y], color);
                x += SWATCH_SIZE + GAP;
            }
            let baseline = y as f64 + 0.5 * SWATCH_SIZE as f64 + 0.33 * FONT_SIZE;
            text::write(picture, &region.text, [x as f64, baseline], FONT_SIZE);
        }
    }
}

fn swatch(picture: &mut RgbImage, [left, top]: [usize; 2], color: [f64; 3]) {
    let color = Rgb(color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8));
    for y in 0..SWATCH_SIZE {
        for x in 0..SWATCH_SIZE {
            let edge = x == 0 || y == 0 || x == SWATCH_SIZE - 1 || y == SWATCH_SIZE - 1;
            let (column, row) = ((left + x) as u32, (top + y) as u32);
            if column < picture.width() && row < picture.height() {
                picture.put_pixel(column, row, if edge { BORDER_COLOR } else { color });
            }
        }
    }
}

/// Writes a line centered above a half, truncated if it is too long.
pub(super) fn caption(picture: &mut RgbImage, text: &str, left: usize, half: usize) {
    let line = text::shortened(text, FONT_SIZE, (half - MARGIN) as f64);
    let x = left as f64 + (half as f64 - width(&line, FONT_SIZE)) / 2.0;
    text::write(picture, &line, [x, CAPTION_HEIGHT as f64 - 14.0], FONT_SIZE);
}
