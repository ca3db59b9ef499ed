//! The gradient of the energy of an image where rays meet the surface: the ray keeps still, and U slides along it.
//!
//! ```text
//! dE/dX_a += omega / S^2 sum_samples beta_a [ (q.d)/(N.d) N - q ],     q = sum_p c_p g_p + e_s g_s
//! g_p = sum_a u_ap grad beta_a,   grad beta_1 = N x (x3 - x2) / |N|^2 and cyclic,   N = (x2 - x1) x (x3 - x1)
//! c_p = |I - s mu_p|^2,   e_s = -2 sum_p u_p mu_p.(I - s mu_p),   g_s: the gradient of s
//! dE/ds_a = omega / S^2 sum_samples beta_a e_s
//! ```
//!
//! in the axes of the camera. With v and w of `coloring.rs` and their gradients, q = -2 s sum_c I_c grad v_c + s^2 grad w +
//! e_s grad s and e_s = -2 I.v + 2 s w, without a sum over regions. No derivative of the image is needed.

use nalgebra::{Matrix3, Vector3};

use super::covered::{excess, pixel_of_columns};
use super::images::Image;
use super::scene::{Scene, Seen, cost_beyond_image};
use crate::optics::zbuffer::{Run, ZBuffer};

/// What the samples of one image sum to.
pub struct Interior {
    /// sum_samples ( e - |I - b|^2 ), as in `covered.rs`.
    pub covered: f64,
    /// dE/ds_a; empty without a shading.
    pub by_shading: Vec<f64>,
}

/// Adds the gradient, in the axes of the camera and without the factor omega / S^2.
pub fn add_gradient(
    scene: &Scene,
    image: &Image,
    seen: &Seen,
    zbuffer: &ZBuffer,
    s: usize,
    gradient: &mut [Vector3<f64>],
) -> Interior {
    let pixel_of = pixel_of_columns(image, s);
    let scaled = image.camera.scaled(s as f64);
    let ray_step = scaled.ray([1.0, 0.0]) - scaled.ray([0.0, 0.0]);
    let mut by_shading = vec![0.0; scene.shading.map_or(0, <[f64]>::len)];
    let mut covered = 0.0;
    zbuffer.runs(
        #[inline(always)]
        |Run { face, row, columns }: Run| {
            let corners = scene.mesh.faces[face].map(|k| k as usize);
            let slopes = Slopes::new(scene, seen, corners);
            let planes = zbuffer.planes(face).along(columns.start, row);
            let pixels = &image.pixels[row / s * image.width..][..image.width];
            let looks = corners.map(|k| scene.looks[k]);
            let shading = scene.shading.map(|shading| corners.map(|k| shading[k]));
            let first_ray = scaled.ray([columns.start as f64, row as f64]);
            // Sums of beta_a q, of beta_a (q.d)/(N.d), and of beta_a e_s.
            let mut along = [Vector3::zeros(); 3];
            let mut across = [0.0; 3];
            let mut lit = [0.0; 3];
            for (i, &pixel) in (0_i32..).zip(&pixel_of[columns]) {
                let x = f64::from(i);
                let over_z = planes.map(|[start, step]| start + x * step);
                let z = 1.0 / (over_z[0] + over_z[1] + over_z[2]);
                let beta = over_z.map(|value| value * z);
                let mean = |values: [f64; 3]| {
                    beta[0] * values[0] + beta[1] * values[1] + beta[2] * values[2]
                };
                let look = [0, 1, 2, 3].map(|c| mean([looks[0][c], looks[1][c], looks[2][c]]));
                let (color, excess) = excess(&pixels[pixel as usize]);
                let s = shading.map_or(1.0, mean);
                covered += excess + cost_beyond_image(color, look, s);
                let factor = -2.0 * s;
                let mut q = slopes.of_colors * Vector3::from(color.map(|c| factor * c));
                q += s * s * slopes.of_squares;
                if shading.is_some() {
                    let [r, g, b, w] = look;
                    let by_s = 2.0 * (s * w - (color[0] * r + color[1] * g + color[2] * b));
                    q += by_s * slopes.of_shading;
                    (0..3).for_each(|a| lit[a] += beta[a] * by_s);
                }
                let d = first_ray + x * ray_step;
                // N.d = N.x / z on the face.
                let ratio = q.dot(&d) * z * slopes.inverse_offset;
                for a in 0..3 {
                    along[a] += beta[a] * q;
                    across[a] += beta[a] * ratio;
                }
            }
            for (a, k) in corners.into_iter().enumerate() {
                gradient[k] += across[a] * slopes.normal - along[a];
            }
            if shading.is_some() {
                corners.into_iter().zip(lit).for_each(|(k, lit)| by_shading[k] += lit);
            }
        },
    );
    Interior { covered, by_shading }
}

/// The geometry of a face, and the gradients of what is linear on it, in the axes of the camera.
struct Slopes {
    /// N.
    normal: Vector3<f64>,
    /// 1 / N.x for any x of the face.
    inverse_offset: f64,
    /// grad v, a column per channel.
    of_colors: Matrix3<f64>,
    /// grad w.
    of_squares: Vector3<f64>,
    /// grad s.
    of_shading: Vector3<f64>,
}

impl Slopes {
    #[inline(always)]
    fn new(scene: &Scene, seen: &Seen, corners: [usize; 3]) -> Self {
        let [x1, x2, x3] = corners.map(|k| seen.points[k]);
        let normal = (x2 - x1).cross(&(x3 - x1));
        let inverse = 1.0 / normal.norm_squared();
        let of_beta = [x3 - x2, x1 - x3, x2 - x1].map(|edge| inverse * normal.cross(&edge));
        let gradient = |values: [f64; 3]| {
            values[0] * of_beta[0] + values[1] * of_beta[1] + values[2] * of_beta[2]
        };
        let looks = corners.map(|k| scene.looks[k]);
        let of_look = |c: usize| gradient([looks[0][c], looks[1][c], looks[2][c]]);
        let of_shading = scene.shading.map(|shading| gradient(corners.map(|k| shading[k])));
        Slopes {
            normal,
            inverse_offset: 1.0 / normal.dot(&x1),
            of_colors: Matrix3::from_columns(&[of_look(0), of_look(1), of_look(2)]),
            of_squares: of_look(3),
            of_shading: of_shading.unwrap_or_default(),
        }
    }
}
