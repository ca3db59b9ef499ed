//! What images say of each vertex, for the colors mu of any regions.
//!
//! ```text
//! W_k = sum_i omega_i / S^2 sum_samples phi_k        Q_k = .. phi_k |I|^2        C_k = .. phi_k I
//! f_kp = sigma ( Q_k - 2 mu_p.C_k + W_k |mu_p|^2 ) = sigma sum_i sum_samples omega_i / S^2 phi_k |I - mu_p|^2
//! ```
//!
//! Every sample of a pixel is a quadrature point, and the z-buffer is the visibility. On a surface element the image has
//! the area -det K (x.n) / z^3 dsigma with the outward normal n, x in the axes of the camera: the weight of Delaunoy et al.,
//! ICCV 2009, section 3.2, with the sign for visible faces.
//!
//! Samples that see the back of a face count nowhere: open surfaces show it.

use nalgebra::Vector3;

use super::options::ViewOptions;
use super::picture::Picture;
use super::selection::{LeftOut, Selection};
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::optics::zbuffer::ZBuffer;

/// W, Q and the three channels of C.
pub type Sums = [f64; 5];

/// How many pixels that show the surface count, and how many do not, by the first reason that holds for all their
/// samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCounts {
    pub used: u64,
    pub border: u64,
    pub masked: u64,
    pub mixed: u64,
    pub back: u64,
    pub grazing: u64,
}

/// The statistics of one view.
pub struct ViewStatistics {
    /// One row per vertex, with omega = 1.
    pub sums: Vec<Sums>,
    pub pixels: PixelCounts,
    /// Faces that reach behind the camera and were left out.
    pub behind: usize,
}

/// Sums over the pixels of one picture. No face of the mesh is degenerate.
pub fn of_view(
    mesh: &Mesh,
    camera: &Pinhole,
    picture: &Picture,
    options: &ViewOptions,
) -> ViewStatistics {
    let s = options.samples;
    let size = [picture.width, picture.height];
    let zbuffer = ZBuffer::new(mesh, camera, size, s);
    let selection = Selection::new(picture, &zbuffer, options);
    let center = camera.center();
    let cosine = |j: usize, beta: [f64; 3]| {
        let [a, b, c] = mesh.corners(j);
        let x: Vector3<f64> = a.coords * beta[0] + b.coords * beta[1] + c.coords * beta[2];
        let (ray, normal) = (center.coords - x, mesh.area_vector(j));
        ray.dot(&normal) / (ray.norm() * normal.norm())
    };
    let mut sums = vec![[0.0; 5]; mesh.vertices.len()];
    let mut pixels = PixelCounts::default();
    let share = 1.0 / (s * s) as f64;
    for row in 0..picture.height {
        for column in 0..picture.width {
            // Computed at the first sample that shows the surface.
            let mut color: Option<[f64; 4]> = None;
            let (mut covered, mut grazing, mut used) = (false, false, false);
            let mut reason = None;
            for sample in 0..s * s {
                let at = [column * s + sample % s, row * s + sample / s];
                let Some(j) = zbuffer.face(at[1] * zbuffer.width + at[0]) else { continue };
                if !covered {
                    covered = true;
                    reason = selection.left_out(column, row);
                }
                if reason.is_some() {
                    break;
                }
                let Some(beta) = zbuffer.front(j, at[0], at[1]) else { continue };
                if options.grazing > 0.0 && cosine(j, beta) < options.grazing {
                    grazing = true;
                    continue;
                }
                used = true;
                let [q, r, g, b] = *color.get_or_insert_with(|| {
                    let [r, g, b] = picture.color(row * picture.width + column);
                    [r * r + g * g + b * b, r, g, b]
                });
                for (k, beta) in mesh.faces[j].into_iter().zip(beta) {
                    let phi = share * beta;
                    let terms = [phi, phi * q, phi * r, phi * g, phi * b];
                    sums[k as usize].iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
                }
            }
            let count = match reason {
                _ if !covered => continue,
                _ if used => &mut pixels.used,
                Some(LeftOut::Border) => &mut pixels.border,
                Some(LeftOut::Masked) => &mut pixels.masked,
                Some(LeftOut::Mixed) => &mut pixels.mixed,
                None if grazing => &mut pixels.grazing,
                None => &mut pixels.back,
            };
            *count += 1;
        }
    }
    ViewStatistics { sums, pixels, behind: zbuffer.behind }
}
