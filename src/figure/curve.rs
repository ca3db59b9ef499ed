//! What of a series can be drawn on the axes of its panel.

use super::layout::Frame;
use super::{Primitive, Scale, Series};

/// About the number of marks on a line.
const MARKS_PER_LINE: f64 = 8.0;
/// A vertex of a line that is closer in print to the one before it is left out.
const THINNED_DISTANCE: f64 = 0.1;
/// A shorter line would not be visible, and has a mark.
const SHORTEST_LINE: f64 = 1.5;
/// What a line does within this distance in print does not make it longer.
const NOISE_SIZE: f64 = 6.0;
/// Between marks on a line; a short line has fewer.
const LEAST_MARK_DISTANCE: f64 = 13.0;

/// All in the numbers of the data.
#[derive(Debug, Default)]
pub struct Curve {
    /// Closed outlines.
    pub areas: Vec<Vec<[f64; 2]>>,
    pub lines: Vec<Vec<[f64; 2]>>,
    /// x, low, high.
    pub bars: Vec<[f64; 3]>,
    pub marks: Vec<[f64; 2]>,
}

impl Curve {
    pub fn new(series: &Series, frame: &Frame) -> Self {
        let is_drawn = |scale: Scale, value: f64| scale.position(value).is_some();
        let (x, y) = (frame.x.scale, frame.y.scale);
        let points = runs(&series.points, |p| is_drawn(x, p[0]) && is_drawn(y, p[1]));
        let bands =
            runs(&series.band, |b| is_drawn(x, b[0]) && b[1..].iter().all(|&b| is_drawn(y, b)));
        if series.primitive == Primitive::Marks {
            return Curve { bars: bands.concat(), marks: points.concat(), ..Curve::default() };
        }
        let mut curve = Curve::default();
        for band in bands {
            if let [alone] = band[..] {
                curve.bars.push(alone);
                continue;
            }
            let side = |i: usize| {
                let side: Vec<[f64; 2]> = band.iter().map(|b| [b[0], b[i]]).collect();
                path(series.primitive, thinned(&side, THINNED_DISTANCE, frame))
            };
            let mut outline = side(1);
            outline.extend(side(2).into_iter().rev());
            curve.areas.push(outline);
        }
        for run in points {
            let run = thinned(&run, THINNED_DISTANCE, frame);
            if series.primitive == Primitive::LineMarks {
                curve.marks.extend(some(&run, series.style, frame));
            } else if series.primitive != Primitive::Reference
                && spaced(&run, SHORTEST_LINE, frame).len() == 1
            {
                curve.marks.push(run[0]);
            }
            curve.lines.push(path(series.primitive, run));
        }
        curve
    }
}

/// As much of a line as `count` points can show.
pub fn at_most(count: usize, line: &[[f64; 2]], frame: &Frame) -> Vec<[f64; 2]> {
    let mut thin = line.to_vec();
    let mut apart = THINNED_DISTANCE;
    while thin.len() > count {
        apart *= 2.0;
        thin = thinned(line, apart, frame);
    }
    thin
}

/// The stretches of drawable points.
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

/// Without the points that are closer in print than this to the one before them.
fn spaced(run: &[[f64; 2]], apart: f64, frame: &Frame) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for &point in run {
        if kept.last().is_none_or(|&before| distance(before, point, frame) >= apart) {
            kept.push(point);
        }
    }
    kept
}

/// The same, but both ends stay.
fn thinned(run: &[[f64; 2]], apart: f64, frame: &Frame) -> Vec<[f64; 2]> {
    let mut kept = spaced(run, apart, frame);
    if kept.last() != run.last() {
        kept.extend(run.last());
    }
    kept
}

/// Points at equal distances in print, which begin elsewhere for each style, so that the marks of lines that
/// run together do not hide each other.
fn some(run: &[[f64; 2]], style: usize, frame: &Frame) -> Vec<[f64; 2]> {
    if run.len() as f64 <= 1.5 * MARKS_PER_LINE {
        return run.to_vec();
    }
    // A noisy line is as long as one that passes through the noise.
    let coarse = spaced(run, NOISE_SIZE, frame);
    let length: f64 = coarse.windows(2).map(|pair| distance(pair[0], pair[1], frame)).sum();
    let apart = (length / MARKS_PER_LINE).max(LEAST_MARK_DISTANCE);
    // Multiples of the golden ratio are spread evenly, however many there are.
    let begin = apart * (0.1 + style as f64 * 0.618_034).fract();
    let first = run.iter().position(|&point| distance(run[0], point, frame) >= begin);
    spaced(&run[first.unwrap_or(0)..], apart, frame)
}
