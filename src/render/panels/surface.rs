//! A surface with everything that its panels can show.

use ndarray::{ArrayView2, CowArray, Ix2};

use super::bar::Bar;
use super::quantity::{Quantity, Values};
use super::shown::Shown;
use crate::colormap::{categorical, sequential};
use crate::contour::compared_rows;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::render::layer::{CUT_COLOR, RED};
use crate::render::means::{mean_colors, mean_numbers};

/// The color of regions without a mean, sRGB.
const GRAY: [f64; 3] = [0.72; 3];

/// A mesh with data and regions. Surfaces that borrow the same mesh have the same views and scale.
pub struct Surface<'a> {
    /// V vertices, F faces. A mesh without area leaves its panels empty.
    pub mesh: &'a Mesh,
    /// What `data` and `means` show.
    pub data: Option<ShownData<'a>>,
    /// What all but `data` needs.
    pub regions: Option<Regions>,
    /// The mean color of each region, sRGB in [0, 1]; without them, those of the data.
    pub means: Option<Vec<[f64; 3]>>,
    /// A mesh whose views and scale it has instead of its own, such as all surfaces on the way of one that moves. It contains
    /// the surface.
    pub frame: Option<&'a Mesh>,
}

/// Data at the vertices.
#[derive(Clone, Copy)]
pub enum ShownData<'a> {
    /// V colors, sRGB in [0, 1]; gray where NaN.
    Colors(&'a [[f64; 3]]),
    /// V numbers, shown by a color map and a color bar; gray where NaN.
    Numbers {
        /// In the units of `range`.
        values: &'a [f64],
        /// The numbers at the ends of the color map; others are cut off.
        range: [f64; 2],
        /// The quantity and its unit.
        label: &'a str,
    },
}

impl ShownData<'_> {
    /// The number of vertices.
    fn len(&self) -> usize {
        match self {
            ShownData::Colors(colors) => colors.len(),
            ShownData::Numbers { values, .. } => values.len(),
        }
    }
}

/// The regions of a surface.
#[derive(Clone, Debug)]
pub struct Regions {
    /// V x m in row order; one-hot rows if only labels are known.
    u: Vec<f64>,
    m: usize,
    has_u: bool,
    /// Where two regions are divided, see [`with_threshold`](Self::with_threshold).
    threshold: Option<f64>,
    /// max_p u_p at each vertex, if it is known.
    certainty: Option<Vec<f64>>,
}

impl Regions {
    /// The regions of U, V x m in row order. Panics if m is 0 or the rows are not of length m.
    pub fn of_u(u: Vec<f64>, m: usize) -> Self {
        assert!(m > 0 && u.len().is_multiple_of(m));
        let largest = |row: &[f64]| row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let certainty = Some(u.chunks_exact(m).map(largest).collect());
        Regions { u, m, has_u: true, threshold: None, certainty }
    }

    /// The regions of V labels, each below m, with max_p u_p at the vertices if it is known. Panics if a label is not
    /// below m.
    pub fn of_labels(labels: &[usize], m: usize, certainty: Option<Vec<f64>>) -> Self {
        let mut u = vec![0.0; labels.len() * m];
        for (row, &label) in u.chunks_exact_mut(m).zip(labels) {
            row[label] = 1.0;
        }
        Regions { u, m, has_u: false, threshold: None, certainty }
    }

    /// With a threshold t the two regions are {u_0 >= t} and {u_0 < t}. Panics if there are not two.
    pub fn with_threshold(mut self, threshold: Option<f64>) -> Self {
        assert!(threshold.is_none() || self.m == 2);
        self.threshold = threshold;
        self
    }

    /// m.
    pub fn count(&self) -> usize {
        self.m
    }

    /// The rows whose largest entries are the regions.
    pub(super) fn compared(&self) -> CowArray<'_, f64, Ix2> {
        let u = ArrayView2::from_shape((self.u.len() / self.m, self.m), &self.u);
        compared_rows(u.expect("V rows of m"), self.threshold)
    }

    /// 1 - 1/m, the largest uncertainty.
    fn most_uncertain(&self) -> f64 {
        1.0 - 1.0 / self.m.max(2) as f64
    }

    /// The label of vertex k, the first of equally large ones.
    pub(super) fn label(&self, k: usize) -> usize {
        let row = &self.u[k * self.m..][..self.m];
        if let Some(t) = self.threshold {
            return usize::from(row[0] < t);
        }
        (1..row.len()).fold(0, |best, p| if row[p] > row[best] { p } else { best })
    }

    /// The label of each vertex.
    fn labels(&self) -> impl Iterator<Item = usize> {
        (0..self.u.len() / self.m).map(|k| self.label(k))
    }
}

