//! The energy of an image, on the samples that see the surface:
//!
//! ```text
//! omega int_image e dw = omega sum_pixels |I - b|^2  +  omega / S^2 sum_samples ( e - |I - b|^2 )
//! ```
//!
//! The first sum is that of an empty image, which does not depend on the surface.

use super::images::{Image, Pixel};
use super::scene::{Scene, cost_beyond_image};
use crate::optics::zbuffer::{Run, ZBuffer};

/// sum_samples ( e - |I - b|^2 ), for the z-buffer of an image with S x S samples a pixel.
pub fn sum(scene: &Scene, image: &Image, zbuffer: &ZBuffer, s: usize) -> f64 {
    let pixel_of = pixel_of_columns(image, s);
    let mut sum = 0.0;
    zbuffer.runs(
        #[inline(always)]
        |Run { face, row, columns }: Run| {
            let samples = Samples::new(scene, zbuffer, face, row, columns.start);
            let pixels = &image.pixels[row / s * image.width..][..image.width];
            for (i, &pixel) in (0_i32..).zip(&pixel_of[columns]) {
                let (color, excess) = excess(&pixels[pixel as usize]);
                let (look, s) = samples.at(i);
                sum += excess + cost_beyond_image(color, look, s);
            }
        },
    );
    sum
}

/// The pixel in the row of each column of samples.
pub fn pixel_of_columns(image: &Image, s: usize) -> Vec<u32> {
    (0..image.width * s).map(|column| (column / s) as u32).collect()
}

/// I, and |I|^2 - |I - b|^2.
#[inline(always)]
pub fn excess(pixel: &Pixel) -> ([f64; 3], f64) {
    let color = pixel.color.map(f64::from);
    let [r, g, b] = color;
    (color, r * r + g * g + b * b - f64::from(pixel.beyond))
}

/// v, w and s along a row of samples on a face.
struct Samples {
    /// Values over z at the first column, and their changes per column.
    looks: [[f64; 2]; 4],
    shading: Option<[f64; 2]>,
    nearness: [f64; 2],
}

impl Samples {
    #[inline(always)]
    fn new(scene: &Scene, zbuffer: &ZBuffer, face: usize, row: usize, column: usize) -> Self {
        let planes = zbuffer.planes(face).along(column, row);
        let corners = scene.mesh.faces[face].map(|k| k as usize);
        let over_z = |value: [f64; 3]| {
            [0, 1].map(|i| {
                planes[0][i] * value[0] + planes[1][i] * value[1] + planes[2][i] * value[2]
            })
        };
        let looks = corners.map(|k| &scene.looks[k]);
        Samples {
            looks: [0, 1, 2, 3].map(|c| over_z(looks.map(|look| look[c]))),
            shading: scene.shading.map(|shading| over_z(corners.map(|k| shading[k]))),
            nearness: over_z([1.0; 3]),
        }
    }

    #[inline(always)]
    fn at(&self, i: i32) -> ([f64; 4], f64) {
        let x = f64::from(i);
        let z = 1.0 / (self.nearness[0] + x * self.nearness[1]);
        let value = |[start, step]: [f64; 2]| (start + x * step) * z;
        (self.looks.map(value), self.shading.map_or(1.0, value))
    }
}
