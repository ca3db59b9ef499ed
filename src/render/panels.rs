//! Pictures for papers: a grid of panels, each with one quantity on a surface, from one side or several.
//!
//! Captions (a), (b), ... are below the panels, color bars between picture and caption, headings above the columns and
//! to the left of the rows. Surfaces are shaded as in the preview; all views of a mesh have the same scale. A page has
//! 300 pixels per inch. Equal panels give equal bytes, whatever the number of threads.

mod bar;
mod canvas;
mod layout;
mod page;
mod png;
mod quantity;
mod shown;
mod stage;
mod surface;
#[cfg(test)]
mod tests;
mod web;

use image::RgbaImage;

pub use page::PageWidth;
pub use shown::Shown;
pub use surface::{Regions, ShownData, Surface};

use self::png::Page;
use super::text::{Direction, shortened};
use super::view::View;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::figure::text::{ASCENT, DESCENT, wrap};
use crate::font::width;
use bar::{Bar, centered};
use canvas::Canvas;
use layout::{GAP, Layout, ROW_GAP, VIEW_GAP};
use page::{LINE_SPACING, TEXT_SIZE};
use stage::Stage;

/// A panel: a quantity on a surface.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Its index in [`Panels::surfaces`].
    pub surface: usize,
    /// The quantity.
    pub shown: Shown,
    /// The text after (a), (b), ...; without it the panel has no caption.
    pub caption: Option<String>,
}

/// A grid of panels.
pub struct Panels<'a> {
    /// The surfaces that the panels show.
    pub surfaces: &'a [Surface<'a>],
    /// The panels, row by row; at least one.
    pub panels: &'a [Panel],
    /// The views of every surface, at least one.
    pub views: &'a [View],
    /// The number of columns; if it is free, the panels are as large as possible.
    pub columns: Option<usize>,
    /// None, or one for each row.
    pub row_headings: &'a [String],
    /// None, or one for each column.
    pub column_headings: &'a [String],
    /// The width of the page.
    pub width: PageWidth,
    /// Whether the page is transparent instead of white.
    pub transparent: bool,
}

impl Panels<'_> {
    /// The page as a PNG file of 300 dots per inch: RGBA if it is transparent, else RGB.
    ///
    /// # Errors
    /// A surface does not have what a panel shows, a panel names a surface that does not exist, there are no panels,
    /// views or columns, or the headings do not fit the grid.
    ///
    /// # Panics
    /// An array of a surface is not of its vertices.
    pub fn png(&self) -> Result<Vec<u8>> {
        let canvas = self.drawn()?;
        let page = if self.transparent {
            Page::Transparent(canvas.transparent())
        } else {
            Page::White(canvas.on_white())
        };
        png::encoded(&page)
    }

    fn check(&self) -> Result<()> {
        if self.panels.is_empty() || self.views.is_empty() || self.columns == Some(0) {
            return Err(Error::unsuitable("a picture needs a panel, a view and a column"));
        }
        for Panel { surface, shown, .. } in self.panels {
            let found = self.surfaces.get(*surface).ok_or_else(|| {
                Error::unsuitable(format!(
                    "a panel shows surface {surface}, but there are {} (counted from 0)",
                    self.surfaces.len()
                ))
            })?;
            found.check(*shown)?;
        }
        Ok(())
    }

    fn drawn(&self) -> Result<Canvas> {
        self.check()?;
        let stages = Stage::all(self.surfaces, self.views);
        let sizes: Vec<_> = stages.iter().map(Stage::sizes).collect();
        let width = f64::from(self.width.pixels());
        let line = LINE_SPACING * TEXT_SIZE;
        let heading = if self.row_headings.is_empty() { 0.0 } else { line };
        let layout = Layout::new(&sizes, self.panels.len(), self.columns, width, heading);
        self.check_headings(layout.columns)?;
        let cells = self.cells(&stages, &layout);

        let rows: Vec<Row> = cells.chunks(layout.columns).map(Row::of).collect();
        let titles: Vec<Vec<String>> = self
            .column_headings
            .iter()
            .map(|text| wrap(text, TEXT_SIZE, layout.column_width))
            .collect();
        let lines = titles.iter().map(Vec::len).max().unwrap_or(0);
        // Descenders of the last line need room above the pictures.
        let title_height = if lines > 0 { (lines as f64 + 0.4) * line } else { 0.0 };
        let gaps = ROW_GAP * (rows.len() - 1) as f64;
        let height = title_height + rows.iter().map(Row::height).sum::<f64>() + gaps;
        let mut canvas = Canvas::new(width as usize, height.ceil().max(1.0) as usize);

        let left = |column: usize| heading + column as f64 * (layout.column_width + GAP);
        let center = |column: usize| left(column) + layout.column_width / 2.0;
        for (column, lines) in titles.iter().enumerate() {
            let missing = title_height - (lines.len() as f64 + 0.4) * line;
            lines_below(&mut canvas, lines, center(column), missing);
        }
        let mut top = title_height;
        for (i, (row, cells)) in rows.iter().zip(cells.chunks(layout.columns)).enumerate() {
            if let Some(text) = self.row_headings.get(i) {
                upwards(&mut canvas, text, top, row.picture);
            }
            for (column, cell) in cells.iter().enumerate() {
                cell.draw(&mut canvas, row, center(column), top, &layout);
            }
            top += row.height() + ROW_GAP;
        }
        Ok(canvas)
    }

    fn check_headings(&self, columns: usize) -> Result<()> {
        let rows = self.panels.len().div_ceil(columns);
        let fits =
            |headings: &[String], count: usize| headings.is_empty() || headings.len() == count;
        if fits(self.row_headings, rows) && fits(self.column_headings, columns) {
            return Ok(());
        }
        Err(Error::unsuitable(format!(
            "the grid has {} and {}, but there are headings for {} and {}",
            counted(rows, "row", "rows"),
            counted(columns, "column", "columns"),
            self.row_headings.len(),
            self.column_headings.len()
        )))
    }

    /// The drawn panels.
    fn cells(&self, stages: &[Stage], layout: &Layout) -> Vec<Cell> {
        let mut pictures: Vec<Vec<RgbaImage>> = vec![Vec::new(); self.panels.len()];
        for (s, stage) in stages.iter().enumerate() {
            let of_surface = || (0..self.panels.len()).filter(|&i| self.panels[i].surface == s);
            let shown: Vec<Shown> = of_surface().map(|i| self.panels[i].shown).collect();
            for (i, views) in of_surface().zip(stage.draw(&shown, layout.scales[s])) {
                pictures[i] = views;
            }
        }
        let cell = |((panel, views), caption): ((&Panel, Vec<RgbaImage>), String)| Cell {
            size: size_of(&views, layout.stacked),
            views,
            bar: self.surfaces[panel.surface].bar(panel.shown),
            caption: wrap(&caption, TEXT_SIZE, layout.column_width),
        };
        self.panels.iter().zip(pictures).zip(self.captions()).map(cell).collect()
    }

    /// The captions, lettered if there are several; empty where a panel has none.
    fn captions(&self) -> Vec<String> {
        let captioned = self.panels.iter().filter(|panel| panel.caption.is_some()).count();
        let mut letters = (0..).map(letters);
        let caption = |panel: &Panel| {
            let caption = panel.caption.as_ref().map(|text| match captioned {
                1 => text.clone(),
                _ => format!("({}) {text}", letters.next().expect("endless")),
            });
            caption.unwrap_or_default()
        };
        self.panels.iter().map(caption).collect()
    }
}

