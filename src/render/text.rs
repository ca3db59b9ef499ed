//! Lines of text in a picture: outlines of the bundled font, filled by the nonzero winding rule.
//!
//! Each scanline is divided into a few sub-scanlines, along each of which the coverage is exact.

use image::RgbImage;
use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};

use crate::font::{FACE, scale, shape, width};

/// Sub-scanlines per scanline.
const SUBSCANLINES: usize = 5;
/// Line segments per curve; a letter is at most about 35 pixels high.
const SEGMENTS_PER_CURVE: usize = 6;
/// The ink, sRGB.
pub(super) const INK: f64 = 0.16;

/// The direction in which a line of text runs.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Direction {
    Right,
    Up,
}

/// Writes `text` to the right along a baseline, starting at `x`, clipped to the picture.
pub(super) fn write(image: &mut RgbImage, text: &str, start: [f64; 2], size: f64) {
    let extent = [image.width() as usize, image.height() as usize];
    cover(text, start, size, Direction::Right, extent, |[x, y], coverage| {
        for byte in &mut image.get_pixel_mut(x as u32, y as u32).0 {
            let paper = f64::from(*byte);
            *byte = (paper + coverage * (255.0 * INK - paper)).round() as u8;
        }
    });
}

/// Calls `ink` with every pixel that `text` touches and the share of it that is covered. The baseline starts at
/// `start`, in pixels; what lies outside a picture of width and height `extent` is left out.
pub(super) fn cover(
    text: &str,
    start: [f64; 2],
    size: f64,
    direction: Direction,
    extent: [usize; 2],
    ink: impl FnMut([usize; 2], f64),
) {
    let scale = scale(size);
    let glyphs = shape(text);
    let mut outline = Outline { scale, ..Outline::default() };
    let [mut pen, baseline] = start;
    for (glyph, position) in glyphs.glyph_infos().iter().zip(glyphs.glyph_positions()) {
        outline.origin = [
            pen + scale * f64::from(position.x_offset),
            baseline - scale * f64::from(position.y_offset),
        ];
        // A space has no outline.
        let _ = FACE.outline_glyph(GlyphId(glyph.glyph_id as u16), &mut outline);
        pen += scale * f64::from(position.x_advance);
    }
    if direction == Direction::Up {
        for [x, y] in outline.lines.as_flattened_mut() {
            (*x, *y) = (start[0] + (*y - start[1]), start[1] - (*x - start[0]));
        }
    }
    fill(&outline.lines, extent, ink);
}

/// The text, or as much of its beginning as fits into `room` with an ellipsis.
pub(super) fn shortened(text: &str, size: f64, room: f64) -> String {
    let mut line = text.to_owned();
    if width(&line, size) > room {
        while line.pop().is_some() && width(&(line.clone() + "…"), size) > room {}
        line.push('…');
    }
    line
}

/// Outlines as line segments, in pixels.
#[derive(Default)]
struct Outline {
    scale: f64,
    origin: [f64; 2],
    start: [f64; 2],
    at: [f64; 2],
    lines: Vec<[[f64; 2]; 2]>,
}

impl Outline {
    fn point(&self, x: f32, y: f32) -> [f64; 2] {
        let [left, baseline] = self.origin;
        [left + self.scale * f64::from(x), baseline - self.scale * f64::from(y)]
    }

    fn line(&mut self, to: [f64; 2]) {
        self.lines.push([self.at, to]);
        self.at = to;
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.start = self.point(x, y);
        self.at = self.start;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.line(self.point(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (a, b, c) = (self.at, self.point(x1, y1), self.point(x, y));
        for i in 1..=SEGMENTS_PER_CURVE {
            let t = i as f64 / SEGMENTS_PER_CURVE as f64;
            let s = 1.0 - t;
            self.line([0, 1].map(|k| s * s * a[k] + 2.0 * s * t * b[k] + t * t * c[k]));
        }
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (a, b, c, d) = (self.at, self.point(x1, y1), self.point(x2, y2), self.point(x, y));
        for i in 1..=SEGMENTS_PER_CURVE {
            let t = i as f64 / SEGMENTS_PER_CURVE as f64;
            let s = 1.0 - t;
            self.line([0, 1].map(|k| {
                s * s * s * a[k]
                    + 3.0 * s * s * t * b[k]
                    + 3.0 * s * t * t * c[k]
                    + t * t * t * d[k]
            }));
        }
    }

    fn close(&mut self) {
        self.line(self.start);
    }
}

fn fill(
    lines: &[[[f64; 2]; 2]],
    [columns, rows]: [usize; 2],
    mut ink: impl FnMut([usize; 2], f64),
) {
    let ends = || lines.iter().flatten().map(|point| point[1]);
    let top = ends().fold(f64::INFINITY, f64::min).max(0.0) as usize;
    let bottom = (ends().fold(0.0, f64::max).ceil() as usize).min(rows);
    for row in top..bottom {
        let mut coverage = vec![0.0; columns];
        for k in 0..SUBSCANLINES {
            let y = row as f64 + (k as f64 + 0.5) / SUBSCANLINES as f64;
            let mut crossings: Vec<(f64, i32)> = lines
                .iter()
                .filter(|[a, b]| (a[1] <= y) != (b[1] <= y))
                .map(|[a, b]| {
                    let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                    (x, if a[1] < b[1] { 1 } else { -1 })
                })
                .collect();
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut winding = 0;
            for pair in crossings.windows(2) {
                winding += pair[0].1;
                if winding != 0 {
                    add_span(&mut coverage, pair[0].0, pair[1].0);
                }
            }
        }
        for (x, sum) in coverage.into_iter().enumerate().filter(|(_, sum)| *sum > 0.0) {
            ink([x, row], (sum / SUBSCANLINES as f64).min(1.0));
        }
    }
}

/// Adds the fraction of each pixel that lies between two x coordinates on a sub-scanline.
fn add_span(coverage: &mut [f64], from: f64, to: f64) {
    let (from, to) = (from.max(0.0), to.min(coverage.len() as f64));
    if from >= to {
        return;
    }
    for x in from as usize..(to.ceil() as usize).min(coverage.len()) {
        coverage[x] += (to.min(x as f64 + 1.0) - from.max(x as f64)).max(0.0);
    }
}
