//! Where everything is on the page. Margins follow from the measured labels; plots of one figure are all of one
//! size, and aligned.

use super::legend::Legend;
use super::range::Range;
use super::text::{self, ASCENT, DESCENT, DIGITS, EXPONENT, LABEL, LINE, SMALL};
use super::ticks::{self, Label, Ticks};
use super::{Axis, Figure, Panel, Result, Scale, Width, unsuitable};

/// Nothing is closer to the edge of the page.
const MARGIN: f64 = 1.0;
pub const TICK: f64 = 2.6;
/// Between a tick and its label.
pub const TICK_GAP: f64 = 2.0;
/// Between tick labels and the label of the axis.
const LABEL_GAP: f64 = 3.0;
const BETWEEN_PANELS: f64 = 9.0;
const ABOVE_NOTE: f64 = 2.0;
const BELOW_LEGEND: f64 = 5.0;
const BELOW_TITLE: f64 = 3.5;
/// A plot is this high for the width of its panel, between two bounds.
const ASPECT: f64 = 0.6;
const HEIGHTS: [f64; 2] = [84.0, 190.0];
/// With narrower plots, a figure has fewer columns.
const NARROWEST: f64 = 48.0;

/// The rectangle of the plot, and what it shows.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x: Range,
    pub y: Range,
}

impl Frame {
    /// On the page. The point has a place on both axes.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let place = |scale: Scale, value| scale.place(value).expect("a drawable number");
        [self.across(place(self.x.scale, x)), self.up(place(self.y.scale, y))]
    }

    pub fn across(&self, place: f64) -> f64 {
        self.left + self.width * self.x.share(place)
    }

    pub fn up(&self, place: f64) -> f64 {
        self.top + self.height * (1.0 - self.y.share(place))
    }

    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// A panel with its place.
pub struct Placed<'a> {
    pub panel: &'a Panel,
    pub frame: Frame,
    /// `false`: no series has a point with a place on the axes.
    pub has_data: bool,
    pub x_ticks: Ticks,
    pub y_ticks: Ticks,
    pub title: Vec<String>,
    pub x_label: Vec<String>,
    pub y_label: Vec<String>,
    /// The first baselines: across the page for the first two, up the page for the label of y.
    pub title_at: f64,
    pub x_label_at: f64,
    pub y_label_at: f64,
}

pub struct Layout<'a> {
    pub width: f64,
    pub height: f64,
    pub columns: usize,
    pub legend: Legend<'a>,
    pub panels: Vec<Placed<'a>>,
    /// Between the plots of neighbors.
    pub gaps: [f64; 2],
    pub note: Vec<String>,
    pub note_at: [f64; 2],
}

impl<'a> Layout<'a> {
    pub fn new(figure: &'a Figure) -> Result<Self> {
        if figure.panels.is_empty() {
            return Err(unsuitable("it has no panels"));
        }
        let mut columns = figure.columns.clamp(1, figure.panels.len());
        loop {
            let grid = Grid::new(figure, columns);
            if grid.plot[0] >= NARROWEST || columns == 1 {
                return Ok(grid.place());
            }
            columns -= 1;
        }
    }
}

pub fn label_width(label: &Label) -> f64 {
    let exponent = label.exponent.as_ref().map_or(0.0, |e| text::width(e, EXPONENT));
    text::width(&label.text, SMALL) + exponent
}

/// What the axes of a panel show.
struct Shown<'a> {
    panel: &'a Panel,
    has_data: bool,
    x: Range,
    y: Range,
}

impl<'a> Shown<'a> {
    fn new(panel: &'a Panel) -> Self {
        let drawable = |axis: &Axis, value: f64| axis.scale.place(value).is_some();
        let mut points = Vec::new();
        for series in &panel.series {
            let bands = series.band.iter();
            // Both ends or neither, as they are drawn.
            let ends = bands
                .filter(|b| b[1..].iter().all(|&b| drawable(&panel.y, b)))
                .flat_map(|&[x, low, high]| [[x, low], [x, high]]);
            points.extend(series.points.iter().copied().chain(ends));
        }
        points.retain(|&[x, y]| drawable(&panel.x, x) && drawable(&panel.y, y));
        let range =
            |axis: &Axis, i: usize| Range::holding(axis.scale, points.iter().map(|point| point[i]));
        let empty = Range { scale: Scale::Linear, low: 0.0, high: 1.0 };
        Shown {
            panel,
            has_data: !points.is_empty(),
            x: range(&panel.x, 0).unwrap_or(empty),
            y: range(&panel.y, 1).unwrap_or(empty),
        }
    }

