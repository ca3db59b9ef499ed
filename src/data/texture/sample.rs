//! The colors of a face from a texture: at its corners, or their means over the corners' shares.
//!
//! A texture covers [0, 1]^2; v points upwards (the convention of OBJ), so the first row of the image is at v = 1.
//! Texel (i, row) of an N x H image is centered at ((i + 1/2) / N, 1 - (row + 1/2) / H), and between the centers colors
//! are bilinear.
//!
//! **Edges.** If the coordinates of a face lie in one tile [i, i + 1] x [j, j + 1], up to one texel, they are clamped,
//! so that the opposite edge of the image has no influence. On a face that crosses the border of a tile the image is
//! repeated, as in viewers. A clamped image has one copy, on [0, 1]^2, whose edges extend beyond it.
//!
//! **Shares.** The medians divide a face into six triangles of equal area, two at each corner. Each is sampled at the
//! centroids of k^2 equal triangles, with the smallest k for which no side is longer than 1.5 texels (a bilinear color
//! extends over two). If k would exceed `most`, a smaller image is sampled, with means of 2^l x 2^l texels.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::shrink::Channel;

/// The longest side of a triangle that is sampled once, in texels.
const MAX_SAMPLE_SPACING: f64 = 1.5;

/// The color that a vertex takes from a texture: the mean over its share of its faces, or the color at its own
/// position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Texel {
    /// The mean over its share of its faces. The default.
    #[default]
    Mean,
    /// The color at its texture coordinates; where those of its faces differ, the area-weighted mean.
    Vertex,
}

/// One level of a texture.
pub struct MipLevel<T> {
    pub width: usize,
    pub height: usize,
    /// Row by row from the upper left corner.
    pub texels: Vec<[T; 3]>,
    /// The length of [0, 1] in texels: not an integer if the last box is narrower.
    pub extent: [f64; 2],
}

/// How an image continues beyond its edges, along one axis.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Edge {
    Clamp,
    Repeat,
}

/// The position of a face in a texture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Footprint {
    /// The coordinates of its corners relative to the upper left corner of its tile, v downwards, as fractions of the
    /// image.
    corners: [[f64; 2]; 3],
    edges: [Edge; 2],
    /// Each of the six triangles is sampled k^2 times,
    k: u32,
    /// in the image shrunk by 2^level.
    pub level: usize,
}

/// The indices of the tile that contains most of a face: (0, 0) is [0, 1]^2, and a face on a border belongs to the
/// nearer tile.
#[inline(always)]
pub fn tile(uv: &[[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let middle = (uv[0][axis] + uv[1][axis] + uv[2][axis]) / 3.0;
        if middle > 0.0 { middle.ceil() - 1.0 } else { middle.floor() }
    })
}

impl Footprint {
    /// The footprint of a face with coordinates `uv` in an image for which [0, 1]^2 has `extent` texels; it takes at
    /// most 6 `most`^2 samples.
    #[inline(always)]
    pub fn new(uv: &[[f64; 2]; 3], extent: [f64; 2], clamp: bool, most: u32) -> Self {
        let tile = if clamp { [0.0; 2] } else { tile(uv) };
        let mut corners = *uv;
        for [u, v] in &mut corners {
            *u -= tile[0];
            *v = 1.0 - (*v - tile[1]);
        }
        let edges = [0, 1].map(|axis| {
            let texel = 1.0 / extent[axis];
            let inside = |corner: &[f64; 2]| (-texel..=1.0 + texel).contains(&corner[axis]);
            if clamp || corners.iter().all(inside) { Edge::Clamp } else { Edge::Repeat }
        });
        let length = longest(&corners, extent) / MAX_SAMPLE_SPACING;
        let k = (length.ceil() as u32).clamp(1, most);
        let spacing = length / f64::from(k);
        let level = if spacing > 1.0 { spacing.log2().ceil() as usize } else { 0 };
        Footprint { corners, edges, k, level }
    }

