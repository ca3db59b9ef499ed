//! The bins of the histograms, which are the same for all regions: shares of a datum in them, and smoothing.

use crate::data::Data;
use crate::data::range::robust_range;
use crate::error::{Error, Result};

/// Maximum dimension of the data: the number of bins grows exponentially.
pub const MAX_DIMENSION: usize = 3;

/// Bins per coordinate, for 1, 2 and 3 coordinates in which the data vary: at most 4096 numbers per region.
const BINS: [usize; MAX_DIMENSION] = [128, 32, 16];

/// How often the filter (1, 2, 1)/4 is applied along each coordinate, for 1, 2 and 3 coordinates: a deviation of
/// sqrt(n/2) bins.
const PASSES: [usize; MAX_DIMENSION] = [8, 2, 1];

/// The range exceeds the 2 % and 98 % quantiles by this fraction of their distance at both ends: four standard deviations
/// of a normal distribution. It never exceeds that of the data.
const MARGIN: f64 = 0.5;

/// Data are equal if they differ by no more than this fraction of them.
const EQUAL_WITHIN: f64 = 1e-13;

/// One coordinate.
#[derive(Clone)]
struct Axis {
    /// Of the bins; data outside count as at the nearer end.
    range: [f64; 2],
    /// 1 if the data do not vary.
    bins: usize,
    /// Bins per unit of the data; 0 if the data do not vary.
    per_unit: f64,
}

/// A grid of bins; their numbers run fastest in the last coordinate.
#[derive(Clone)]
pub struct Grid {
    axes: Vec<Axis>,
    passes: usize,
}

/// The shares of a datum in the bins around it.
pub struct Corners {
    count: usize,
    bins: [u16; 1 << MAX_DIMENSION],
    shares: [f64; 1 << MAX_DIMENSION],
}

impl Corners {
    /// Each bin and its share; the shares have sum 1.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        let pairs = self.bins.iter().zip(&self.shares).take(self.count);
        pairs.map(|(&b, &share)| (b as usize, share))
    }
}

impl Grid {
    /// Over the robust range of the data, all vertices alike.
    ///
    /// # Errors
    /// Data of too many columns, and data whose range leaves that of double precision.
    pub fn of(data: &Data) -> Result<Self> {
        let d = data.dimension;
        if d > MAX_DIMENSION {
            return Err(Error::unsuitable(format!(
                "the data have {d} columns, and the model histogram takes at most {MAX_DIMENSION}: choose fewer, or \
                 another model"
            )));
        }
        let ranges: Vec<[f64; 2]> = (0..d).map(|i| range(&data.column(i))).collect();
        let rank = ranges.iter().filter(|[low, high]| low < high).count();
        let (bins, passes) = if rank > 0 { (BINS[rank - 1], PASSES[rank - 1]) } else { (1, 0) };
        let axis = |range: [f64; 2]| {
            let [low, high] = range;
            if low == high {
                return Ok(Axis { range, bins: 1, per_unit: 0.0 });
            }
            let per_unit = bins as f64 / (high - low);
            if !per_unit.is_normal() {
                return Err(Error::unsuitable(
                    "the range of the data leaves that of double precision; scale the data",
                ));
            }
            Ok(Axis { range, bins, per_unit })
        };
        Ok(Grid { axes: ranges.into_iter().map(axis).collect::<Result<_>>()?, passes })
    }

    /// d.
    pub fn dimension(&self) -> usize {
        self.axes.len()
    }

    /// Number of coordinates in which the data vary.
    pub fn rank(&self) -> usize {
        self.axes.iter().filter(|axis| axis.bins > 1).count()
    }

    /// Number of bins.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.bins).product()
    }

    /// The lowest and the highest value of each coordinate.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        self.axes.iter().map(|axis| axis.range).collect()
    }

    /// Number of bins of each coordinate.
    pub fn bins(&self) -> Vec<usize> {
        self.axes.iter().map(|axis| axis.bins).collect()
    }

    /// The logarithm of the volume of a bin, over the coordinates in which the data vary.
    pub fn log_volume(&self) -> f64 {
        -self.axes.iter().filter(|axis| axis.bins > 1).map(|axis| axis.per_unit.ln()).sum::<f64>()
    }

    /// The center of bin b.
    pub fn center(&self, b: usize) -> Vec<f64> {
        let mut rest = b;
        let mut center: Vec<f64> = (self.axes.iter().rev())
            .map(|axis| {
                let i = rest % axis.bins;
                rest /= axis.bins;
                let t = (i as f64 + 0.5) / axis.bins as f64;
                axis.range[0] * (1.0 - t) + axis.range[1] * t
            })
            .collect();
        center.reverse();
        center
    }

    /// The multilinear interpolation weights of the centers of the bins around c, which is moved into the range of the
    /// centers: linear binning. M. P. Wand, *Fast computation of multivariate kernel estimators*, J. Comput. Graph.
    /// Stat. 3, 1994.
    #[inline(always)]
    pub fn corners(&self, c: &[f64]) -> Corners {
        let mut corners = Corners { count: 1, bins: [0; _], shares: [1.0; _] };
        let Corners { count, bins, shares } = &mut corners;
        for (c, axis) in c.iter().zip(&self.axes) {
            if axis.bins == 1 {
                continue;
            }
            let last = (axis.bins - 1) as f64;
            let t = ((c - axis.range[0]) * axis.per_unit - 0.5).clamp(0.0, last);
            let i = (t as usize).min(axis.bins - 2);
            let share = t - i as f64;
            for n in 0..*count {
                let b = bins[n] * axis.bins as u16 + i as u16;
                (bins[n], bins[n + *count]) = (b, b + 1);
                shares[n + *count] = shares[n] * share;
                shares[n] *= 1.0 - share;
            }
            *count *= 2;
        }
        corners
    }

    /// The squared distance of two data, in bins.
    pub fn squared_distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let pairs = a.iter().zip(b).zip(&self.axes);
        pairs.map(|((a, b), axis)| ((a - b) * axis.per_unit).powi(2)).sum()
    }

    /// F: the filter (1, 2, 1)/4 along each coordinate, reflected at both ends, some times. It is symmetric, with row sums
    /// 1 and no negative entry.
    pub fn smooth(&self, values: &mut [f64]) {
        let mut stride = 1;
        for axis in self.axes.iter().rev() {
            let span = stride * axis.bins;
            for line in values.chunks_mut(span).filter(|_| axis.bins > 1) {
                for from in (0..stride).cycle().take(stride * self.passes) {
                    let mut before = line[from];
                    for i in 0..axis.bins {
                        let at = from + i * stride;
                        let (here, next) =
                            (line[at], line[if i + 1 < axis.bins { at + stride } else { at }]);
                        line[at] = 0.25 * (before + next) + 0.5 * here;
                        before = here;
                    }
                }
            }
            stride = span;
        }
    }
}

/// The range of the bins of one coordinate.
fn range(column: &[f64]) -> [f64; 2] {
    // f64::min and max ignore NaN.
    let (low, high) = column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
        (f64::min(low, x), f64::max(high, x))
    });
    if high - low <= EQUAL_WITHIN * f64::max(low.abs(), high.abs()) {
        return [low; 2];
    }
    let [from, to] = robust_range(column, &vec![1.0; column.len()]);
    if from == to {
        return [low, high];
    }
    let margin = MARGIN * (to - from);
    [f64::max(low, from - margin), f64::min(high, to + margin)]
}
