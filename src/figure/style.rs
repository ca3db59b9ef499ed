//! The styles of series: the colors of Okabe and Ito, which suit all types of color vision, with dashes and marks that
//! distinguish series without color.

use super::{Primitive, Series};

/// Line widths.
pub const DATA_WIDTH: f64 = 1.2;
pub const REFERENCE_WIDTH: f64 = 0.8;
pub const BAR_WIDTH: f64 = 0.7;
pub const ARROW_WIDTH: f64 = 0.9;
/// The length of an arrow.
pub const ARROW: f64 = 5.0;
pub const FRAME_WIDTH: f64 = 0.5;
pub const GRID_WIDTH: f64 = 0.4;
/// Colors, as written in SVG and in LaTeX.
pub const WHITE: &str = "FFFFFF";
pub const INK: &str = "222222";
pub const GRID_INK: &str = "E2E2E2";
/// Opacity of areas.
pub const AREA_OPACITY: f64 = 0.18;

/// The number of different colors.
pub const COLOR_COUNT: usize = 8;

/// The yellow of the palette is darkened, since it would be invisible as a line on white.
const COLORS: [&str; COLOR_COUNT] =
    ["0072B2", "D55E00", "009E73", "CC79A7", "E69F00", "000000", "56B4E9", "A89B00"];

/// Lengths on, off, on, off, for each style.
const DASHES: [&[f64]; COLOR_COUNT] = [
    &[],
    &[5.0, 1.8],
    &[1.3, 1.5],
    &[5.5, 1.5, 1.3, 1.5],
    &[2.8, 1.5],
    &[8.0, 1.8],
    &[5.5, 1.4, 1.2, 1.4, 1.2, 1.4],
    &[3.0, 1.3, 3.0, 3.6],
];

const REFERENCE_DASHES: [&[f64]; 4] =
    [&[3.6, 2.0], &[1.2, 1.8], &[6.0, 2.0, 1.2, 2.0], &[7.0, 2.6]];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    Circle,
    Square,
    Triangle,
    Diamond,
    Cross,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    pub outline: Outline,
    /// Whether it is filled with the color of its series, or with white.
    pub filled: bool,
}

impl Mark {
    /// Distance from the center to a tip, or to the side of a square, such that all marks have equal visual weight.
    pub fn size(self) -> f64 {
        let size = match self.outline {
            Outline::Circle | Outline::Cross => 1.9,
            Outline::Square => 1.7,
            Outline::Triangle | Outline::Diamond => 2.5,
        };
        if self.filled { 1.25 * size } else { size }
    }

    /// Width of the outline.
    pub fn pen(self) -> f64 {
        match self.outline {
            Outline::Cross => DATA_WIDTH,
            _ if self.filled => 0.5,
            _ => 0.8,
        }
    }

    /// Colors of the inside and the outline. A filled mark has a white outline, which separates it from its line.
    pub fn colors(self, color: &str) -> [&str; 2] {
        if self.filled { [color, WHITE] } else { [WHITE, color] }
    }
}

const MARKS: [Mark; COLOR_COUNT] = [
    Mark { outline: Outline::Circle, filled: true },
    Mark { outline: Outline::Square, filled: false },
    Mark { outline: Outline::Triangle, filled: true },
    Mark { outline: Outline::Diamond, filled: false },
    Mark { outline: Outline::Square, filled: true },
    Mark { outline: Outline::Cross, filled: false },
    Mark { outline: Outline::Circle, filled: false },
    Mark { outline: Outline::Diamond, filled: true },
];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    pub color: &'static str,
    pub dashes: &'static [f64],
    pub width: f64,
    pub mark: Mark,
}

impl Style {
    pub fn of(series: &Series) -> Self {
        let style = series.style;
        // Beyond eight styles, the colors repeat with other dashes and other marks: 32 distinct styles without color,
        // 64 with it.
        let round = style / COLOR_COUNT % COLOR_COUNT;
        let mark = MARKS[(style + 5 * round) % COLOR_COUNT];
        let color = COLORS[style % COLOR_COUNT];
        if series.primitive == Primitive::Reference {
            let dashes = REFERENCE_DASHES[style % REFERENCE_DASHES.len()];
            return Style { color, dashes, width: REFERENCE_WIDTH, mark };
        }
        let dashes = DASHES[(style + 3 * round) % COLOR_COUNT];
        Style { color, dashes, width: DATA_WIDTH, mark }
    }
}