    /// The mean over the share of corner i, in units of the channels.
    #[inline(always)]
    pub fn mean<T: Channel>(&self, level: &MipLevel<T>, i: usize) -> [f64; 3] {
        let corners = self.in_texels(level);
        let [a, b, c] = [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]];
        let center = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
        let middle = |b: [f64; 2]| [0, 1].map(|axis| 0.5 * (a[axis] + b[axis]));
        let step = f64::from(self.k).recip();
        let mut sum = [0.0; 3];
        for other in [middle(b), middle(c)] {
            let to_other = [0, 1].map(|axis| step * (other[axis] - a[axis]));
            let to_center = [0, 1].map(|axis| step * (center[axis] - a[axis]));
            let mut add = |s: f64, t: f64| {
                let at = [0, 1].map(|axis| a[axis] + s * to_other[axis] + t * to_center[axis]);
                let color = level.bilinear(at, self.edges);
                for (sum, value) in sum.iter_mut().zip(color) {
                    *sum += value;
                }
            };
            for row in 0..self.k {
                for column in 0..self.k - row {
                    let (s, t) = (f64::from(column), f64::from(row));
                    add(s + 1.0 / 3.0, t + 1.0 / 3.0);
                    if column + row + 1 < self.k {
                        add(s + 2.0 / 3.0, t + 2.0 / 3.0);
                    }
                }
            }
        }
        let n = 2.0 * f64::from(self.k).powi(2);
        sum.map(|sum| sum / n)
    }

    /// The color at corner i, in units of the channels.
    #[inline(always)]
    pub fn corner<T: Channel>(&self, level: &MipLevel<T>, i: usize) -> [f64; 3] {
        level.bilinear(self.in_texels(level)[i], self.edges)
    }

    #[inline(always)]
    fn in_texels<T>(&self, level: &MipLevel<T>) -> [[f64; 2]; 3] {
        self.corners.map(|[u, v]| [u * level.extent[0], v * level.extent[1]])
    }
}

/// The longest side of the six triangles, in texels: half a side of the face, or two thirds of a median.
#[inline(always)]
fn longest(corners: &[[f64; 2]; 3], extent: [f64; 2]) -> f64 {
    let squared = |a: [f64; 2], b: [f64; 2]| {
        [0, 1].iter().map(|&axis| ((a[axis] - b[axis]) * extent[axis]).powi(2)).sum::<f64>()
    };
    let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let [a, b, c] = *corners;
    let at = |a, b, c| f64::max(squared(a, b) / 4.0, squared(a, middle(b, c)) * 4.0 / 9.0);
    at(a, b, c).max(at(b, c, a)).max(at(c, a, b)).sqrt()
}

/// The area of a face in texels of an image.
pub fn area(uv: &[[f64; 2]; 3], size: [f64; 2]) -> f64 {
    let [a, b, c] = *uv;
    let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    0.5 * doubled.abs() * size[0] * size[1]
}

impl<T: Channel> MipLevel<T> {
    /// The color at a point given in texels from the upper left corner.
    #[inline(always)]
    fn bilinear(&self, [x, y]: [f64; 2], edges: [Edge; 2]) -> [f64; 3] {
        let (left, right, s) = between(x, self.extent[0], self.width, edges[0]);
        let (up, down, t) = between(y, self.extent[1], self.height, edges[1]);
        let texel = |row: usize, i: usize| -> [f64; 3] {
            self.texels[row * self.width + i].map(Into::<f64>::into)
        };
        let (a, b) = (texel(up, left), texel(up, right));
        let (c, d) = (texel(down, left), texel(down, right));
        [0, 1, 2].map(|p| {
            let upper = a[p] + s * (b[p] - a[p]);
            let lower = c[p] + s * (d[p] - c[p]);
            upper + t * (lower - upper)
        })
    }
}

/// The two of n texels whose centers enclose a coordinate, and the weight of the second.
#[inline(always)]
fn between(x: f64, extent: f64, n: usize, edge: Edge) -> (usize, usize, f64) {
    match edge {
        Edge::Clamp => {
            let x = (x - 0.5).clamp(0.0, (n - 1) as f64);
            let before = x as usize;
            (before, (before + 1).min(n - 1), x - before as f64)
        }
        Edge::Repeat => {
            let x = x - extent * (x / extent).floor() - 0.5;
            if x < 0.0 {
                return (n - 1, 0, x + 1.0);
            }
            let before = (x as usize).min(n - 1);
            (before, if before + 1 == n { 0 } else { before + 1 }, (x - before as f64).min(1.0))
        }
    }
}
