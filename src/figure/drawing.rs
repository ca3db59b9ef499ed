//! What a figure is, apart from how it is drawn: panels, axes, series.

use crate::error::Error;

/// Panels under one legend.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Row by row, from the top left; at least one.
    pub panels: Vec<Panel>,
    /// Of the whole figure.
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
    /// A line above the panel.
    pub title: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// In the order of drawing; bands come before all curves, and a [`Shape::Reference`] before the other curves.
    pub series: Vec<Series>,
}

/// Its range follows from the data.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// How values become lengths.
    pub scale: Scale,
}

impl Axis {
    /// The axis with a label, logarithmic or linear.
    pub fn new(label: impl Into<String>, log: bool) -> Self {
        Axis { label: label.into(), scale: if log { Scale::Log } else { Scale::Linear } }
    }
}

/// The scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Equal differences have equal lengths.
    Linear,
    /// Equal ratios have equal lengths; only positive values have a place.
    Log,
}

/// Points that belong together and look the same.
#[derive(Clone, Debug)]
pub struct Series {
    /// In the legend, once however many series have it; an empty label is not there.
    pub label: String,
    /// The same index looks the same in every panel and figure.
    pub style: usize,
    /// How the points are drawn.
    pub primitive: Primitive,
    /// x and y. A point without a position on the axes, such as a NaN or a zero on a logarithmic one, is left out
    /// and breaks the line.
    pub points: Vec<[f64; 2]>,
    /// x, low, high, such as quartiles: bars beside [`Primitive::Marks`], an area behind lines.
    pub band: Vec<[f64; 3]>,
}

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// Straight lines from each point to the next.
    Line,
    /// Each value holds until the next x.
    Steps,
    /// A mark at each point, without lines.
    Marks,
    /// A line with about eight marks, fewer where it has fewer points.
    LineMarks,
    /// Thin, gray and dashed: a fitted slope, or the number of a paper.
    Reference,
}

/// Figures are plain data, so the error has no file name.
pub(super) fn unsuitable(message: impl std::fmt::Display) -> Error {
    Error::unsuitable(format!("the figure cannot be drawn: {message}"))
}
