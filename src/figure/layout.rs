//! The positions of everything on the page. Margins follow from the measured labels; the plots of a figure have equal
//! sizes and are aligned.

use super::legend::Legend;
use super::range::Range;
use super::text::{
    self, ASCENT, DESCENT, DIGIT_HEIGHT, EXPONENT_SIZE, LABEL_SIZE, LINE_SPACING, SMALL_SIZE,
};
use super::ticks::{self, Label, Ticks};
use super::{Axis, Figure, Panel, Result, Scale, Width, unsuitable};

/// Minimum distance from the edge of the page.
const MARGIN: f64 = 1.0;
pub const TICK_LENGTH: f64 = 2.6;
/// Distance between a tick and its label.
pub const TICK_GAP: f64 = 2.0;
/// Distance between tick labels and the label of the axis.
const LABEL_GAP: f64 = 3.0;
const BETWEEN_PANELS: f64 = 9.0;
const BELOW_LEGEND: f64 = 5.0;
const BELOW_TITLE: f64 = 3.5;
/// Height of a plot relative to the width of its panel, and the bounds of this height.
const PLOT_ASPECT: f64 = 0.6;
const PLOT_HEIGHTS: [f64; 2] = [84.0, 190.0];
/// If plots would be narrower, a figure has fewer columns.
const MIN_PLOT_WIDTH: f64 = 48.0;

/// The rectangle of a plot and the ranges that it shows.
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
    /// The position on the page of a point that has positions on both axes.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let position = |scale: Scale, value| scale.position(value).expect("a drawable number");
        [self.across(position(self.x.scale, x)), self.up(position(self.y.scale, y))]
    }

    pub fn across(&self, position: f64) -> f64 {
        self.left + self.width * self.x.share(position)
    }

    pub fn up(&self, position: f64) -> f64 {
        self.top + self.height * (1.0 - self.y.share(position))
    }

    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// A panel with its plot and its texts at their positions.
pub struct PlacedPanel<'a> {
    pub panel: &'a Panel,
    pub frame: Frame,
    /// `false`: no series has a point with a position on the axes.
    pub has_data: bool,
    pub x_ticks: Ticks,
    pub y_ticks: Ticks,
    pub title: Vec<String>,
    pub x_label: Vec<String>,
    pub y_label: Vec<String>,
    /// The first baselines: y for title and x label, x for the vertical y label.
    pub title_at: f64,
    pub x_label_at: f64,
    pub y_label_at: f64,
}

pub struct Layout<'a> {
    pub width: f64,
    pub height: f64,
    pub columns: usize,
    pub legend: Legend<'a>,
    pub panels: Vec<PlacedPanel<'a>>,
    /// Distances between neighboring plots.
    pub gaps: [f64; 2],
}

impl<'a> Layout<'a> {
    pub fn new(figure: &'a Figure) -> Result<Self> {
        if figure.panels.is_empty() {
            return Err(unsuitable("it has no panels"));
        }
        let mut columns = figure.columns.clamp(1, figure.panels.len());
        loop {
            let grid = Grid::new(figure, columns);
            if grid.plot[0] >= MIN_PLOT_WIDTH || columns == 1 {
                return Ok(grid.place());
            }
            columns -= 1;
        }
    }
}

pub fn label_width(label: &Label) -> f64 {
    let exponent = label.exponent.as_ref().map_or(0.0, |e| text::width(e, EXPONENT_SIZE));
    text::width(&label.text, SMALL_SIZE) + exponent
}

/// The ranges of the data of a panel.
struct Extents<'a> {
    panel: &'a Panel,
    has_data: bool,
    x: Range,
    y: Range,
}

