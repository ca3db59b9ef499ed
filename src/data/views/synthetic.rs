//! Synthetic photographs: what calibrated cameras see of a colored surface.
//!
//! ```text
//! I(w) = 1/S^2 sum_samples s(x) c(x) + noise        b instead of s(x) c(x) where a ray misses the surface
//! s_k  = A + max(0, N_k.L)        N_k = sum of the area vectors of the faces at k, normalized; |L| = 1
//! ```
//!
//! x is the first point of the surface on the ray of a sample. Either c is linear on faces, or the surface has labels,
//! and c is the color of the region of the nearest corner, the one with the largest barycentric coordinate. s is linear
//! on faces. The ambient light A alone is a constant factor; A = 1 is no shading. The noise of each channel of each
//! pixel is independent and normally distributed. Both sides of a face have the same color.
//!
//! Reference for the model of the light: Delaunoy et al., ICCV 2009, section 3.2.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::view::View;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::optics::zbuffer::ZBuffer;
use crate::sweep;

/// The largest number of pixels that is read as an image of a view.
const MAX_PIXELS: u64 = 1 << 26;
/// About as many samples are in memory at a time.
const SAMPLES_AT_A_TIME: usize = 1 << 22;

/// The color of the surface.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// A color per vertex, linear on faces.
    Vertices(&'a [[f64; 3]]),
    /// A color per region.
    Regions {
        /// The region of each vertex.
        labels: &'a [usize],
        /// The color of each region.
        colors: &'a [[f64; 3]],
    },
}

/// The light that a surface reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// L, towards the light, of any length; `None` for ambient light alone.
    pub direction: Option<[f64; 3]>,
    /// A.
    pub ambient: f64,
}

impl Default for Light {
    /// No shading.
    fn default() -> Self {
        Light { direction: None, ambient: 1.0 }
    }
}

/// A surface to be photographed.
#[derive(Clone, Copy, Debug)]
pub struct Studio<'a> {
    /// The surface, in the units of the cameras.
    pub mesh: &'a Mesh,
    /// Its color.
    pub paint: Paint<'a>,
    /// How it is lit.
    pub light: Light,
    /// b, the color where no ray meets the surface.
    pub background: [f64; 3],
    /// S: a pixel is the mean of S x S samples.
    pub samples: usize,
    /// The standard deviation of each channel of each pixel.
    pub noise: f64,
    /// The seed of the noise.
    pub seed: u64,
}

/// A photograph in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    /// The colors row by row. They are not clipped: noise and light can take them out of [0, 1].
    pub pixels: Vec<[f64; 3]>,
    /// Whether a sample of any pixel shows the surface.
    pub shows_surface: bool,
    /// Faces that reach behind the camera and were left out.
    pub behind: usize,
}

impl Photograph {
    /// The pixels as they are stored in 8 bits, clipped to [0, 1].
    pub fn bytes(&self) -> Vec<[u8; 3]> {
        let byte = |c: f64| (255.0 * c.clamp(0.0, 1.0)).round() as u8;
        self.pixels.iter().map(|pixel| pixel.map(byte)).collect()
    }
}