/// A drawn panel.
struct Cell {
    views: Vec<RgbaImage>,
    /// Of all views together.
    size: [f64; 2],
    bar: Option<Bar>,
    /// Its lines.
    caption: Vec<String>,
}

/// The heights of the parts of a row, in pixels.
struct Row {
    picture: f64,
    bar: f64,
    caption: f64,
}

/// The space above a color bar and above a caption.
const BAR_GAP: f64 = 12.0;
const CAPTION_GAP: f64 = 8.0;

impl Row {
    fn of(cells: &[Cell]) -> Self {
        let largest = |height: fn(&Cell) -> f64| cells.iter().map(height).fold(0.0, f64::max);
        Row {
            picture: largest(|cell| cell.size[1]),
            bar: largest(|cell| cell.bar.as_ref().map_or(0.0, |bar| bar.height() + BAR_GAP)),
            caption: largest(|cell| match cell.caption.len() {
                0 => 0.0,
                lines => {
                    let between = (lines - 1) as f64 * LINE_SPACING;
                    CAPTION_GAP + (between + ASCENT + DESCENT) * TEXT_SIZE
                }
            }),
        }
    }

    fn height(&self) -> f64 {
        self.picture + self.bar + self.caption
    }
}

impl Cell {
    fn draw(&self, canvas: &mut Canvas, row: &Row, center: f64, top: f64, layout: &Layout) {
        // The views in the middle of the row, and centered across the direction in which they follow each other.
        let [width, height] = self.size;
        let mut corner = [center - width / 2.0, top + (row.picture - height) / 2.0];
        for view in &self.views {
            let size = [f64::from(view.width()), f64::from(view.height())];
            let (along, across) = if layout.stacked { (1, 0) } else { (0, 1) };
            let mut at = corner;
            at[across] += (self.size[across] - size[across]) / 2.0;
            canvas.picture(view, at.map(|x| x.max(0.0) as usize));
            corner[along] += size[along] + VIEW_GAP;
        }
        if let Some(bar) = &self.bar {
            let top = (top + row.picture + BAR_GAP).round() as usize;
            bar.draw(canvas, center, top, layout.column_width);
        }
        lines_below(canvas, &self.caption, center, top + row.picture + row.bar + CAPTION_GAP);
    }
}

/// The size of views side by side or below each other.
fn size_of(views: &[RgbaImage], stacked: bool) -> [f64; 2] {
    let gaps = VIEW_GAP * views.len().saturating_sub(1) as f64;
    let sizes = || views.iter().map(|view| [f64::from(view.width()), f64::from(view.height())]);
    let sum = |axis: usize| sizes().map(|size| size[axis]).sum::<f64>() + gaps;
    let largest = |axis: usize| sizes().map(|size| size[axis]).fold(0.0, f64::max);
    if stacked { [largest(0), sum(1)] } else { [sum(0), largest(1)] }
}

/// Writes centered lines from `top` downwards.
fn lines_below(canvas: &mut Canvas, lines: &[String], center: f64, top: f64) {
    for (i, line) in lines.iter().enumerate() {
        let baseline = top + (ASCENT + i as f64 * LINE_SPACING) * TEXT_SIZE;
        centered(canvas, line, center, baseline, TEXT_SIZE);
    }
}

/// Writes the heading of a row at its left, upwards.
fn upwards(canvas: &mut Canvas, text: &str, top: f64, height: f64) {
    let text = shortened(text, TEXT_SIZE, height);
    let start = top + (height + width(&text, TEXT_SIZE)) / 2.0;
    canvas.text(&text, [0.8 * TEXT_SIZE, start], TEXT_SIZE, Direction::Up);
}

/// a, b, ..., z, aa, ab, ...
fn letters(i: usize) -> String {
    let last = char::from(b'a' + (i % 26) as u8);
    if i < 26 { last.to_string() } else { letters(i / 26 - 1) + &last.to_string() }
}
