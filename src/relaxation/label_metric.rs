//! A metric d on the labels: a cut between labels a and b costs d(a, b) times what it costs in the Potts model, whose d
//! is 1 for all pairs.
//!
//! ```text
//! d(a, a) = 0,    d(a, b) = d(b, a) > 0,    d(a, b) <= d(a, c) + d(c, b)
//! ```
//!
//! Without the last inequality, a thin layer of c would make the border between a and b cheaper. J. Lellmann, C.
//! Schnörr, *Continuous multiclass labeling approaches and algorithms*, SIAM J. Imaging Sciences 4, 2011.

use std::fmt;
use std::ops::RangeInclusive;
use std::sync::{Mutex, PoisonError};

use ndarray::Array2;

use crate::error::{Error, Result};

/// Enough for the largest number of regions, see `regions.rs`.
const LENGTH: usize = 64;

/// Sums of two distances may miss the third, and two that must be equal may differ, by this share: numbers in files are
/// rounded.
const ROUNDING: f64 = 1e-12;

/// Distances smaller than this share of the largest one would be lost in rounding errors of the others.
const SMALLEST_SHARE: f64 = 1e-6;

/// Squares of larger and smaller distances, and what is divided by them, would leave the range of double precision.
const RANGE: RangeInclusive<f64> = 1e-60..=1e60;

/// The weights of all pairs of labels. Equal metrics are one in memory, which is kept until the program ends, so that a
/// metric is as handy as a number.
#[derive(Clone, Copy)]
pub struct LabelMetric(&'static Table);

struct Table {
    /// m.
    labels: usize,
    /// d(a, b). For padding regions b it is the largest of all: points that sum to zero are never that far from the
    /// origin, where those of padding regions are.
    d: [[f64; LENGTH]; LENGTH],
    /// 1 / d(a, b)^2.
    inverse_squares: [[f64; LENGTH]; LENGTH],
    /// The smallest and the largest distance between different labels.
    range: [f64; 2],
}

static POTTS: Table = Table {
    labels: LENGTH,
    d: [[1.0; LENGTH]; LENGTH],
    inverse_squares: [[1.0; LENGTH]; LENGTH],
    range: [1.0; 2],
};

/// All metrics so far.
static KNOWN: Mutex<Vec<&'static Table>> = Mutex::new(Vec::new());

impl LabelMetric {
    /// d = 1 between all labels, of any number.
    pub const POTTS: Self = LabelMetric(&POTTS);

    /// The largest number of labels.
    pub const MAX_LABELS: usize = LENGTH;

    /// The metric with these distances, m x m.
    ///
    /// Fails unless m is from 2 to 64, and the matrix symmetric, zero on its diagonal and positive elsewhere, with
    /// numbers from 1e-60 to 1e60 that are no more than a factor 1e6 apart and fulfill the triangle inequality.
    pub fn new(d: &Array2<f64>) -> Result<Self> {
        let m = d.nrows();
        if d.ncols() != m {
            return Err(Error::unsuitable(format!(
                "{m} x {} weights of pairs: supply a row and a column for each label",
                d.ncols()
            )));
        }
        if !(2..=LabelMetric::MAX_LABELS).contains(&m) {
            let most = LabelMetric::MAX_LABELS;
            return Err(Error::unsuitable(format!(
                "weights of {m} labels: must be from 2 to {most}"
            )));
        }
        check(d)?;
        let d = &(0.5 * (d + &d.t()));
        let different = || d.indexed_iter().filter(|((a, b), _)| a != b).map(|(_, &d)| d);
        let range = [different().fold(f64::INFINITY, f64::min), different().fold(0.0, f64::max)];
        let mut table = Table {
            labels: m,
            d: [[range[1]; LENGTH]; LENGTH],
            inverse_squares: [[0.0; LENGTH]; LENGTH],
            range,
        };
        d.indexed_iter().filter(|((a, b), _)| a != b).for_each(|((a, b), &d)| table.d[a][b] = d);
        table.inverse_squares = table.d.map(|row| row.map(|d| 1.0 / (d * d)));
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.iter().find(|other| other.labels == m && other.d == table.d);
        let table = found.copied().unwrap_or_else(|| Box::leak(Box::new(table)));
        if found.is_none() {
            known.push(table);
        }
        Ok(LabelMetric(table))
    }

    /// The number of labels that it is for; 64 for that of Potts.
    pub fn labels(self) -> usize {
        self.0.labels
    }

    /// The matrix of distances.
    pub fn matrix(self) -> Array2<f64> {
        Array2::from_shape_fn((self.0.labels, self.0.labels), |(a, b)| self.distance(a, b))
    }

    /// d(a, b).
    #[inline(always)]
    pub fn distance(self, a: usize, b: usize) -> f64 {
        if a == b { 0.0 } else { self.0.d[a][b] }
    }

    /// The same for a != b.
    #[inline(always)]
    pub(super) fn apart(self, a: usize, b: usize) -> f64 {
        self.0.d[a][b]
    }

    /// The smallest distance between different labels.
    #[inline(always)]
    pub fn smallest(self) -> f64 {
        self.0.range[0]
    }

    /// The largest distance.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.0.range[1]
    }

    /// Whether this is that of Potts.
    #[inline(always)]
    pub fn is_potts(self) -> bool {
        self == LabelMetric::POTTS
    }

    /// The two points whose distance is the largest in units of d, and the square of it.
    #[inline(always)]
    pub(super) fn farthest<const M: usize>(self, x: &[f64; M], y: &[f64; M]) -> ([usize; 2], f64) {
        let mut found = ([0; 2], 0.0);
        for a in 0..M {
            for b in 0..a {
                let (dx, dy) = (x[a] - x[b], y[a] - y[b]);
                let square = (dx * dx + dy * dy) * self.0.inverse_squares[a][b];
                found = if square > found.1 { ([a, b], square) } else { found };
            }
        }
        found
    }
}

