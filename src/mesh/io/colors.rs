//! Colors of vertices or faces in files: for all rows or some of them, in [0, 1] or up to 255.
//!
//! An integer type determines the full intensity. The range of numbers without a type is inferred from the whole file:
//!
//! | largest component | meaning |
//! |---|---|
//! | up to 1 | as they are |
//! | up to 255, and all are whole numbers or one is above 2 | over 255 |
//! | up to 2 | too bright by a little: cut off at 1, with a warning |
//!
//! A file seems to mix both ranges if all colors above 1 are whole numbers and some of the others are not, or if fewer
//! colors are above 1 than below, not counting black: it is read as over 255, with a warning. Colors with a negative
//! component, or one above 255, are left out; if most are, all are left out, since they must be of another kind. Rows
//! without a color are NaN (unknown). Both cause a warning.

use std::path::Path;

use super::occurrences::{Occurrences, warn};

/// Tolerance for components in [0, 1] that were rounded when written.
const COMPONENT_ROUNDING: f64 = 1e-6;

const LARGEST_BYTE: f64 = 255.0;

/// A file with fractions is read as over 255 only if a component exceeds this.
const TOO_BRIGHT: f64 = 2.0;

/// The colors of vertices or faces read so far.
pub struct Colors {
    rows: Vec<[f64; 3]>,
    /// The value of full intensity, if the type determines it.
    full: Option<f64>,
    largest: f64,
    fractions: bool,
    /// Whether colors above 1 have fractions, and the colors up to 1 that have some.
    bright_fractions: bool,
    dim_fractions: Occurrences,
    /// The number of colors up to 1 that are not black.
    dim: usize,
    bright: Occurrences,
    outside: Occurrences,
}

impl Colors {
    pub fn new(full: Option<f64>) -> Self {
        Colors {
            rows: Vec::new(),
            full,
            largest: 0.0,
            fractions: false,
            bright_fractions: false,
            dim_fractions: Occurrences::default(),
            dim: 0,
            bright: Occurrences::default(),
            outside: Occurrences::default(),
        }
    }

    pub fn with_capacity(mut self, rows: usize) -> Self {
        self.rows.reserve(rows);
        self
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Sets the color of a row; rows must be increasing, and skipped rows have no color.
    #[inline]
    pub fn set(&mut self, row: usize, color: [f64; 3], location: impl FnOnce() -> String) {
        self.rows.resize(row, [f64::NAN; 3]);
        if !color.iter().all(|c| c.is_finite()) {
            self.rows.push([f64::NAN; 3]);
            return;
        }
        let [r, g, b] = color;
        let (low, high) = (r.min(g).min(b), r.max(g).max(b));
        if low < -COMPONENT_ROUNDING || high > self.full.unwrap_or(LARGEST_BYTE) {
            self.outside.add(location);
            self.rows.push([f64::NAN; 3]);
            return;
        }
        self.largest = self.largest.max(high);
        let fractions = color.iter().any(|c| c.fract() != 0.0);
        self.fractions |= fractions;
        if high > 1.0 + COMPONENT_ROUNDING {
            self.bright_fractions |= fractions;
            self.bright.add(location);
        } else {
            self.dim += usize::from(high > 0.0);
            if fractions {
                self.dim_fractions.add(location);
            }
        }
        self.rows.push(color);
    }

    /// The colors of all `count` rows in [0, 1], if some row has a color. `what` names the rows, in the plural.
    pub fn finish(mut self, path: &Path, count: usize, what: &str) -> Option<Vec<[f64; 3]>> {
        if self.rows.is_empty() {
            return None;
        }
        self.rows.resize(count, [f64::NAN; 3]);
        let unknown = self.rows.iter().filter(|color| color[0].is_nan()).count();
        if !self.outside.is_empty() {
            let range =
                self.full.map_or("[0, 1] or [0, 255]".to_owned(), |full| format!("[0, {full}]"));
            if self.outside.count() > count - unknown {
                let most =
                    format!("the colors of {what} are left out because most are outside {range}");
                self.outside.warn(path, &most);
                return None;
            }
            self.outside.warn(path, &format!("colors of {what} outside {range} are left out"));
        }
        if unknown == count {
            warn(
                path,
                &format!("the colors of {what} are left out because none of them is a number"),
            );
            return None;
        }
        if unknown > 0 {
            let first = self.rows.iter().position(|color| color[0].is_nan()).unwrap_or_default();
            warn(
                path,
                &format!(
                    "{unknown} of {count} {what} have no color and are unknown (the first, counted from 0: {first})"
                ),
            );
        }
        let full = self.full.unwrap_or_else(|| {
            if self.largest <= 1.0 + COMPONENT_ROUNDING {
                1.0
            } else if !self.fractions || self.largest > TOO_BRIGHT {
                if self.bright.count() < self.dim {
                    let mixed = format!(
                        "colors of {what} go up to {}, so all are read as 0 to 255, but few are above 1; write them in \
                         one range",
                        self.largest
                    );
                    self.bright.warn(path, &mixed);
                } else if !self.bright_fractions {
                    let mixed = format!(
                        "colors of {what} go up to {}, so all are read as 0 to 255, but some look like fractions of 1; \
                         write them in one range",
                        self.largest
                    );
                    self.dim_fractions.warn(path, &mixed);
                }
                LARGEST_BYTE
            } else {
                self.bright.warn(path, &format!("colors of {what} above 1 are reduced to 1"));
                1.0
            }
        });
        // Not max and min, which would turn NaN into a color.
        self.rows.as_flattened_mut().iter_mut().for_each(|c| *c = (*c / full).clamp(0.0, 1.0));
        Some(self.rows)
    }
}