impl<'a> Extents<'a> {
    fn new(panel: &'a Panel) -> Self {
        let drawable = |axis: &Axis, value: f64| axis.scale.position(value).is_some();
        let mut points = Vec::new();
        for series in &panel.series {
            let bands = series.band.iter();
            // A band counts only if both ends are drawable, as it is drawn.
            let ends = bands
                .filter(|b| b[1..].iter().all(|&b| drawable(&panel.y, b)))
                .flat_map(|&[x, low, high]| [[x, low], [x, high]]);
            points.extend(series.points.iter().chain(&series.beyond).copied().chain(ends));
        }
        points.retain(|&[x, y]| drawable(&panel.x, x) && drawable(&panel.y, y));
        let range =
            |axis: &Axis, i: usize| Range::holding(axis.scale, points.iter().map(|point| point[i]));
        let empty = Range { scale: Scale::Linear, low: 0.0, high: 1.0 };
        Extents {
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

/// Gives all panels with data the same ranges.
fn share(extents: &mut [Extents<'_>]) {
    let with_data = || extents.iter().filter(|extents| extents.has_data);
    let x = with_data().map(|extents| extents.x).reduce(Range::union);
    let y = with_data().map(|extents| extents.y).reduce(Range::union);
    let Some((x, y)) = x.zip(y) else { return };
    for extents in extents {
        (extents.x, extents.y) = (x, y);
    }
}

/// The sizes of rows and columns, from which positions follow.
struct Grid<'a> {
    figure: &'a Figure,
    columns: usize,
    width: f64,
    extents: Vec<Extents<'a>>,
    x_ticks: Vec<Ticks>,
    y_ticks: Vec<Ticks>,
    y_labels: Vec<Vec<String>>,
    /// Width and height of every plot.
    plot: [f64; 2],
    /// Room to the left of the plots of the first column and of every other column.
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
        let height = (PLOT_ASPECT * room / columns as f64).clamp(PLOT_HEIGHTS[0], PLOT_HEIGHTS[1]);
        let mut extents: Vec<Extents> = panels.iter().map(Extents::new).collect();
        if figure.shared {
            share(&mut extents);
        }
        let y_ticks =
            extents.iter().map(|e| e.ticks(&e.y, height, &|_| 1.7 * SMALL_SIZE)).collect();
        let mut grid = Grid {
            figure,
            columns,
            width,
            extents,
            x_ticks: Vec::new(),
            y_ticks,
            y_labels: y_labels(panels, columns, height),
            plot: [0.0, height],
            left: [0.0; 2],
            right: 0.0,
        };
        for i in 0..panels.len() {
            grid.make_room(
                i,
                grid.y_label_room(i) + grid.y_tick_labels(i) + TICK_GAP + TICK_LENGTH,
            );
        }
        grid.fit_width(room);
        grid
    }

    /// Makes the plots as wide as possible. The tick labels of x reach beyond the plot, and which of them there are
    /// depends on its width.
    fn fit_width(&mut self, room: f64) {
        loop {
            let inner = self.left[1] * (self.columns - 1) as f64;
            self.plot[0] = (room - self.left[0] - inner) / self.columns as f64 - self.right;
            if self.plot[0] < MIN_PLOT_WIDTH && self.columns > 1 {
                return;
            }
            let room = |label: &Label| label_width(label) + 5.0;
            let ticks = self.extents.iter().map(|e| e.ticks(&e.x, self.plot[0], &room));
            self.x_ticks = ticks.collect();
            let before = (self.left, self.right);
            for i in 0..self.x_ticks.len() {
                let [left, right] = self.overhang(i);
                self.make_room(i, left);
                self.right = self.right.max(right);
            }
            if before == (self.left, self.right) {
                return;
            }
        }
    }

    /// Reserves room to the left of a plot.
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
            lines => (ASCENT + DESCENT + LINE_SPACING * (lines - 1) as f64) * LABEL_SIZE,
        }
    }

    /// How far the tick labels of x reach beyond the plot.
    fn overhang(&self, i: usize) -> [f64; 2] {
        let (mut overhang, range) = ([0.0f64; 2], &self.extents[i].x);
        for tick in &self.x_ticks[i].major {
            let half = label_width(&tick.label) / 2.0;
            let at = self.plot[0] * range.share(tick.number.position(range.scale));
            overhang[0] = overhang[0].max(half - at);
            overhang[1] = overhang[1].max(at + half - self.plot[0]);
        }
        // Rounded to tenths, since otherwise narrowing the plots might not terminate.
        overhang.map(|points| (10.0 * points).ceil() / 10.0)
    }

