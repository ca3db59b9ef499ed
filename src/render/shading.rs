//! Light: a key light from the upper left, a fill from the right, and a sky that is brighter above, all white
//! and fixed to the camera, on a surface that is nearly Lambertian.
//!
//! The lights add up to about one on surfaces that face the key light, so that data keep their colors there.
//! A faint highlight gives form to black regions. Everything is linear light; sRGB is IEC 61966-2-1.

use nalgebra::Vector3;

use super::camera::Camera;
use crate::mesh::Mesh;

const KEY: Vector3<f32> = Vector3::new(-0.42, 0.55, 0.722);
const FILL: Vector3<f32> = Vector3::new(0.75, 0.05, 0.66);
/// Half-way between the key light and the viewer.
const HIGHLIGHT: Vector3<f32> = Vector3::new(-0.226, 0.296, 0.928);

/// The light that a surface of a given normal sends to the viewer.
pub(super) struct Light {
    /// The factor on the surface's color.
    pub diffuse: f32,
    /// White added to it.
    pub highlight: f32,
}

impl Light {
    /// For a unit normal in the camera's axes.
    fn on(normal: &Vector3<f32>) -> Self {
        let key = normal.dot(&KEY).max(0.0);
        let fill = normal.dot(&FILL).max(0.0);
        let sky = 0.5 + 0.5 * normal.y;
        Light {
            diffuse: (0.26 + 0.15 * sky + 0.58 * key + 0.22 * fill).min(1.0),
            highlight: 0.035 * normal.dot(&HIGHLIGHT).max(0.0).powi(24),
        }
    }
}

/// The corner normals in the camera's axes, each face turned towards the viewer: both sides are lit.
pub(super) fn towards_viewer(
    mesh: &Mesh,
    camera: &Camera,
    normals: &[[Vector3<f32>; 3]],
) -> Vec<[Vector3<f32>; 3]> {
    (0..mesh.faces.len())
        .map(|j| {
            let face = camera.rotate(mesh.area_vector(j));
            let ray = camera.to_eye(mesh.corners(j)[0]);
            let sign = if face.dot(&ray) < 0.0 { -1.0 } else { 1.0 };
            normals[j].map(|n| sign * camera.rotate(n.cast::<f64>()).cast::<f32>())
        })
        .collect()
}

/// The light at sample i on face j, with the barycentric coordinates there.
pub(super) fn light(normals: &[Vector3<f32>; 3], barycentric: &[f64; 3]) -> Light {
    let mut normal = Vector3::zeros();
    for (n, &b) in normals.iter().zip(barycentric) {
        normal += *n * b as f32;
    }
    Light::on(&normal.try_normalize(0.0).unwrap_or_else(Vector3::zeros))
}

pub(super) fn linear_from_srgb(color: [f64; 3]) -> [f32; 3] {
    color.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
}

pub(super) fn srgb_byte_from_linear(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}
