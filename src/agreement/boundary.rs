//! Precision and recall of the boundaries of labeled images.
//!
//! ```text
//! P = matched boundary pixels of the labeling / its boundary pixels          F = 2 P R / (P + R)
//! R = matched boundary pixels of the truth / its boundary pixels
//! ```
//!
//! Pixel (x, y) is on an edge if its label differs from that of (x + 1, y), (x, y + 1) or (x + 1, y + 1); unknown
//! pixels make no edge. Thinned edges (`thin.rs`) are the boundary. Its pixels are matched one to one within 0.0075 of
//! the diagonal of the image, as many as possible. Against several truths, a pixel of the labeling is correct if it is
//! matched with any of them, and R is the fraction of matched pixels of all truths together. Without boundary pixels P
//! or R is 1.
//!
//! Reference: D. R. Martin, C. C. Fowlkes, J. Malik, *Learning to Detect Natural Image Boundaries Using Local
//! Brightness, Color, and Texture Cues*, PAMI 26, 2004. The benchmark of the Berkeley data set does the same but for
//! ties: among the largest matchings it takes one of nearly smallest total distance, while here only the initial
//! matching prefers short distances. This concerns P against several truths, which depends on the pixels that are
//! matched, not on their number.

use serde::Serialize;

use super::bipartite::{disk, matched};
use super::thin::thin;
use crate::error::{Error, Result};

/// The largest distance of matched pixels, as a fraction of the diagonal.
pub const TOLERANCE: f64 = 0.0075;

/// Labelings whose edge pixels times the pixels within the distance exceed this number are refused.
pub const MAX_STEPS: u64 = 1 << 30;

/// Agreement of the boundaries of a labeling with one truth, or with all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Boundary {
    /// P, 0 to 1.
    pub precision: f64,
    /// R, 0 to 1.
    pub recall: f64,
    /// F, their harmonic mean; 0 if both are 0.
    pub f: f64,
}

/// Agreement of the boundaries of a labeling with several truths.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Boundaries {
    /// The largest distance of matched pixels.
    pub tolerance: f64,
    /// One per truth.
    pub each: Vec<Boundary>,
    /// All truths together.
    pub all: Boundary,
}

/// The labels of the vertices of a grid of `width` vertices per row, which are counted from the lower left, as an
/// image, row by row from the top.
pub fn grid_image(labels: &[i64], width: usize) -> Vec<i64> {
    labels.chunks(width).rev().flatten().copied().collect()
}

/// Compares the boundaries of an image of labels with those of one or more truths, all row by row from the top, `size`
/// = [width, height] pixels.
///
/// # Errors
/// The boundaries are too long to be matched, see [`MAX_STEPS`].
pub fn boundaries(labels: &[i64], truths: &[&[i64]], size: [usize; 2]) -> Result<Boundaries> {
    let [width, height] = size;
    assert!(!truths.is_empty(), "at least one truth");
    assert!(!labels.is_empty() && labels.len() == width * height, "one label per pixel");
    let tolerance = TOLERANCE * (width as f64).hypot(height as f64);
    let disk = disk(tolerance, size);
    let mut found = edges(labels, width);
    let edge_pixels = count(&found);
    if (edge_pixels as u64).saturating_mul(disk.len() as u64) > MAX_STEPS {
        return Err(Error::unsuitable(format!(
            "the labeling has {edge_pixels} boundary pixels in {width} x {height} pixels, too many to be matched within \
             {tolerance:.1} pixels"
        )));
    }
    thin(&mut found, width);
    let found_pixels = count(&found);
    let mut correct = vec![false; found_pixels];
    let (mut recalled, mut wanted) = (0, 0);
    let mut each = Vec::with_capacity(truths.len());
    for truth in truths {
        assert_eq!(truth.len(), labels.len(), "truths of the same size");
        let mut truth = edges(truth, width);
        thin(&mut truth, width);
        let matched = matched(&found, &truth, width, &disk);
        let (matches, truth_pixels) = (count(&matched), count(&truth));
        each.push(Boundary::new([matches, found_pixels], [matches, truth_pixels]));
        recalled += matches;
        wanted += truth_pixels;
        correct.iter_mut().zip(matched).for_each(|(correct, matched)| *correct |= matched);
    }
    let all = Boundary::new([count(&correct), found_pixels], [recalled, wanted]);
    Ok(Boundaries { tolerance, each, all })
}

impl Boundary {
    /// From the numbers of matched pixels and of pixels of the labeling, and of the truth.
    fn new(labeling: [usize; 2], truth: [usize; 2]) -> Self {
        let fraction = |[matched, all]: [usize; 2]| match all {
            0 => 1.0,
            _ => matched as f64 / all as f64,
        };
        let (precision, recall) = (fraction(labeling), fraction(truth));
        let sum = precision + recall;
        let f = if sum > 0.0 { 2.0 * precision * recall / sum } else { 0.0 };
        Boundary { precision, recall, f }
    }
}

fn count(set: &[bool]) -> usize {
    set.iter().filter(|&&member| member).count()
}

/// Whether each pixel is on an edge.
pub(super) fn edges(labels: &[i64], width: usize) -> Vec<bool> {
    let height = labels.len() / width;
    let differ = |a: i64, b: i64| a >= 0 && b >= 0 && a != b;
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let (right, below) = (x + 1 < width, y + 1 < height);
        right && differ(labels[at], labels[at + 1])
            || below && differ(labels[at], labels[at + width])
            || right && below && differ(labels[at], labels[at + width + 1])
    };
    (0..labels.len()).map(pixel).collect()
}