    fn place(self) -> Layout<'a> {
        let (width, columns) = (self.width, self.columns);
        let inside = width - 2.0 * MARGIN;
        let mut legend = Legend::new(&self.figure.panels, MARGIN, inside);
        for entry in &mut legend.entries {
            entry.at[1] += MARGIN;
        }
        let titles = self.titles();
        let x_labels = x_labels(&self.figure.panels, columns, self.plot[0]);
        let rows = self.rows(&legend, &titles, &x_labels);
        let gaps = [self.right + BETWEEN_PANELS + self.left[1], rows.gap];
        Layout {
            width,
            height: rows.bottom + MARGIN,
            columns,
            legend,
            panels: self.placed(titles, x_labels, rows.top, gaps),
            gaps,
        }
    }

    fn titles(&self) -> Vec<Vec<String>> {
        let titles = self.figure.panels.iter().map(|panel| panel.title.as_deref().unwrap_or(""));
        titles.map(|title| text::wrap(title, LABEL_SIZE, self.plot[0])).collect()
    }

    fn rows(&self, legend: &Legend<'_>, titles: &[Vec<String>], x_labels: &[Vec<String>]) -> Rows {
        let rows = titles.len().div_ceil(self.columns);
        let inner = (rows - 1) * self.columns;
        let gap = below_plot(most_lines(&x_labels[..inner]))
            + BETWEEN_PANELS
            + above_plot(most_lines(&titles[self.columns..]));
        let mut top = MARGIN + legend.height + above_plot(most_lines(&titles[..self.columns]));
        if !legend.entries.is_empty() {
            top += BELOW_LEGEND;
        }
        let last = top + rows as f64 * self.plot[1] + (rows - 1) as f64 * gap;
        let bottom = last + below_plot(most_lines(x_labels)) + DESCENT * LABEL_SIZE;
        Rows { top, gap, bottom }
    }

    fn placed(
        self,
        titles: Vec<Vec<String>>,
        x_labels: Vec<Vec<String>>,
        top: f64,
        gaps: [f64; 2],
    ) -> Vec<PlacedPanel<'a>> {
        let ticks = self.x_ticks.into_iter().zip(self.y_ticks);
        let labels = x_labels.into_iter().zip(self.y_labels);
        let texts = titles.into_iter().zip(labels);
        let panels = self.extents.into_iter().zip(ticks).zip(texts).enumerate();
        let placed =
            panels.map(|(i, ((extents, (x_ticks, y_ticks)), (title, (x_label, y_label))))| {
                let (row, column) = (i / self.columns, i % self.columns);
                let frame = Frame {
                    left: MARGIN + self.left[0] + (self.plot[0] + gaps[0]) * column as f64,
                    top: top + (self.plot[1] + gaps[1]) * row as f64,
                    width: self.plot[0],
                    height: self.plot[1],
                    x: extents.x,
                    y: extents.y,
                };
                // The last line is closest to the plot.
                let above = LINE_SPACING * LABEL_SIZE * title.len().saturating_sub(1) as f64;
                PlacedPanel {
                    panel: extents.panel,
                    has_data: extents.has_data,
                    title_at: frame.top - BELOW_TITLE - above,
                    x_label_at: frame.bottom() + below_plot(1),
                    y_label_at: frame.left - self.left[usize::from(column > 0)]
                        + ASCENT * LABEL_SIZE,
                    frame,
                    x_ticks,
                    y_ticks,
                    title,
                    x_label,
                    y_label,
                }
            });
        placed.collect()
    }
}

/// The rows of plots; they have equal distances, as in pgfplots.
struct Rows {
    /// Top of the first row.
    top: f64,
    /// Distance between the plots of consecutive rows.
    gap: f64,
    /// Bottom of the labels of the last row.
    bottom: f64,
}

fn most_lines(texts: &[Vec<String>]) -> usize {
    texts.iter().map(Vec::len).max().unwrap_or(0)
}

/// The room above a plot for a title of `lines` lines.
fn above_plot(lines: usize) -> f64 {
    match lines {
        // The topmost tick label reaches above the plot by half its height.
        0 => SMALL_SIZE / 2.0,
        lines => (ASCENT + LINE_SPACING * (lines - 1) as f64) * LABEL_SIZE + BELOW_TITLE,
    }
}

/// The room below a plot for tick labels and a label of `lines` lines, to the baseline of the last.
fn below_plot(lines: usize) -> f64 {
    let ticks = TICK_LENGTH + TICK_GAP + SMALL_SIZE;
    match lines {
        0 => ticks,
        lines => {
            ticks + LABEL_GAP + (LINE_SPACING * (lines - 1) as f64 + DIGIT_HEIGHT) * LABEL_SIZE
        }
    }
}

/// The labels of y, without those equal to that of the neighbor to the left.
fn y_labels(panels: &[Panel], columns: usize, height: f64) -> Vec<Vec<String>> {
    let label = |i: usize| {
        let repeats = !i.is_multiple_of(columns) && panels[i - 1].y.label == panels[i].y.label;
        if repeats { "" } else { &panels[i].y.label[..] }
    };
    (0..panels.len()).map(|i| text::wrap(label(i), LABEL_SIZE, height)).collect()
}

/// The labels of x, without those equal to that of the neighbor below.
fn x_labels(panels: &[Panel], columns: usize, width: f64) -> Vec<Vec<String>> {
    let label = |i: usize| {
        let below = panels.get(i + columns);
        let repeats = below.is_some_and(|below| below.x.label == panels[i].x.label);
        if repeats { "" } else { &panels[i].x.label[..] }
    };
    (0..panels.len()).map(|i| text::wrap(label(i), LABEL_SIZE, width)).collect()
}