impl PartialEq for LabelMetric {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for LabelMetric {}

impl fmt::Debug for LabelMetric {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "LabelMetric of {} labels, {:?}", self.labels(), self.0.range)
    }
}

/// Fails unless a square matrix is a metric.
fn check(d: &Array2<f64>) -> Result<()> {
    let m = d.nrows();
    let unsuitable = |message: String| Err(Error::unsuitable(message));
    let entries = || d.indexed_iter().map(|((a, b), &d)| (a, b, d));
    if let Some((a, b, d)) = entries().find(|&(a, b, d)| a != b && !(d > 0.0 && d.is_finite())) {
        return unsuitable(format!(
            "labels {a} and {b} have the weight {d:?}: weights of different labels must be positive and finite"
        ));
    }
    if let Some((a, _, d)) = entries().find(|&(a, b, d)| a == b && d != 0.0) {
        return unsuitable(format!(
            "label {a} has the weight {d:?} to itself, where there is no cut: it must be 0"
        ));
    }
    if let Some((a, b, there)) =
        entries().find(|&(a, b, there)| (there - d[[b, a]]).abs() > ROUNDING * there)
    {
        return unsuitable(format!(
            "labels {a} and {b} have the weights {there:?} and {:?}: a cut has no direction, so both must be equal",
            d[[b, a]]
        ));
    }
    if let Some((a, b, d)) = entries().find(|&(a, b, d)| a != b && !RANGE.contains(&d)) {
        return unsuitable(format!(
            "labels {a} and {b} have the weight {d:?}: weights must be from 1e-60 to 1e60; scale all of them, and lambda the \
             other way"
        ));
    }
    let largest = d.iter().copied().fold(0.0, f64::max);
    if let Some((a, b, d)) = entries().find(|&(a, b, d)| a != b && d < SMALLEST_SHARE * largest) {
        return unsuitable(format!(
            "labels {a} and {b} have the weight {d:?}, less than a millionth of the largest one, {largest:?}"
        ));
    }
    let by_way_of = |a: usize, b: usize| {
        let ways = (0..m).filter(|&c| c != a && c != b).map(|c| (c, d[[a, c]] + d[[c, b]]));
        ways.min_by(|x, y| x.1.total_cmp(&y.1))
    };
    for (a, b, direct) in entries() {
        if let Some((c, sum)) = by_way_of(a, b)
            && direct > sum * (1.0 + ROUNDING)
        {
            return unsuitable(format!(
                "labels {a} and {b} have the weight {direct:?}, more than {:?} + {:?} by way of label {c}, of which a thin layer \
                 would run between them: lower it to {sum:?}, or raise the others",
                d[[a, c]],
                d[[c, b]]
            ));
        }
    }
    Ok(())
}