    fn ticks(&self, range: &Range, length: f64, room: &dyn Fn(&Label) -> f64) -> Ticks {
        if self.has_data { ticks::ticks(range, length, room) } else { Ticks::default() }
    }
}

/// The sizes of rows and columns, before anything has its place.
struct Grid<'a> {
    figure: &'a Figure,
    columns: usize,
    width: f64,
    shown: Vec<Shown<'a>>,
    x_ticks: Vec<Ticks>,
    y_ticks: Vec<Ticks>,
    x_labels: Vec<Vec<String>>,
    y_labels: Vec<Vec<String>>,
    /// Width and height of every plot.
    plot: [f64; 2],
    /// At the left of the plots of the first column, and of each other column.
    left: [f64; 2],
    right: f64,
}

impl<'a> Grid<'a> {
    fn new(figure: &'a Figure, columns: usize) -> Self {
        let width = 72.0
            * match figure.width {
                Width::Column => 3.33,
                Width::Page => 6.9,
            };
        let panels = &figure.panels;
        let between = BETWEEN_PANELS * (columns - 1) as f64;
        let room = width - 2.0 * MARGIN - between;
        let height = (ASPECT * room / columns as f64).clamp(HEIGHTS[0], HEIGHTS[1]);
        let shown: Vec<Shown> = panels.iter().map(Shown::new).collect();
        let y_ticks: Vec<Ticks> =
            shown.iter().map(|s| s.ticks(&s.y, height, &|_| 1.7 * SMALL)).collect();
        let y_labels: Vec<Vec<String>> = (0..panels.len())
            .map(|i| {
                let repeats = i % columns > 0 && panels[i - 1].y.label == panels[i].y.label;
                let label = if repeats { "" } else { &panels[i].y.label };
                text::wrap(label, LABEL, height)
            })
            .collect();
        let mut grid = Grid {
            figure,
            columns,
            width,
            shown,
            x_ticks: Vec::new(),
            y_ticks,
            x_labels: Vec::new(),
            y_labels,
            plot: [0.0, height],
            left: [0.0; 2],
            right: 0.0,
        };
        for i in 0..panels.len() {
            grid.make_room(i, grid.y_label_room(i) + grid.y_tick_labels(i) + TICK_GAP + TICK);
        }
        // The labels of x reach beyond the plot, and which there are depends on its width.
        loop {
            let inner = grid.left[1] * (columns - 1) as f64;
            grid.plot[0] = (room - grid.left[0] - inner) / columns as f64 - grid.right;
            if grid.plot[0] < NARROWEST && columns > 1 {
                return grid;
            }
            let room = |label: &Label| label_width(label) + 5.0;
            grid.x_ticks = grid.shown.iter().map(|s| s.ticks(&s.x, grid.plot[0], &room)).collect();
            let before = (grid.left, grid.right);
            for i in 0..panels.len() {
                let [left, right] = grid.overhang(i);
                grid.make_room(i, left);
                grid.right = grid.right.max(right);
            }
            if before == (grid.left, grid.right) {
                break;
            }
        }
        grid.x_labels = (0..panels.len())
            .map(|i| {
                let below = panels.get(i + columns);
                let repeats = below.is_some_and(|below| below.x.label == panels[i].x.label);
                let label = if repeats { "" } else { &panels[i].x.label };
                text::wrap(label, LABEL, grid.plot[0])
            })
            .collect();
        grid
    }

    /// At the left of a plot.
    fn make_room(&mut self, i: usize, room: f64) {
        let left = &mut self.left[usize::from(!i.is_multiple_of(self.columns))];
        *left = left.max(room);
    }

    fn y_tick_labels(&self, i: usize) -> f64 {
        self.y_ticks[i].major.iter().map(|tick| label_width(&tick.label)).fold(0.0, f64::max)
    }

    fn y_label_room(&self, i: usize) -> f64 {
        match self.y_labels[i].len() {
            0 => 0.0,
            lines => (ASCENT + DESCENT + LINE * (lines - 1) as f64) * LABEL,
        }
    }

