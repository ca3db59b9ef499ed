//! The images that a surface is fitted to, at the resolution of a level.
//!
//! ```text
//! omega int_image e dw,     e = sum_p u_p |I - s mu_p|^2 where a ray meets the surface,   |I - b|^2 elsewhere
//! ```
//!
//! I is constant on a pixel. An image at 1/k of the resolution has the means of k x k pixels, of both I and b, and a pixel
//! of it weighs omega = k^2 of the pixels that it stands for, so that energies at different resolutions can be compared.

use nalgebra::{Point3, Vector3};

use super::silhouette::Silhouette;
use crate::data::views::{Picture, View};
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;

/// What is behind the surface.
pub enum Background {
    /// One color.
    Color([f64; 3]),
    /// An image of the same size.
    Picture(Picture),
    /// Black behind a white surface: the image itself is replaced by its mask.
    Mask,
}

/// A photograph, its camera and its background.
pub struct Shot {
    /// Its name and its camera.
    pub view: View,
    /// Its pixels. Those that its mask leaves out show the background.
    pub picture: Picture,
    /// What is behind the surface.
    pub background: Background,
}

/// A pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// I.
    pub color: [f32; 3],
    /// |I - b|^2.
    pub beyond: f32,
}

impl Pixel {
    /// A pixel of color I in front of b.
    pub fn new(color: [f64; 3], background: [f64; 3]) -> Self {
        let beyond = squared_distance(color, background) as f32;
        Pixel { color: color.map(|c| c as f32), beyond }
    }
}

/// The image of a view.
#[derive(Clone)]
pub struct Image {
    /// From the units of the mesh to pixels.
    pub camera: Pinhole,
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    /// omega, the weight of a pixel.
    pub omega: f64,
    /// Row by row.
    pub pixels: Vec<Pixel>,
}

impl Shot {
    /// Width and height of the image in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.picture.width, self.picture.height]
    }

    /// The pixels that show the surface, for a test of I and b; those that the mask leaves out do not.
    pub fn silhouette(&self, shows: impl Fn([f64; 3], [f64; 3]) -> bool) -> Silhouette {
        let [width, height] = self.size();
        let inside = |pixel: usize| {
            let [color, background] = self.colors(pixel);
            !self.picture.is_masked(pixel) && shows(color, background)
        };
        let inside = (0..width * height).map(inside).collect();
        Silhouette { camera: self.view.camera, size: self.size(), inside }
    }

    /// I and b of a pixel.
    fn colors(&self, pixel: usize) -> [[f64; 3]; 2] {
        let outside = self.picture.is_masked(pixel);
        let background = match &self.background {
            Background::Mask => return [[if outside { 0.0 } else { 1.0 }; 3], [0.0; 3]],
            Background::Color(color) => *color,
            Background::Picture(picture) => picture.color(pixel),
        };
        [if outside { background } else { self.picture.color(pixel) }, background]
    }

    /// The image at 1/k of the resolution; what is left of a row or column of k x k pixels is cut off.
    pub fn image(&self, k: usize) -> Image {
        let [width, height] = [self.picture.width, self.picture.height].map(|n| (n / k).max(1));
        let mut pixels = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let mut sum = [[0.0; 3]; 2];
                let mut count = 0.0;
                for y in row * k..((row + 1) * k).min(self.picture.height) {
                    for x in column * k..((column + 1) * k).min(self.picture.width) {
                        let colors = self.colors(y * self.picture.width + x);
                        let pairs = sum.as_flattened_mut().iter_mut().zip(colors.as_flattened());
                        pairs.for_each(|(sum, c)| *sum += c);
                        count += 1.0;
                    }
                }
                let [color, background] = sum.map(|sum| sum.map(|c| c / count));
                pixels.push(Pixel::new(color, background));
            }
        }
        let camera = self.view.camera.scaled(1.0 / k as f64);
        Image { camera, width, height, omega: (k * k) as f64, pixels }
    }
}

impl Image {
    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The image whose pixels cost nothing where they do not show the surface.
    pub fn without_background(mut self) -> Self {
        self.pixels.iter_mut().for_each(|pixel| pixel.beyond = 0.0);
        self
    }

    /// sum omega |I - b|^2, the energy of an empty image.
    pub fn empty(&self) -> f64 {
        self.omega * self.pixels.iter().map(|pixel| f64::from(pixel.beyond)).sum::<f64>()
    }
}

/// The length of a pixel on a surface: the median over the cameras in front of which its centroid is, if there is one.
pub fn pixel_length(cameras: &[Pinhole], mesh: &Mesh) -> Option<f64> {
    let sum: Vector3<f64> = mesh.vertices.iter().map(|x| x.coords).sum();
    let centroid = Point3::from(sum / mesh.vertices.len() as f64);
    let length =
        |camera: &Pinhole| camera.to_camera(centroid).z / camera.pixels_per_unit().abs().sqrt();
    let mut lengths: Vec<f64> = cameras.iter().map(length).filter(|l| *l > 0.0).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied()
}

/// |a - b|^2
#[inline(always)]
pub fn squared_distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