impl Studio<'_> {
    /// The photographs of the views, whose sizes are known, in their order. They do not depend on the number of threads.
    ///
    /// # Errors
    /// Those of [`Studio::each`].
    pub fn photographs(&self, views: &[View]) -> Result<Vec<Photograph>> {
        self.each(views, |_, photograph| Ok(photograph))
    }

    /// The results of `take` for the index of each view and its photograph, in the order of the views: only those that
    /// are being worked on are in memory.
    ///
    /// # Errors
    /// `take` fails; or the arrays do not have an entry per vertex, a label has no color, the light or a color is not
    /// possible, or a view has no size, no pixels or too many.
    pub fn each<T: Send>(
        &self,
        views: &[View],
        take: impl Fn(usize, Photograph) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        self.check()?;
        let lit = self.lit();
        let mut seeds = Pcg64::seed_from_u64(self.seed);
        let tasks: Vec<(usize, &View, u64)> =
            views.iter().enumerate().map(|(i, view)| (i, view, seeds.random())).collect();
        let results = sweep::results(tasks, |(i, view, seed)| {
            let size = self.size(view)?;
            let mut photograph = self.photograph(&view.camera, size, lit.as_deref());
            add_noise(&mut photograph.pixels, self.noise, seed);
            take(i, photograph)
        });
        results.into_iter().collect()
    }

    fn photograph(&self, camera: &Pinhole, size: [usize; 2], lit: Option<&[f64]>) -> Photograph {
        let color = |j: usize, beta: [f64; 3]| {
            let face = self.mesh.faces[j].map(|k| k as usize);
            let c = match self.paint {
                Paint::Vertices(colors) => {
                    [0, 1, 2].map(|i| (0..3).map(|a| beta[a] * colors[face[a]][i]).sum())
                }
                Paint::Regions { labels, colors } => colors[labels[face[nearest(beta)]]],
            };
            let s = lit.map_or(self.light.ambient, |s| (0..3).map(|a| beta[a] * s[face[a]]).sum());
            c.map(|c: f64| s * c)
        };
        rendered(self.mesh, camera, size, self.samples, color, self.background)
    }

    /// s, unless it is A everywhere.
    fn lit(&self) -> Option<Vec<f64>> {
        let l = Vector3::from(self.light.direction?);
        let l = (l / l.amax()).normalize();
        let mut normals = vec![Vector3::zeros(); self.mesh.vertices.len()];
        for (j, face) in self.mesh.faces.iter().enumerate() {
            let area = self.mesh.area_vector(j);
            face.iter().for_each(|&k| normals[k as usize] += area);
        }
        let shading = |normal: Vector3<f64>| {
            let n = normal.try_normalize(0.0).unwrap_or_default();
            self.light.ambient + n.dot(&l).max(0.0)
        };
        Some(normals.into_iter().map(shading).collect())
    }

    fn size(&self, view: &View) -> Result<[usize; 2]> {
        let Some(size) = view.size else {
            let message = format!("the size of {} is not known", view.image);
            return Err(Error::unsuitable(message));
        };
        let [w, h] = size;
        if !(1..=MAX_PIXELS).contains(&(u64::from(w) * u64::from(h))) {
            return Err(Error::unsuitable(format!(
                "a photograph cannot have {w} x {h} pixels, but 1 to {MAX_PIXELS}; choose another size, and scale K with it"
            )));
        }
        Ok(size.map(|n| n as usize))
    }

    fn check(&self) -> Result<()> {
        let fail = |message: String| Err(Error::unsuitable(message));
        let vertices = self.mesh.vertices.len();
        let colors = match self.paint {
            Paint::Vertices(colors) if colors.len() != vertices => {
                return fail(format!("{} colors for {vertices} vertices", colors.len()));
            }
            Paint::Vertices(colors) => colors,
            Paint::Regions { labels, .. } if labels.len() != vertices => {
                return fail(format!("{} labels for {vertices} vertices", labels.len()));
            }
            Paint::Regions { labels, colors } => {
                let mut labels = labels.iter().enumerate();
                if let Some((k, p)) = labels.find(|(_, p)| **p >= colors.len()) {
                    let last = colors.len();
                    return fail(format!(
                        "vertex {k} has the label {p}, but only {last} regions have colors"
                    ));
                }
                colors
            }
        };
        if !colors.as_flattened().iter().all(|c| c.is_finite()) {
            return fail("the colors of the surface must be finite".into());
        }
        let Light { direction, ambient } = self.light;
        if let Some([x, y, z]) = direction
            && !([x, y, z].iter().all(|x| x.is_finite())
                && Vector3::new(x, y, z).amax().is_normal())
        {
            return fail(format!(
                "the light {x},{y},{z} must have three finite numbers, not all 0"
            ));
        }
        if !(ambient >= 0.0 && ambient.is_finite()) {
            return fail(format!(
                "the ambient light {ambient} must be a finite number, at least 0"
            ));
        }
        if !(self.noise >= 0.0 && self.noise.is_finite()) {
            return fail(format!("the noise {} must be a finite number, at least 0", self.noise));
        }
        let [r, g, b] = self.background;
        if !self.background.iter().all(|c| (0.0..=1.0).contains(c)) {
            return fail(format!("the background {r},{g},{b} must have three numbers from 0 to 1"));
        }
        assert!(self.samples > 0);
        Ok(())
    }
}

/// The image of a surface whose color is a function of the face and the barycentric coordinates, as the mean of S x S
/// samples in a pixel.
pub fn rendered(
    mesh: &Mesh,
    camera: &Pinhole,
    size: [usize; 2],
    s: usize,
    color: impl Fn(usize, [f64; 3]) -> [f64; 3],
    background: [f64; 3],
) -> Photograph {
    let [width, height] = size;
    let mut pixels = vec![[0.0; 3]; width * height];
    let (mut shows_surface, mut behind) = (false, 0);
    let rows = (SAMPLES_AT_A_TIME / (width * s * s)).max(1);
    for (band, pixels) in pixels.chunks_mut(rows * width).enumerate() {
        let first = band * rows;
        let zbuffer = ZBuffer::of_rows(mesh, camera, width, first..first + pixels.len() / width, s);
        behind = zbuffer.behind;
        for sample in 0..zbuffer.width * zbuffer.height {
            let (column, row) = (sample % zbuffer.width, sample / zbuffer.width);
            let seen = match zbuffer.face(sample) {
                Some(j) => {
                    shows_surface = true;
                    color(j, zbuffer.on_face(j, column, first * s + row))
                }
                None => background,
            };
            let pixel = &mut pixels[row / s * width + column / s];
            pixel.iter_mut().zip(seen).for_each(|(sum, c)| *sum += c);
        }
    }
    let share = (s * s) as f64;
    pixels.iter_mut().flatten().for_each(|c| *c /= share);
    Photograph { width, height, pixels, shows_surface, behind }
}

/// The corner with the largest barycentric coordinate, the first of equal ones.
fn nearest(beta: [f64; 3]) -> usize {
    (1..3).fold(0, |best, a| if beta[a] > beta[best] { a } else { best })
}

fn add_noise(pixels: &mut [[f64; 3]], deviation: f64, seed: u64) {
    if deviation == 0.0 {
        return;
    }
    let noise = Normal::new(0.0, deviation).expect("a finite deviation from 0");
    let mut rng = Pcg64::seed_from_u64(seed);
    pixels.iter_mut().flatten().for_each(|c| *c += noise.sample(&mut rng));
}