    /// How far the labels of x reach beyond the plot.
    fn overhang(&self, i: usize) -> [f64; 2] {
        let mut overhang = [0.0f64; 2];
        for tick in &self.x_ticks[i].major {
            let half = label_width(&tick.label) / 2.0;
            let at = self.plot[0] * self.shown[i].x.share(tick.number.place(self.shown[i].x.scale));
            overhang[0] = overhang[0].max(half - at);
            overhang[1] = overhang[1].max(at + half - self.plot[0]);
        }
        // In tenths, or narrowing the plots would never come to an end.
        overhang.map(|points| (10.0 * points).ceil() / 10.0)
    }

    fn place(self) -> Layout<'a> {
        let panels = &self.figure.panels;
        let inside = self.width - 2.0 * MARGIN;
        let mut legend = Legend::new(panels, MARGIN, inside);
        for entry in &mut legend.entries {
            entry.at[1] += MARGIN;
        }
        let titles: Vec<Vec<String>> = panels
            .iter()
            .map(|panel| text::wrap(panel.title.as_deref().unwrap_or(""), LABEL, self.plot[0]))
            .collect();
        let most = |lines: &[Vec<String>]| lines.iter().map(Vec::len).max().unwrap_or(0) as f64;
        let above = |lines: f64| match lines {
            // Half a tick label is above the plot.
            0.0 => SMALL / 2.0,
            lines => (ASCENT + LINE * (lines - 1.0)) * LABEL + BELOW_TITLE,
        };
        let below_ticks = TICK + TICK_GAP + SMALL;
        let below = |lines: f64| match lines {
            0.0 => below_ticks,
            lines => below_ticks + LABEL_GAP + (LINE * (lines - 1.0) + DIGITS) * LABEL,
        };
        let rows = panels.len().div_ceil(self.columns);
        let inner = (rows - 1) * self.columns;
        // Rows are at one distance, as pgfplots has it.
        let gap = below(most(&self.x_labels[..inner]))
            + BETWEEN_PANELS
            + above(most(&titles[self.columns..]));

        let mut top = MARGIN + legend.height + above(most(&titles[..self.columns]));
        if !legend.entries.is_empty() {
            top += BELOW_LEGEND;
        }
        let gaps = [self.right + BETWEEN_PANELS + self.left[1], gap];
        let bottom = top + rows as f64 * self.plot[1] + (rows - 1) as f64 * gap;
        let height = bottom + below(most(&self.x_labels)) + DESCENT * LABEL;
        let note = text::wrap(self.figure.note.as_deref().unwrap_or(""), SMALL, inside);
        let note_at = [MARGIN, height + ABOVE_NOTE + ASCENT * SMALL];
        let height = match note.len() {
            0 => height,
            lines => note_at[1] + (LINE * (lines - 1) as f64 + DESCENT) * SMALL,
        };

        let ticks = self.x_ticks.into_iter().zip(self.y_ticks);
        let labels = self.x_labels.into_iter().zip(self.y_labels);
        let texts = titles.into_iter().zip(labels);
        let placed = self.shown.into_iter().zip(ticks).zip(texts).enumerate().map(
            |(i, ((shown, (x_ticks, y_ticks)), (title, (x_label, y_label))))| {
                let (row, column) = (i / self.columns, i % self.columns);
                let frame = Frame {
                    left: MARGIN + self.left[0] + (self.plot[0] + gaps[0]) * column as f64,
                    top: top + (self.plot[1] + gaps[1]) * row as f64,
                    width: self.plot[0],
                    height: self.plot[1],
                    x: shown.x,
                    y: shown.y,
                };
                // The last of several lines is the one above the plot.
                let above = LINE * LABEL * title.len().saturating_sub(1) as f64;
                Placed {
                    panel: shown.panel,
                    has_data: shown.has_data,
                    title_at: frame.top - BELOW_TITLE - above,
                    x_label_at: frame.bottom() + below(1.0),
                    y_label_at: frame.left - self.left[usize::from(column > 0)] + ASCENT * LABEL,
                    frame,
                    x_ticks,
                    y_ticks,
                    title,
                    x_label,
                    y_label,
                }
            },
        );
        Layout {
            width: self.width,
            height: height + MARGIN,
            columns: self.columns,
            legend,
            panels: placed.collect(),
            gaps,
            note,
            note_at,
        }
    }
}
