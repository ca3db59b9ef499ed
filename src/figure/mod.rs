//! Figures for print from plain numbers: SVG, PNG, vector PDF and pgfplots.
//!
//! ```text
//! Series -> Curve (its drawable parts)       ->  svg      -> usvg -> PNG, PDF
//! Axis   -> Range -> Ticks -> Layout         ->  pgfplots -> .tex, .dat
//! ```
//!
//! The SVG is written here and not by the crate plotters, which has no superscripts in labels and no dashed lines in
//! SVG, and measures text in another font than the one that is shown: margins, legend rows and the choice of ticks all
//! depend on the width of texts. Only paths and text are needed. The unit of length is a point, 1/72 inch.
//!
//! The only font is the bundled one, and nothing depends on the machine or the time: equal figures give equal bytes.

mod convert;
mod curve;
mod drawing;
mod layout;
mod legend;
mod outlines;
mod pgfplots;
pub(crate) mod range;
mod style;
mod svg;
#[cfg(test)]
mod tests;
pub mod tex;
pub(crate) mod text;
pub(crate) mod ticks;

use std::path::Path;

use crate::error::Result;
use crate::file;
use drawing::unsuitable;
use layout::Layout;
use svg::Text;

pub use drawing::{Axis, Figure, Panel, Primitive, Scale, Series, Width};
pub use style::COLOR_COUNT;

/// The formats of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formats {
    /// SVG, PNG (300 dots per inch), PDF, LaTeX with its table.
    All,
    /// All but PNG.
    Vector,
}

/// Writes `stem.svg`, `stem.pdf`, `stem.tex` and `stem.dat`, and with all formats `stem.png`. Fails if the figure cannot be laid
/// out, such as one without panels, or a file cannot be written.
pub fn write(figure: &Figure, folder: &Path, stem: &str, formats: Formats) -> Result<()> {
    let layout = Layout::new(figure)?;
    let (tex, dat) = pgfplots::draw(&layout, stem);
    let mut contents = vec![
        ("svg", svg::draw(&layout, Text::Outlined).into_bytes()),
        ("tex", tex.into_bytes()),
        ("dat", dat.into_bytes()),
    ];
    let tree = convert::tree(&svg::draw(&layout, Text::Typeset))?;
    contents.push(("pdf", convert::pdf(&tree)?));
    if formats == Formats::All {
        contents.push(("png", convert::png(&tree)?));
    }
    for (extension, content) in contents {
        let path = folder.join(format!("{stem}.{extension}"));
        file::write(&path, |file| file.write_all(&content))?;
    }
    Ok(())
}

/// The figure as SVG text, with its size in points. Fails if it cannot be laid out.
pub fn svg(figure: &Figure) -> Result<String> {
    Ok(svg::draw(&Layout::new(figure)?, Text::Outlined))
}
