//! The picture of a segmentation: the data at the left, its regions and their cut at the right.
//!
//! A software z-buffer with 16 samples a pixel, averaged in linear light. Both halves are seen by one camera,
//! chosen to show the cut, under one light, so that only their colors differ. The same input gives the same
//! bytes.

mod bands;
mod camera;
pub mod colormap;
mod labels;
mod normals;
mod shading;
#[cfg(test)]
mod tests;
mod view;
mod visibility;

use std::f64::consts::FRAC_PI_4;

use image::RgbImage;
use nalgebra::Vector3;

use crate::mesh::Mesh;
use bands::for_each_row;
use camera::Camera;
use labels::LabelField;
use shading::{light, linear_from_srgb, srgb_byte_from_linear};
use visibility::Visibility;

/// Each half of the picture is this many pixels wide and high.
const HALF: usize = 800;
/// Samples a pixel, along each axis.
const SAMPLES: usize = 4;
/// The width of the cut, in pixels.
const CUT_WIDTH: f64 = 3.0;
/// A cut that would cover more than this share of the surface, as noise does, is drawn thinner: the regions
/// should still show.
const CUT_COVER: f64 = 0.15;
/// The color of the cut, in sRGB.
const CUT_COLOR: [f64; 3] = [0.86, 0.05, 0.09];

/// A picture of 1600 x 800 pixels.
///
/// `data_colors` are V colors and `segment_colors` m colors, sRGB in [0, 1]; `u` is the field U, V x m in row
/// order. Vertices and faces of any size, place and orientation will do; a mesh without area gives a white
/// picture.
pub fn preview(
    mesh: &Mesh,
    data_colors: &[[f64; 3]],
    segment_colors: &[[f64; 3]],
    u: &[f64],
) -> RgbImage {
    let scene = Scene::new(mesh, data_colors, segment_colors, u);
    scene.map_or_else(
        || RgbImage::from_pixel(2 * HALF as u32, HALF as u32, image::Rgb([255; 3])),
        |scene| {
            let field = LabelField::new(&scene.mesh, &scene.u, segment_colors.len());
            scene.draw(&view::choose(&scene.mesh, &scene.component, &field), HALF)
        },
    )
}

/// The referenced part of the mesh, moved and scaled into the unit ball, with colors in linear light.
struct Scene {
    mesh: Mesh,
    /// A representative of each vertex's connected component.
    component: Vec<u32>,
    u: Vec<f64>,
    data: Vec<[f32; 3]>,
    regions: Vec<[f32; 3]>,
}

impl Scene {
    /// None if there is nothing to see.
    fn new(
        mesh: &Mesh,
        data_colors: &[[f64; 3]],
        segment_colors: &[[f64; 3]],
        u: &[f64],
    ) -> Option<Self> {
        let (count, m) = (mesh.vertices.len(), segment_colors.len());
        assert!(m > 0 && data_colors.len() == count && u.len() == count * m);
        let mut index = vec![u32::MAX; count];
        let mut referenced = Vec::new();
        let mut faces = mesh.faces.clone();
        for v in faces.iter_mut().flatten() {
            let k = *v as usize;
            if index[k] == u32::MAX {
                index[k] = referenced.len() as u32;
                referenced.push(k);
            }
            *v = index[k];
        }
        let points = || referenced.iter().map(|&k| mesh.vertices[k].coords);
        if !points().all(|x| x.iter().all(|c| c.is_finite())) {
            return None;
        }
        let low = points().reduce(|a, b| a.inf(&b))?;
        let high = points().reduce(|a, b| a.sup(&b))?;
        let (center, radius) = (low + (high - low) / 2.0, (high - low).norm() / 2.0);
        if !(radius > 0.0 && radius.is_finite()) {
            return None;
        }
        let mesh = Mesh::new(points().map(|x| ((x - center) / radius).into()).collect(), faces);
        Some(Scene {
            component: visibility::components(&mesh),
            mesh,
            u: referenced.iter().flat_map(|&k| &u[k * m..(k + 1) * m]).copied().collect(),
            data: referenced.iter().map(|&k| linear_from_srgb(data_colors[k])).collect(),
            regions: segment_colors.iter().copied().map(linear_from_srgb).collect(),
        })
    }

    /// Both halves, each of half x half pixels.
    fn draw(&self, camera: &Camera, half: usize) -> RgbImage {
        let visibility = Visibility::new(&self.mesh, &self.component, camera, half * SAMPLES);
        let field = LabelField::new(&self.mesh, &self.u, self.regions.len());
        let regions = field.seen(&visibility);
        let crossings = field.crossings(&visibility, &regions);
        // A line of random direction crosses 4 / pi steps of the grid for each of its length.
        let length = crossings.len() as f64 * FRAC_PI_4;
        let width_at_cover = CUT_COVER * visibility.surface() as f64 / length;
        let radius = 0.5 * width_at_cover.min(CUT_WIDTH * SAMPLES as f64);
        let cut = labels::thicken(&visibility, &crossings, radius);
        let normals = normals::corner_normals(&self.mesh);
        let normals = shading::towards_viewer(&self.mesh, camera, &normals);
        let cut_color = linear_from_srgb(CUT_COLOR);

        // The colors of sample i in the two halves.
        let sample = |i: usize| -> [[f32; 3]; 2] {
            let Some(j) = visibility.face(i) else {
                return [[1.0; 3]; 2];
            };
            let barycentric = visibility.barycentric(j, i);
            let light = light(&normals[j], &barycentric);
            let lit = |color: [f32; 3]| color.map(|c| c * light.diffuse + light.highlight);
            let mut data = [0.0; 3];
            for (&v, &b) in self.mesh.faces[j].iter().zip(&barycentric) {
                for (sum, c) in data.iter_mut().zip(self.data[v as usize]) {
                    *sum += b as f32 * c;
                }
            }
            let (region, line) =
                (lit(self.regions[regions[i] as usize]), f32::from(cut[i]) / 255.0);
            let mixed = [0, 1, 2].map(|c| region[c] + line * (cut_color[c] - region[c]));
            [lit(data), mixed]
        };

        let mut bytes = vec![0; 2 * half * half * 3];
        for_each_row(&mut bytes, 2 * half * 3, |y, line| {
            let (left, right) = line.split_at_mut(half * 3);
            for (x, pixels) in left.chunks_mut(3).zip(right.chunks_mut(3)).enumerate() {
                let mut sum = [Vector3::<f32>::zeros(); 2];
                for row in y * SAMPLES..(y + 1) * SAMPLES {
                    for column in x * SAMPLES..(x + 1) * SAMPLES {
                        let colors = sample(row * half * SAMPLES + column);
                        for (sum, color) in sum.iter_mut().zip(colors) {
                            *sum += Vector3::from(color);
                        }
                    }
                }
                let mean = sum.map(|sum| sum / (SAMPLES * SAMPLES) as f32);
                for (pixel, mean) in [pixels.0, pixels.1].into_iter().zip(mean) {
                    for (byte, &c) in pixel.iter_mut().zip(mean.iter()) {
                        *byte = srgb_byte_from_linear(c);
                    }
                }
            }
        });
        RgbImage::from_raw(2 * half as u32, half as u32, bytes).expect("the buffer has the size")
    }
}
