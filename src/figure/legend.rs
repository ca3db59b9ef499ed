//! The common legend of all panels, with entries in columns, row by row.

use super::text::{self, LABEL_SIZE, LINE_SPACING};
use super::{Panel, Primitive, Series};

/// Widths of samples with and without a line.
const LINE_SAMPLE_WIDTH: f64 = 19.0;
const MARK_SAMPLE_WIDTH: f64 = 8.0;
/// Distance between a sample and its text.
const SAMPLE_GAP: f64 = 3.0;
/// Distance between columns.
const COLUMN_GAP: f64 = 10.0;

pub struct LegendEntry<'a> {
    pub series: &'a Series,
    pub lines: Vec<String>,
    /// Width of the widest line.
    pub width: f64,
    /// Both ends of the sample.
    pub sample: [f64; 2],
    /// Start of the baseline of the first line.
    pub at: [f64; 2],
}

pub struct Legend<'a> {
    pub entries: Vec<LegendEntry<'a>>,
    pub columns: usize,
    pub height: f64,
}

impl<'a> Legend<'a> {
    /// Places the legend at the top of a page, centered.
    pub fn new(panels: &'a [Panel], left: f64, width: f64) -> Self {
        let mut labeled: Vec<&Series> = Vec::new();
        for series in panels.iter().flat_map(|panel| &panel.series) {
            let is_new = labeled.iter().all(|other| other.label != series.label);
            if is_new && !series.label.trim().is_empty() {
                labeled.push(series);
            }
        }
        let mut entries: Vec<LegendEntry> = labeled
            .into_iter()
            .map(|series| {
                let lines =
                    text::wrap(&series.label, LABEL_SIZE, width - LINE_SAMPLE_WIDTH - SAMPLE_GAP);
                let widths = lines.iter().map(|line| text::width(line, LABEL_SIZE));
                let width = widths.fold(0.0, f64::max);
                LegendEntry { series, lines, width, sample: [0.0; 2], at: [0.0; 2] }
            })
            .collect();
        let columns = columns(&entries, width);
        let widths = widths(&entries, columns);
        let mut y = 0.0;
        for row in entries.chunks_mut(columns) {
            let mut x = left + (width - total(&widths)) / 2.0;
            for (entry, [sample, text]) in row.iter_mut().zip(&widths) {
                entry.sample = [x, x + sample];
                entry.at = [x + sample + SAMPLE_GAP, y + text::ASCENT * LABEL_SIZE];
                x += sample + SAMPLE_GAP + text + COLUMN_GAP;
            }
            let lines = row.iter().map(|entry| entry.lines.len()).max().unwrap_or(0);
            y += LINE_SPACING * LABEL_SIZE * lines as f64;
        }
        Legend { entries, columns, height: y }
    }
}

/// The number of columns: as few rows as possible, and no more columns than these rows need.
fn columns(entries: &[LegendEntry], width: f64) -> usize {
    let fits = |columns: &usize| total(&widths(entries, *columns)) <= width;
    let count = entries.len();
    let most = (1..=count).rev().find(fits).unwrap_or(1);
    let rows = count.div_ceil(most);
    (count.div_ceil(rows.max(1)).max(1)..most).find(fits).unwrap_or(most)
}

/// Widths of samples and texts of each column, given by its widest entry.
fn widths(entries: &[LegendEntry], columns: usize) -> Vec<[f64; 2]> {
    let mut widths = vec![[0.0f64; 2]; columns.min(entries.len())];
    for (i, entry) in entries.iter().enumerate() {
        let sample = if entry.series.primitive == Primitive::Marks {
            MARK_SAMPLE_WIDTH
        } else {
            LINE_SAMPLE_WIDTH
        };
        let column = &mut widths[i % columns];
        *column = [column[0].max(sample), column[1].max(entry.width)];
    }
    widths
}

fn total(widths: &[[f64; 2]]) -> f64 {
    let columns: f64 = widths.iter().map(|[sample, text]| sample + SAMPLE_GAP + text).sum();
    columns + COLUMN_GAP * widths.len().saturating_sub(1) as f64
}
