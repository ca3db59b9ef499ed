//! Synthetic data: a pattern of regions on any surface, a palette, and Gaussian noise.
//!
//! With u and v the angles around the axis z and around the circle of radius R in the plane z = 0, R the mean
//! distance of the vertices from that axis through their center,
//!
//! ```text
//! a = sin(3u + sin 2v),   b = sin(2v + cos 3u),   label = 2 [a > 0] + [b > 0]
//! ```
//!
//! for four regions; in general the sector of (a, b) in the plane. On a torus u and v are its angles. A checkerboard has
//! cubes instead of waves.

use std::f64::consts::TAU;

use nalgebra::Point3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::Data;
use crate::colormap::categorical;
use crate::mesh::Mesh;
use crate::mesh::extent::{BoundingBox, bounding_box};

/// The true labels and the noisy data.
pub struct Waves {
    /// The true region of each vertex.
    pub labels: Vec<usize>,
    /// One color per region.
    pub palette: Vec<[f64; 3]>,
    /// Colors with noise, not clipped.
    pub data: Data,
}

/// Four well-separated colors.
const PALETTE: [[f64; 3]; 4] =
    [[0.85, 0.2, 0.2], [0.2, 0.7, 0.3], [0.2, 0.3, 0.85], [0.9, 0.85, 0.2]];

/// One region is gray, so that all channels show its light.
const GRAY: [f64; 3] = [0.8; 3];

/// The cubes of a checkerboard along the longest side of the bounding box.
const CUBES: f64 = 6.0;

/// m colors.
fn palette(m: usize) -> Vec<[f64; 3]> {
    match m {
        1 => vec![GRAY],
        _ if m <= PALETTE.len() => PALETTE[..m].to_vec(),
        _ => (0..m).map(categorical).collect(),
    }
}

/// A checkerboard of m regions without noise: (i, j, k) numbers the cubes that the surface passes through, and the label is
/// i + j + k modulo m. Six cubes lie along the longest side of the bounding box.
pub fn checkerboard(mesh: &Mesh, m: usize) -> Waves {
    let BoundingBox { min, max } = bounding_box(mesh).expect("a mesh has vertices");
    let longest = (0..3).map(|i| max[i] - min[i]).fold(0.0, f64::max);
    let cube = |x: f64, low: f64| (CUBES * (x - low) / longest).floor() as i64;
    let label = |x: &Point3<f64>| {
        let number: i64 = (0..3).map(|i| cube(x[i], min[i])).sum();
        number.rem_euclid(m as i64) as usize
    };
    let labels: Vec<usize> = mesh.vertices.iter().map(label).collect();
    let palette = palette(m);
    let values = labels.iter().flat_map(|&label| palette[label]).collect();
    Waves { labels, palette, data: Data { dimension: 3, values } }
}

/// The labels of points by waves of m regions.
pub fn wave_labels(points: &[Point3<f64>], m: usize) -> Vec<usize> {
    let n = points.len() as f64;
    let center = points.iter().map(|x| x.coords).sum::<nalgebra::Vector3<f64>>() / n;
    let offsets: Vec<_> = points.iter().map(|x| x.coords - center).collect();
    let radius = offsets.iter().map(|x| x.x.hypot(x.y)).sum::<f64>() / n;
    offsets
        .iter()
        .map(|x| {
            let (u, v) = (x.y.atan2(x.x), x.z.atan2(x.x.hypot(x.y) - radius));
            let a = (3.0 * u + (2.0 * v).sin()).sin();
            let b = (2.0 * v + (3.0 * u).cos()).sin();
            match m {
                4 => 2 * usize::from(a > 0.0) + usize::from(b > 0.0),
                _ => ((b.atan2(a) / TAU).rem_euclid(1.0) * m as f64) as usize % m,
            }
        })
        .collect()
}

/// Waves of m regions with Gaussian noise of the given standard deviation, drawn by [`Pcg64`]. Panics if it is negative
/// or not finite.
pub fn waves(mesh: &Mesh, m: usize, noise: f64, seed: u64) -> Waves {
    let labels = wave_labels(&mesh.vertices, m);
    let palette = palette(m);
    let mut rng = Pcg64::seed_from_u64(seed);
    let noise = Normal::new(0.0, noise).expect("a finite deviation from 0");
    let values = labels
        .iter()
        .flat_map(|&label| palette[label])
        .map(|c| c + noise.sample(&mut rng))
        .collect();
    Waves { labels, palette, data: Data { dimension: 3, values } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::shape;

    /// The index form of the pattern on a torus of V_u x V_v vertices.
    #[test]
    fn waves_are_those_of_the_angles_of_a_torus() {
        let mesh = shape("torus:60x40");
        let waves = waves(&mesh, 4, 0.0, 0);
        let mut agree = 0;
        for (k, &label) in waves.labels.iter().enumerate() {
            let (u, v) = (TAU * (k / 40) as f64 / 60.0, TAU * (k % 40) as f64 / 40.0);
            let a = (3.0 * u + (2.0 * v).sin()).sin();
            let b = (2.0 * v + (3.0 * u).cos()).sin();
            // Where a or b is almost zero, rounding decides.
            let close = a.abs().min(b.abs()) < 1e-9;
            agree += usize::from(close || label == 2 * usize::from(a > 0.0) + usize::from(b > 0.0));
        }
        assert_eq!(agree, 2400);
    }

    #[test]
    fn every_region_appears_and_noise_has_its_variance() {
        let mesh = shape("sphere:4");
        for m in [2, 3, 4, 7, 16] {
            let waves = waves(&mesh, m, 0.3, 5);
            assert!((0..m).all(|p| waves.labels.contains(&p)), "{m}");
            let error = waves.labels.iter().enumerate().flat_map(|(k, &label)| {
                let (data, truth) = (waves.data.at(k), waves.palette[label]);
                (0..3).map(move |i| data[i] - truth[i]).collect::<Vec<_>>()
            });
            let errors: Vec<f64> = error.collect();
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let variance = errors.iter().map(|x| x * x).sum::<f64>() / errors.len() as f64;
            assert!(mean.abs() < 0.02 && (variance / 0.09 - 1.0).abs() < 0.05, "{mean} {variance}");
        }
    }

    #[test]
    fn the_seed_decides() {
        let mesh = shape("grid:9x9");
        let data = |seed| waves(&mesh, 3, 0.1, seed).data;
        assert_eq!(data(1), data(1));
        assert_ne!(data(1), data(2));
    }
}
