//! Color bars: a color map with numbers and a label, or the palette of the regions with their numbers.

use super::canvas::Canvas;
use super::page::{LINE_SPACING, MILLIMETER, POINT, SMALL_TEXT_SIZE as SIZE};
use crate::colormap::{categorical, sequential};
use crate::figure::Scale;
use crate::figure::range::Range;
use crate::figure::text::{DIGIT_HEIGHT, EXPONENT_RAISE, EXPONENT_SIZE, SMALL_SIZE};
use crate::figure::ticks::{Label, Tick, ticks};
use crate::font::width;
use crate::render::text::{Direction, shortened};

const MAX_LENGTH: f64 = 40.0 * MILLIMETER;
/// The largest length, as a share of the room.
const MAX_SHARE: f64 = 0.8;
/// The largest length of the part of a region.
const MAX_REGION_LENGTH: f64 = 5.0 * MILLIMETER;
const THICKNESS: usize = 20;
const TICK_LENGTH: usize = 8;
/// The width of ticks and of the border.
const LINE_WIDTH: usize = 2;
const LINE_COLOR: [f64; 3] = [0.35; 3];
/// The space between ticks and numbers.
const GAP: f64 = 6.0;
/// The extent of the font below its baseline, in text sizes.
const DESCENT: f64 = 0.3;
/// The smallest space between two numbers, in points.
const NUMBER_GAP: f64 = 4.0;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Bar {
    Numbers {
        range: [f64; 2],
        label: String,
    },
    /// As many regions.
    Regions(usize),
}

impl Bar {
    /// In pixels.
    pub fn height(&self) -> f64 {
        let lines = match self {
            Bar::Numbers { .. } => LINE_SPACING,
            Bar::Regions(_) => 0.0,
        };
        (THICKNESS + TICK_LENGTH) as f64 + GAP + (DIGIT_HEIGHT + lines + DESCENT) * SIZE
    }

    /// Draws the bar centered at `center`, from `top` downwards, in a column that is `room` wide.
    pub fn draw(&self, canvas: &mut Canvas, center: f64, top: usize, room: f64) {
        let baseline = (top + THICKNESS + TICK_LENGTH) as f64 + GAP + DIGIT_HEIGHT * SIZE;
        match self {
            Bar::Numbers { range, label } => {
                let length = (MAX_SHARE * room).min(MAX_LENGTH).round().max(1.0);
                let left = frame(canvas, center, top, length);
                for x in 0..length as usize {
                    let color = sequential((x as f64 + 0.5) / length);
                    canvas.rectangle([left + x, top], [1, THICKNESS], color);
                }
                for (share, Label { text, exponent }) in labels(*range, length) {
                    let x = left as f64 + share * length;
                    tick(canvas, x, top);
                    let exponent = exponent.unwrap_or_default();
                    let lengths = [width(&text, SIZE), width(&exponent, EXPONENT_SIZE * POINT)];
                    let start = x - (lengths[0] + lengths[1]) / 2.0;
                    canvas.text(&text, [start, baseline], SIZE, Direction::Right);
                    let raised = [start + lengths[0], baseline - EXPONENT_RAISE * POINT];
                    canvas.text(&exponent, raised, EXPONENT_SIZE * POINT, Direction::Right);
                }
                let label = shortened(label, SIZE, room);
                centered(canvas, &label, center, baseline + LINE_SPACING * SIZE, SIZE);
            }
            Bar::Regions(m) => {
                let part = (MAX_SHARE * room / *m as f64).min(MAX_REGION_LENGTH).floor().max(1.0);
                let left = frame(canvas, center, top, part * *m as f64);
                let widest = width(&(m - 1).to_string(), SIZE) + NUMBER_GAP * POINT;
                let step = (widest / part).ceil().max(1.0) as usize;
                for p in 0..*m {
                    let x = left + p * part as usize;
                    canvas.rectangle([x, top], [part as usize, THICKNESS], categorical(p));
                    if p % step == 0 {
                        let middle = x as f64 + part / 2.0;
                        tick(canvas, middle, top);
                        centered(canvas, &p.to_string(), middle, baseline, SIZE);
                    }
                }
            }
        }
    }
}

/// Draws the border of a bar and returns where the bar begins.
fn frame(canvas: &mut Canvas, center: f64, top: usize, length: f64) -> usize {
    let left = (center - length / 2.0).round().max(LINE_WIDTH as f64) as usize;
    let border = [left - LINE_WIDTH, top - LINE_WIDTH];
    let size = [length as usize, THICKNESS].map(|length| length + 2 * LINE_WIDTH);
    canvas.rectangle(border, size, LINE_COLOR);
    left
}

fn tick(canvas: &mut Canvas, x: f64, top: usize) {
    let left = (x - LINE_WIDTH as f64 / 2.0).round().max(0.0) as usize;
    canvas.rectangle([left, top + THICKNESS], [LINE_WIDTH, TICK_LENGTH], LINE_COLOR);
}

/// Writes a line of text centered at x.
pub(super) fn centered(canvas: &mut Canvas, text: &str, x: f64, baseline: f64, size: f64) {
    let start = [x - width(text, size) / 2.0, baseline];
    canvas.text(text, start, size, Direction::Right);
}

/// The numbers on a bar of a given length in pixels, each with its position as a share of the length.
pub(super) fn labels([low, high]: [f64; 2], length: f64) -> Vec<(f64, Label)> {
    let range = Range { scale: Scale::Linear, low, high };
    let room = |label: &Label| {
        let exponent = label.exponent.as_deref().unwrap_or_default();
        width(&label.text, SMALL_SIZE) + width(exponent, EXPONENT_SIZE) + NUMBER_GAP
    };
    let share = |tick: &Tick| range.share(tick.number.position(Scale::Linear));
    let ticks = ticks(&range, length / POINT, &room).major;
    ticks.into_iter().map(|tick| (share(&tick), tick.label)).collect()
}