impl Surface<'_> {
    /// Fails if the surface does not have what is to be shown. Panics if data or regions are not of V vertices, or
    /// means not of m regions.
    pub fn check(&self, shown: Shown) -> Result<()> {
        let count = self.mesh.vertices.len();
        assert!(self.data.is_none_or(|data| data.len() == count));
        if let Some(regions) = &self.regions {
            assert_eq!(regions.u.len(), count * regions.m);
            assert!(regions.certainty.as_ref().is_none_or(|certainty| certainty.len() == count));
            assert!(self.means.as_ref().is_none_or(|means| means.len() == regions.m));
        }
        let lacks = |what: &str| Err(Error::unsuitable(format!("{shown} cannot be shown: {what}")));
        let data =
            matches!(shown, Shown::Data { .. }) || shown == Shown::Means && self.means.is_none();
        if data && self.data.is_none() {
            return lacks("there are no data");
        }
        let Some(regions) = &self.regions else {
            return if shown.needs_regions() { lacks("there are no regions") } else { Ok(()) };
        };
        match shown {
            Shown::Column(_) if !regions.has_u => lacks("only the labels are known, not U"),
            Shown::Column(p) if p >= regions.m => lacks(&format!(
                "U has {} columns; choose from u:0 to u:{}",
                regions.m,
                regions.m - 1
            )),
            Shown::Uncertainty if regions.certainty.is_none() => {
                lacks("only the labels are known, not U")
            }
            _ => Ok(()),
        }
    }

    /// A quantity that was checked, in colors of sRGB.
    pub(super) fn quantity(&self, shown: Shown) -> Quantity<'_> {
        let values = match (shown, &self.regions, self.data) {
            (Shown::Data { .. }, _, Some(ShownData::Colors(colors))) => Values::Colors(colors),
            (Shown::Data { .. }, _, Some(ShownData::Numbers { values, range, .. })) => {
                Values::Numbers(Box::new(move |k| unit(values[k], range)))
            }
            (Shown::Means, Some(regions), _) => {
                Values::Regions(Box::new(move |k| regions.label(k)), self.mean_colors(regions))
            }
            (Shown::Column(p), Some(regions), _) => {
                Values::Numbers(Box::new(move |k| regions.u[k * regions.m + p]))
            }
            (Shown::Uncertainty, Some(regions @ Regions { certainty: Some(certainty), .. }), _) => {
                let most = regions.most_uncertain();
                Values::Numbers(Box::new(move |k| (1.0 - certainty[k]) / most))
            }
            (_, Some(regions), _) => Values::Regions(
                Box::new(move |k| regions.label(k)),
                (0..regions.m).map(categorical).collect(),
            ),
            (_, None, _) => unreachable!("the quantity was checked"),
        };
        let cut = match shown {
            Shown::Data { cut: true } | Shown::Means => Some(RED),
            Shown::Labels => Some(CUT_COLOR),
            Shown::Data { cut: false } | Shown::Column(_) | Shown::Uncertainty => None,
        };
        Quantity { values, cut }
    }

    fn mean_colors(&self, regions: &Regions) -> Vec<[f64; 3]> {
        if let Some(means) = &self.means {
            return means.clone();
        }
        let area = barycentric_areas(self.mesh);
        let labels = regions.labels();
        let means: Vec<Option<[f64; 3]>> = match self.data {
            Some(ShownData::Colors(colors)) => mean_colors(colors, labels, &area, regions.m),
            Some(ShownData::Numbers { values, range, .. }) => {
                let means = mean_numbers(values, labels, &area, regions.m);
                means
                    .into_iter()
                    .map(|mean| mean.map(|mean| sequential(unit(mean, range))))
                    .collect()
            }
            None => vec![None; regions.m],
        };
        means.into_iter().map(|mean| mean.unwrap_or(GRAY)).collect()
    }

    /// The color bar of a quantity, if it needs one.
    pub(super) fn bar(&self, shown: Shown) -> Option<Bar> {
        let numbers = |range: [f64; 2], label: &str| Bar::Numbers {
            range: widened(range),
            label: label.to_owned(),
        };
        let regions = self.regions.as_ref();
        match (shown, self.data) {
            (Shown::Means, _) if self.means.is_some() => None,
            (Shown::Data { .. } | Shown::Means, Some(ShownData::Numbers { range, label, .. })) => {
                Some(numbers(range, label))
            }
            (Shown::Data { .. } | Shown::Means, _) => None,
            (Shown::Labels, _) => Some(Bar::Regions(regions?.m)),
            (Shown::Column(_), _) => Some(numbers([0.0, 1.0], "u")),
            (Shown::Uncertainty, _) => {
                Some(numbers([0.0, regions?.most_uncertain()], "1 \u{2212} max u"))
            }
        }
    }
}

/// The position of a number in a range, as a fraction; NaN stays.
fn unit(value: f64, range: [f64; 2]) -> f64 {
    let [low, high] = widened(range);
    (value - low) / (high - low)
}

/// A range of positive width around one number.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if low < high {
        return [low, high];
    }
    let reach = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    [low - reach, low + reach]
}
