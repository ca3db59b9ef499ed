//! Lengths on a page with 300 pixels per inch.

use std::str::FromStr;

pub(super) const DOTS_PER_INCH: f64 = 300.0;
/// Pixels per millimeter.
pub(super) const MILLIMETER: f64 = DOTS_PER_INCH / 25.4;
/// Pixels per point.
pub(super) const POINT: f64 = DOTS_PER_INCH / 72.0;

/// Captions and headings.
pub(super) const TEXT_SIZE: f64 = 8.0 * POINT;
/// The numbers and labels of color bars.
pub(super) const SMALL_TEXT_SIZE: f64 = 7.0 * POINT;
/// The distance between baselines, in text sizes.
pub(super) const LINE_SPACING: f64 = 1.2;

/// The width of a page in pixels, from 20 to 420 mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageWidth(u32);

impl PageWidth {
    /// The forms that [`PageWidth::from_str`] takes.
    pub const SYNTAX: &str = "millimeters such as 85 or 85mm, or pixels such as 1004px";

    /// In pixels.
    pub fn pixels(self) -> u32 {
        self.0
    }
}

/// The text width of a page, 170 mm.
impl Default for PageWidth {
    fn default() -> Self {
        PageWidth((170.0 * MILLIMETER).round() as u32)
    }
}

impl FromStr for PageWidth {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = match text.strip_suffix("px") {
            Some(number) => (number, 1.0),
            None => (text.strip_suffix("mm").unwrap_or(text), MILLIMETER),
        };
        let length: f64 =
            number.trim().parse().map_err(|_| format!("must be {}", PageWidth::SYNTAX))?;
        let pixels = length * unit;
        let [low, high] = [20.0, 420.0].map(|bound| (bound * MILLIMETER).round());
        if (low..=high).contains(&pixels.round()) {
            Ok(PageWidth(pixels.round() as u32))
        } else {
            Err(format!("must be from 20 to 420 mm, or from {low} to {high} px"))
        }
    }
}
