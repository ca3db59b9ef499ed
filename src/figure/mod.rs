//! Plain numbers as figures for print: SVG, PNG, vector PDF, and pgfplots.
//!
//! ```text
//! Series -> Curve (what of it can be drawn)  ->  svg      -> usvg -> PNG, PDF
//! Axis   -> Range -> Ticks -> Layout         ->  pgfplots -> .tex, .dat
//! ```
//!
//! The SVG is written here and not by plotters, whose labels have no superscripts, whose lines have no dashes
//! in its SVG, and whose text is measured in a font other than the one it is shown in: margins, legend rows and
//! the choice of ticks all rest on the width of a text. What is drawn is paths and text, which is little to
//! write. One length is a point, 1/72 inch, as in print.
//!
//! The only font is the bundled one, and nothing depends on the machine or the time: the same figure gives the
//! same bytes.

mod convert;
mod curve;
mod layout;
mod legend;
mod pgfplots;
mod range;
mod style;
mod svg;
#[cfg(test)]
mod tests;
pub mod tex;
mod text;
mod ticks;

use std::path::Path;

use crate::error::{Error, Result};
use crate::file;
use layout::Layout;
use svg::Font;

/// Panels under one legend.
#[derive(Clone, Debug)]
pub struct Figure {
    pub panels: Vec<Panel>,
    pub width: Width,
    /// Panels in a row; fewer, where they would be too narrow to read.
    pub columns: usize,
    /// A small line under the panels.
    pub note: Option<String>,
}

/// The width in print.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Width {
    /// 3.33 in.
    Column,
    /// 6.9 in.
    Page,
}

/// One pair of axes. A label that the neighbor to the left (for y) or below (for x) repeats is shown once.
#[derive(Clone, Debug)]
pub struct Panel {
    pub title: Option<String>,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
}

/// Its range follows from the data.
#[derive(Clone, Debug)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    Linear,
    Log,
}

#[derive(Clone, Debug)]
pub struct Series {
    /// In the legend, once however many series have it; an empty label is not there.
    pub label: String,
    /// The same index looks the same in every panel and figure.
    pub style: usize,
    pub shape: Shape,
    /// x and y. A point without a place on the axes, such as a NaN or a zero on a logarithmic one, is left out
    /// and breaks the line.
    pub points: Vec<[f64; 2]>,
    /// x, low, high, such as quartiles: bars beside [`Shape::Marks`], an area behind lines.
    pub band: Vec<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Line,
    /// Each value holds until the next x.
    Steps,
    Marks,
    /// A line with about eight marks, fewer where it has fewer points.
    LineMarks,
    /// Thin, gray and dashed: a fitted slope, or the number of a paper.
    Reference,
}

/// Writes `stem.svg`, `stem.png` (300 dots an inch), `stem.pdf`, `stem.tex` and `stem.dat`.
pub fn write(figure: &Figure, folder: &Path, stem: &str) -> Result<()> {
    let layout = Layout::new(figure)?;
    let svg = svg::draw(&layout, Font::Readers);
    let tree = convert::tree(&svg::draw(&layout, Font::Bundled))?;
    let (tex, dat) = pgfplots::draw(&layout, stem);
    let contents = [
        ("svg", svg.into_bytes()),
        ("png", convert::png(&tree)?),
        ("pdf", convert::pdf(&tree)?),
        ("tex", tex.into_bytes()),
        ("dat", dat.into_bytes()),
    ];
    for (extension, content) in contents {
        let path = folder.join(format!("{stem}.{extension}"));
        file::write(&path, |file| file.write_all(&content))?;
    }
    Ok(())
}

/// The figure as text, with its size in points.
pub fn svg(figure: &Figure) -> Result<String> {
    Ok(svg::draw(&Layout::new(figure)?, Font::Readers))
}

/// Figures are plain data; what stops one is said without a file name.
fn unsuitable(message: impl std::fmt::Display) -> Error {
    Error::unsuitable(format!("the figure cannot be drawn: {message}"))
}
