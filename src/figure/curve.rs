//! The part of a series that can be drawn on the axes of its panel.

use super::layout::Frame;
use super::{Primitive, Scale, Series};

/// Approximate number of marks on a line.
const MARKS_PER_LINE: f64 = 8.0;
/// A vertex of a line that is closer to its predecessor, in points, is left out.
const MIN_VERTEX_DISTANCE: f64 = 0.1;
/// A shorter line gets a mark, since it would not be visible.
const MIN_LINE_LENGTH: f64 = 1.5;
/// Details of a line below this size, in points, do not count for its length.
const NOISE_SIZE: f64 = 6.0;
/// Minimum distance between marks on a line.
const MIN_MARK_DISTANCE: f64 = 13.0;

/// The drawn parts, in data coordinates.
#[derive(Debug, Default)]
pub struct Curve {
    /// Closed polygons.
    pub areas: Vec<Vec<[f64; 2]>>,
    pub lines: Vec<Vec<[f64; 2]>>,
    /// x, low, high.
    pub bars: Vec<[f64; 3]>,
    pub marks: Vec<[f64; 2]>,
    /// Where arrows upward start.
    pub arrows: Vec<[f64; 2]>,
}

impl Curve {
    pub fn new(series: &Series, frame: &Frame) -> Self {
        let is_drawn = |scale: Scale, value: f64| scale.position(value).is_some();
        let (x, y) = (frame.x.scale, frame.y.scale);
        let points = runs(&series.points, |p| is_drawn(x, p[0]) && is_drawn(y, p[1]));
        let bands =
            runs(&series.band, |b| is_drawn(x, b[0]) && b[1..].iter().all(|&b| is_drawn(y, b)));
        let arrows = runs(&series.beyond, |p| is_drawn(x, p[0]) && is_drawn(y, p[1])).concat();
        if series.primitive == Primitive::Marks {
            let marks = [points.concat(), arrows.clone()].concat();
            return Curve { bars: bands.concat(), marks, arrows, ..Curve::default() };
        }
        let mut curve = Curve { marks: arrows.clone(), arrows, ..Curve::default() };
        for band in bands {
            if let [alone] = band[..] {
                curve.bars.push(alone);
                continue;
            }
            let side = |i: usize| {
                let side: Vec<[f64; 2]> = band.iter().map(|b| [b[0], b[i]]).collect();
                path(series.primitive, thinned(&side, MIN_VERTEX_DISTANCE, frame))
            };
            let mut outline = side(1);
            outline.extend(side(2).into_iter().rev());
            curve.areas.push(outline);
        }
        for run in points {
            let run = thinned(&run, MIN_VERTEX_DISTANCE, frame);
            if series.primitive == Primitive::LineMarks {
                curve.marks.extend(mark_positions(&run, series.style, frame));
            } else if series.primitive != Primitive::Reference
                && spaced(&run, MIN_LINE_LENGTH, frame).len() == 1
            {
                curve.marks.push(run[0]);
            }
            curve.lines.push(path(series.primitive, run));
        }
        curve
    }
}

/// Thins a line to at most `count` points.
pub fn at_most(count: usize, line: &[[f64; 2]], frame: &Frame) -> Vec<[f64; 2]> {
    let mut thin = line.to_vec();
    let mut spacing = MIN_VERTEX_DISTANCE;
    while thin.len() > count {
        spacing *= 2.0;
        thin = thinned(line, spacing, frame);
    }
    thin
}

/// The runs of consecutive drawable points.
fn runs<const N: usize>(
    points: &[[f64; N]],
    drawable: impl Fn(&[f64; N]) -> bool,
) -> Vec<Vec<[f64; N]>> {
    points
        .split(|point| !drawable(point))
        .filter(|run| !run.is_empty())
        .map(<[_]>::to_vec)
        .collect()
}

fn path(primitive: Primitive, points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if primitive != Primitive::Steps {
        return points;
    }
    let corners = points.windows(2).flat_map(|pair| [pair[0], [pair[1][0], pair[0][1]]]);
    corners.chain(points.last().copied()).collect()
}

fn distance(a: [f64; 2], b: [f64; 2], frame: &Frame) -> f64 {
    let (a, b) = (frame.at(a), frame.at(b));
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The points without those that are closer than `spacing`, in points on the page, to their predecessor.
fn spaced(run: &[[f64; 2]], spacing: f64, frame: &Frame) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for &point in run {
        if kept.last().is_none_or(|&before| distance(before, point, frame) >= spacing) {
            kept.push(point);
        }
    }
    kept
}

/// Like [`spaced`], but keeps both ends.
fn thinned(run: &[[f64; 2]], spacing: f64, frame: &Frame) -> Vec<[f64; 2]> {
    let mut kept = spaced(run, spacing, frame);
    if kept.last() != run.last() {
        kept.extend(run.last());
    }
    kept
}

/// Points at equal distances on the page. They start at a different position for each style, so that the marks of lines
/// that coincide do not hide each other.
fn mark_positions(run: &[[f64; 2]], style: usize, frame: &Frame) -> Vec<[f64; 2]> {
    if run.len() as f64 <= 1.5 * MARKS_PER_LINE {
        return run.to_vec();
    }
    // The length of a noisy line is that of its average.
    let coarse = spaced(run, NOISE_SIZE, frame);
    let length: f64 = coarse.windows(2).map(|pair| distance(pair[0], pair[1], frame)).sum();
    let spacing = (length / MARKS_PER_LINE).max(MIN_MARK_DISTANCE);
    // The fractional parts of multiples of the golden ratio are evenly distributed.
    let begin = spacing * (0.1 + style as f64 * 0.618_034).fract();
    let first = run.iter().position(|&point| distance(run[0], point, frame) >= begin);
    spaced(&run[first.unwrap_or(0)..], spacing, frame)
}
