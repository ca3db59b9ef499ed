//! Masks of photographs whose background has another color than the surface.
//!
//! A pixel is kept if w.I > t, and if it is in the largest part of such pixels that are connected by their sides.

use std::str::FromStr;

use super::picture::Picture;
use crate::triple::Triple;

/// w and t, as a text `R,G,B > T`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaskRule {
    /// w, for colors from 0 to 1.
    pub weights: [f64; 3],
    /// t.
    pub above: f64,
}

impl FromStr for MaskRule {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts = text.split_once('>');
        let numbers = parts.and_then(|(weights, above)| {
            let Triple(weights) = weights.trim().parse().ok()?;
            Some(MaskRule { weights, above: above.trim().parse().ok()? })
        });
        let finite =
            |rule: &MaskRule| rule.weights.iter().chain([&rule.above]).all(|x| x.is_finite());
        numbers
            .filter(finite)
            .ok_or("must be \"R,G,B > T\", such as \"1,0,-1 > 0.08\" for pixels that are more red than blue")
    }
}

impl MaskRule {
    /// Whether each pixel is kept, row by row.
    pub fn mask(&self, picture: &Picture) -> Vec<bool> {
        let (width, count) = (picture.width, picture.width * picture.height);
        let above = |pixel: usize| {
            let color = picture.color(pixel);
            color.iter().zip(self.weights).map(|(c, w)| c * w).sum::<f64>() > self.above
        };
        let mut waiting: Vec<bool> = (0..count).map(above).collect();
        let mut largest = Vec::new();
        for first in 0..count {
            if !waiting[first] {
                continue;
            }
            waiting[first] = false;
            let mut part = vec![first];
            let mut next = 0;
            while let Some(&pixel) = part.get(next) {
                next += 1;
                let (x, up, down) = (pixel % width, pixel.checked_sub(width), pixel + width);
                let left = (x > 0).then(|| pixel - 1);
                let right = (x + 1 < width).then_some(pixel + 1);
                let below = (down < count).then_some(down);
                for neighbor in [left, right, up, below].into_iter().flatten() {
                    if std::mem::take(&mut waiting[neighbor]) {
                        part.push(neighbor);
                    }
                }
            }
            if part.len() > largest.len() {
                largest = part;
            }
        }
        let mut mask = vec![false; count];
        largest.into_iter().for_each(|pixel| mask[pixel] = true);
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A red square and a smaller one, which a blue line divides; pixels that touch at corners are not connected.
    #[test]
    fn the_largest_red_part_is_kept() {
        let rule: MaskRule = "1, 0, -1 > 0.08".parse().unwrap();
        assert_eq!(rule, MaskRule { weights: [1.0, 0.0, -1.0], above: 0.08 });
        let red = |x: usize, y: usize| {
            (x < 4 && y < 4) || (x == 4 && y == 4) || (x > 5 && y < 3) || (x, y) == (0, 7)
        };
        let color = |x, y| if red(x, y) { [0.5, 0.1, 0.3] } else { [0.5, 0.1, 0.45] };
        let mask = rule.mask(&Picture::of(9, 8, color));
        let kept = |i: usize| i % 9 < 4 && i / 9 < 4;
        assert!(mask.iter().enumerate().all(|(i, &mask)| mask == kept(i)));
        let none = MaskRule { above: 0.3, ..rule }.mask(&Picture::of(9, 8, color));
        assert!(none.iter().all(|mask| !mask));
        for text in ["1,0 > 0.1", "1,0,-1", "1,0,-1 > x", "1,0,nan > 0", "1,0,-1 >"] {
            assert!(text.parse::<MaskRule>().unwrap_err().contains("R,G,B > T"), "{text}");
        }
    }
}
