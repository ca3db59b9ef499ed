//! What the images say of each vertex of a surface, for any regions:
//!
//! ```text
//! Q_k = sum_i omega_i / S^2 sum_samples phi_k |I|^2        C_k = .. phi_k s I        SS_k = .. phi_k s^2
//! f_kp = sigma ( Q_k - 2 mu_p.C_k + SS_k |mu_p|^2 )
//! mu_p = sum_k u_kp C_k / sum_k u_kp SS_k
//! ```
//!
//! The sums for mu can leave out the pixels whose color is nearer to the background than to all mu_p: while the surface
//! covers too much, they would pull the colors of the regions towards that of the background.

use super::coloring::Coloring;
use super::covered::{excess, pixel_of_columns};
use super::images::{Image, squared_distance};
use crate::mesh::Mesh;
use crate::optics::zbuffer::{Run, ZBuffer};
use crate::sweep;

/// The sums of this many views are in memory.
const VIEWS_AT_A_TIME: usize = 16;

/// The sums at a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// W, the weight of the samples.
    pub w: f64,
    /// Q.
    pub q: f64,
    /// Those of all samples.
    pub all: Moments,
    /// Those of the samples that are nearer to a region than to the background.
    pub nearer: Moments,
}

/// SS and C.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// SS.
    pub ss: f64,
    /// C.
    pub c: [f64; 3],
}

impl Moments {
    #[inline(always)]
    fn add(&mut self, ss: f64, c: [f64; 3]) {
        self.ss += ss;
        self.c.iter_mut().zip(c).for_each(|(sum, c)| *sum += c);
    }
}

impl Sums {
    fn add(&mut self, other: &Sums) {
        self.w += other.w;
        self.q += other.q;
        self.all.add(other.all.ss, other.all.c);
        self.nearer.add(other.nearer.ss, other.nearer.c);
    }

    /// f_kp without sigma, for the color of a region.
    pub fn cost(&self, mu: [f64; 3]) -> f64 {
        let Moments { ss, c: [r, g, b] } = self.all;
        let [x, y, z] = mu;
        self.q - 2.0 * (x * r + y * g + z * b) + ss * (x * x + y * y + z * z)
    }
}

/// The sums at all vertices, for S x S samples a pixel; `mu` decides which pixels are nearer to a region.
pub fn statistics(
    images: &[Image],
    mesh: &Mesh,
    shading: Option<&[f64]>,
    s: usize,
    mu: &[[f64; 3]],
) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); mesh.vertices.len()];
    for images in images.chunks(VIEWS_AT_A_TIME) {
        let views: Vec<&Image> = images.iter().collect();
        for view in sweep::results(views, |image| of_view(image, mesh, shading, s, mu)) {
            sums.iter_mut().zip(&view).for_each(|(sums, view)| sums.add(view));
        }
    }
    sums
}

fn of_view(
    image: &Image,
    mesh: &Mesh,
    shading: Option<&[f64]>,
    samples: usize,
    mu: &[[f64; 3]],
) -> Vec<Sums> {
    let zbuffer = ZBuffer::new(mesh, &image.camera, image.size(), samples);
    let pixel_of = pixel_of_columns(image, samples);
    let share = image.omega / (samples * samples) as f64;
    let mut sums = vec![Sums::default(); mesh.vertices.len()];
    zbuffer.runs(
        #[inline(always)]
        |Run { face, row, columns }| {
            let corners = mesh.faces[face].map(|k| k as usize);
            let planes = zbuffer.planes(face).along(columns.start, row);
            let pixels = &image.pixels[row / samples * image.width..][..image.width];
            let shading = shading.map(|shading| corners.map(|k| shading[k]));
            let mut of_face = [Sums::default(); 3];
            for (i, &pixel) in (0_i32..).zip(&pixel_of[columns]) {
                let over_z = planes.map(|[start, step]| start + f64::from(i) * step);
                let z = share / (over_z[0] + over_z[1] + over_z[2]);
                let pixel = &pixels[pixel as usize];
                let (color, excess) = excess(pixel);
                let q = excess + f64::from(pixel.beyond);
                let s = shading.map_or(1.0, |shading| {
                    let weighted: f64 = over_z.iter().zip(shading).map(|(l, s)| l * s).sum();
                    weighted * z / share
                });
                let lit = color.map(|c| s * c);
                let distance = |mu: &[f64; 3]| squared_distance(color, mu.map(|mu| s * mu));
                let nearer = mu.iter().any(|mu| distance(mu) < f64::from(pixel.beyond));
                for (sums, l) in of_face.iter_mut().zip(over_z) {
                    let phi = l * z;
                    let (ss, c) = (phi * s * s, lit.map(|c| phi * c));
                    sums.w += phi;
                    sums.q += phi * q;
                    sums.all.add(ss, c);
                    if nearer {
                        sums.nearer.add(ss, c);
                    }
                }
            }
            corners.into_iter().zip(&of_face).for_each(|(k, of_face)| sums[k].add(of_face));
        },
    );
    sums
}

/// The colors that minimize the energy for given U, from all pixels or from those that are nearer to a region than to the
/// background. A region without pixels keeps its color.
pub fn fit(coloring: &mut Coloring, sums: &[Sums], moments: impl Fn(&Sums) -> &Moments) {
    let m = coloring.regions();
    for p in 0..m {
        let mut total = Moments::default();
        for (u, sums) in coloring.u.chunks(m).zip(sums) {
            let Moments { ss, c } = moments(sums);
            total.add(u[p] * ss, c.map(|c| u[p] * c));
        }
        if total.ss > 0.0 {
            coloring.mu[p] = total.c.map(|c| c / total.ss);
        }
    }
}
