//! The first colors of the regions: clusters of the pixels that do not show the background.
//!
//! Means of B x B pixels, B = 4, are clustered, so that noise does not bias the centers. A block is left out if its mean is
//! close to the background, and a quarter of the others is, those that vary most: they mix colors. Lloyd's iteration then
//! has one more center, which is pinned to the background, so that no color of a region comes near to it: such a region
//! would cost nothing where the surface covers too much.
//!
//! Under a light the colors are albedos: a block where the first surface has the mean shading s counts as mean / s, with the
//! weight s^2, and blocks that do not show it are left out.

use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::images::{Image, Shot, squared_distance};
use super::lit::Light;
use crate::data::kmeans::kmeans;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::optics::zbuffer::{Run, ZBuffer};
use crate::sweep;

/// B.
const BLOCK: usize = 4;

/// Means within this squared distance of the background are background.
const NEAR_BACKGROUND: f64 = 0.01;

/// The share of the blocks that are clustered.
const KEPT: f64 = 0.75;

/// Lloyd's steps with the pinned center.
const STEPS: usize = 20;

/// A block of pixels.
struct Block {
    mean: [f64; 3],
    /// The sum of the variances of the channels.
    variance: f64,
    /// The squared distance of the mean from the background.
    beyond: f64,
    /// s; 1 without a light.
    shading: f64,
}

/// Darker blocks say nothing of albedos.
const MIN_SHADING: f64 = 0.1;

/// The colors of m regions, or their albedos under a light, for which `start` is the first surface.
///
/// # Errors
/// Every pixel shows the background.
pub fn colors(
    shots: &[Shot],
    m: usize,
    seed: u64,
    start: &Mesh,
    light: Option<Light>,
) -> Result<Vec<[f64; 3]>> {
    let shading = light.map(|light| light.shading(start));
    let of_shot = |shot: &Shot| {
        let image = shot.image(1);
        blocks(&image, shading.as_ref().map(|shading| shadings(&image, start, shading)).as_deref())
    };
    let blocks = sweep::results(shots.iter().collect(), of_shot);
    let mut blocks: Vec<Block> = blocks.into_iter().flatten().collect();
    let mut variances: Vec<f64> = blocks.iter().map(|block| block.variance).collect();
    variances.sort_by(f64::total_cmp);
    // The mean of B^2 pixels of pure background is within three deviations of it.
    let noise = variances.get(variances.len() / 2).copied().unwrap_or(0.0);
    let tolerance = NEAR_BACKGROUND.max(9.0 * noise / (BLOCK * BLOCK) as f64);
    blocks.retain(|block| block.beyond > tolerance);
    let is_lit = |block: &Block| block.shading >= MIN_SHADING;
    // A first surface in the wrong place shows nothing of the light.
    if blocks.iter().any(is_lit) {
        blocks.retain(is_lit);
    } else {
        blocks.iter_mut().for_each(|block| block.shading = 1.0);
    }
    if blocks.is_empty() {
        return Err(Error::unsuitable(
            "every pixel of the images has the color of the background; give the color behind the surface with --background",
        ));
    }
    blocks.sort_by(|a, b| a.variance.total_cmp(&b.variance));
    blocks.truncate((KEPT * blocks.len() as f64).ceil() as usize);
    let means: Vec<f64> =
        blocks.iter().flat_map(|block| block.mean.map(|c| c / block.shading)).collect();
    let weights: Vec<f64> = blocks.iter().map(|block| block.shading * block.shading).collect();
    let centers = kmeans(&means, 3, &weights, m, &mut Pcg64::seed_from_u64(seed));
    let mut mu: Vec<[f64; 3]> =
        centers.iter().map(|center| [center[0], center[1], center[2]]).collect();
    for _ in 0..STEPS {
        let mut sums = vec![([0.0; 3], 0.0); m];
        for block in &blocks {
            let s = block.shading;
            let (p, distance) = nearest(block.mean.map(|c| c / s), &mu);
            if s * s * distance < block.beyond {
                sums[p].0.iter_mut().zip(block.mean).for_each(|(sum, c)| *sum += s * c);
                sums[p].1 += s * s;
            }
        }
        for (mu, (sum, count)) in mu.iter_mut().zip(sums) {
            if count > 0.0 {
                *mu = sum.map(|c| c / count);
            }
        }
    }
    Ok(mu)
}

/// The nearest color, and its squared distance.
fn nearest(color: [f64; 3], mu: &[[f64; 3]]) -> (usize, f64) {
    let distances = mu.iter().map(|&mu| squared_distance(color, mu)).enumerate();
    distances.fold((0, f64::INFINITY), |best, other| if other.1 < best.1 { other } else { best })
}

/// The shading of a surface in each pixel of an image; 0 where it is not seen.
fn shadings(image: &Image, mesh: &Mesh, shading: &[f64]) -> Vec<f64> {
    let zbuffer = ZBuffer::new(mesh, &image.camera, image.size(), 1);
    let mut shadings = vec![0.0; image.width * image.height];
    zbuffer.runs(|Run { face, row, columns }: Run| {
        let corners = mesh.faces[face].map(|k| shading[k as usize]);
        let planes = zbuffer.planes(face).along(columns.start, row);
        let pixels = &mut shadings[row * image.width..][columns];
        for (i, pixel) in (0_i32..).zip(pixels) {
            let over_z = planes.map(|[start, step]| start + f64::from(i) * step);
            let sum: f64 = over_z.iter().zip(corners).map(|(l, s)| l * s).sum();
            *pixel = sum / over_z.iter().sum::<f64>();
        }
    });
    shadings
}

/// The blocks of an image, with the shading of its pixels if there is a light; an image that is smaller than a block is one.
fn blocks(image: &Image, shading: Option<&[f64]>) -> Vec<Block> {
    let [columns, rows] = image.size().map(|n| (n / BLOCK).max(1));
    let mut found = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let (mut sum, mut squares, mut beyond, mut count) = ([0.0; 3], 0.0, 0.0, 0.0);
            // The mean, or 0 if a pixel does not show the surface.
            let (mut light, mut is_seen) = (0.0, true);
            for y in row * BLOCK..((row + 1) * BLOCK).min(image.height) {
                for x in column * BLOCK..((column + 1) * BLOCK).min(image.width) {
                    let pixel = image.pixels[y * image.width + x];
                    let s = shading.map_or(1.0, |shading| shading[y * image.width + x]);
                    (light, is_seen) = (light + s, is_seen && s > 0.0);
                    let color = pixel.color.map(f64::from);
                    sum.iter_mut().zip(color).for_each(|(sum, c)| *sum += c);
                    squares += color.iter().map(|c| c * c).sum::<f64>();
                    beyond += f64::from(pixel.beyond);
                    count += 1.0;
                }
            }
            let mean = sum.map(|c| c / count);
            let variance = (squares / count - mean.iter().map(|c| c * c).sum::<f64>()).max(0.0);
            // mean |I - b|^2 = |mean I - b|^2 + variance, for a background that is constant on the block.
            let shading = if is_seen { light / count } else { 0.0 };
            found.push(Block { mean, variance, beyond: beyond / count - variance, shading });
        }
    }
    found
}
