//! The content of a figure, independent of how it is drawn: panels, axes, series.

use crate::error::Error;

/// Panels with a common legend.
#[derive(Clone, Debug)]
pub struct Figure {
    /// At least one panel, row by row from the top left.
    pub panels: Vec<Panel>,
    /// The width of the whole figure.
    pub width: Width,
    /// Panels in a row; fewer are used if they would be too narrow.
    pub columns: usize,
    /// Whether all panels have the same ranges, since they are compared.
    pub shared: bool,
}

/// The printed width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Width {
    /// 3.33 in.
    Column,
    /// 6.9 in.
    Page,
}

/// One pair of axes. A label that is equal to that of the neighbor to the left (for y) or below (for x) is shown once.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The text above the panel.
    pub title: Option<String>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// In the order of drawing; bands are drawn before all curves, and a [`Primitive::Reference`] before other curves.
    pub series: Vec<Series>,
}

/// An axis, whose range follows from the data.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// How values are mapped to lengths.
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
    /// Equal ratios have equal lengths; only positive values have a position.
    Log,
}

/// Points that belong together and look the same.
#[derive(Clone, Debug)]
pub struct Series {
    /// The text in the legend, shown once even if several series have it; an empty label is not shown.
    pub label: String,
    /// Index of the style, which is the same in every panel and figure.
    pub style: usize,
    /// How the points are drawn.
    pub primitive: Primitive,
    /// x and y. A point without a position on the axes, such as a NaN or a zero on a logarithmic one, is left out
    /// and breaks the line.
    pub points: Vec<[f64; 2]>,
    /// x, low, high, such as quartiles: bars at [`Primitive::Marks`], an area behind lines.
    pub band: Vec<[f64; 3]>,
    /// Lower bounds of values that are not known, such as those of runs that ended too early: arrows upward.
    pub beyond: Vec<[f64; 2]>,
}

impl Series {
    /// A series without bands and arrows.
    pub fn new(
        label: impl Into<String>,
        style: usize,
        primitive: Primitive,
        points: Vec<[f64; 2]>,
    ) -> Self {
        Series {
            label: label.into(),
            style,
            primitive,
            points,
            band: Vec::new(),
            beyond: Vec::new(),
        }
    }
}

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// Straight lines between consecutive points.
    Line,
    /// Each value holds until the next x.
    Steps,
    /// A mark at each point, without lines.
    Marks,
    /// A line with about eight marks, or fewer if it has fewer points.
    LineMarks,
    /// A thin, dashed line: a fitted power law.
    Reference,
}

/// An error without a file name, since figures are plain data.
pub(super) fn unsuitable(message: impl std::fmt::Display) -> Error {
    Error::unsuitable(format!("the figure cannot be drawn: {message}"))
}
