//! Photographs of a pattern as data: of a lit surface, with noise, by cameras that may be known inexactly.

use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::data::Data;
use crate::data::pixels::Evidence;
use crate::data::synthetic::{Waves, checkerboard, waves};
use crate::data::views::synthetic::{Light, Paint, Photograph, Studio};
use crate::data::views::{CamerasAround, View, ViewOptions, Viewed, of_photographs};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::optics::zbuffer::ZBuffer;

/// The keys of an instance whose data are photographs.
pub const KEYS: [&str; 7] =
    ["pattern", "light", "ambient", "principal-error", "sampling", "pure", "grazing"];

/// S x S samples make a pixel of a photograph.
const SAMPLES: usize = 4;

/// Between the colors of the palette.
pub const BACKGROUND: [f64; 3] = [0.5; 3];

/// A vertex is hidden where the surface is nearer than this share of its distance.
const DEPTH_TOLERANCE: f64 = 1e-2;

/// What a model sees of the photographs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Sampling {
    /// All pixels, which are quadrature points.
    #[default]
    Pixels,
    /// The mean color of the pixels onto which a vertex is projected, one of each view that sees it.
    Vertices,
}

/// The regions that are photographed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Pattern {
    /// See [`waves`].
    #[default]
    Waves,
    /// See [`checkerboard`].
    Checkerboard,
}

/// How the photographs are made and read.
#[derive(Clone, Copy, Debug)]
pub struct Photography {
    /// The regions.
    pub pattern: Pattern,
    /// What is behind the surface.
    pub background: [f64; 3],
    /// Direction towards the light; `None` for ambient light alone, which leaves the colors as they are.
    pub light: Option<[f64; 3]>,
    /// Ambient light, relative to the light.
    pub ambient: f64,
    /// By how many pixels the principal points of the cameras are wrong when the photographs are read, in directions that
    /// change from view to view.
    pub principal_error: f64,
    /// What a model sees.
    pub sampling: Sampling,
    /// R, see [`ViewOptions::pure`].
    pub pure: usize,
    /// C, see [`ViewOptions::grazing`].
    pub grazing: f64,
}

/// Photographs, and the pattern that was photographed.
pub struct Album {
    /// With the cameras that the reader of the photographs believes in.
    pub views: Vec<View>,
    /// One per view.
    pub photographs: Vec<Photograph>,
    /// Whose labels and palette are the truth.
    pub pattern: Waves,
}

/// The data, and the pattern that was photographed.
pub struct Photographed {
    /// Colors of the vertices.
    pub data: Data,
    /// What the pixels say beyond that.
    pub evidence: Option<Evidence>,
    /// Whose labels and palette are the truth.
    pub pattern: Waves,
}

impl Photography {
    /// Photographs of a pattern of m regions, with noise of the given standard deviation in each channel of each pixel.
    ///
    /// # Errors
    /// The views have no pixels or too many.
    pub fn album(
        &self,
        mesh: &Mesh,
        cameras: CamerasAround,
        m: usize,
        noise: f64,
        seed: u64,
    ) -> Result<Album> {
        let pattern = match self.pattern {
            Pattern::Waves => waves(mesh, m, 0.0, seed),
            Pattern::Checkerboard => checkerboard(mesh, m),
        };
        let views = cameras.views(mesh)?;
        let ambient = if self.light.is_some() { self.ambient } else { 1.0 };
        let studio = Studio {
            mesh,
            paint: Paint::Regions { labels: &pattern.labels, colors: &pattern.palette },
            light: Light { direction: self.light, ambient },
            background: self.background,
            samples: SAMPLES,
            noise,
            seed,
        };
        let photographs = studio.photographs(&views)?;
        let views = views.into_iter().enumerate().map(|i| self.as_known(i)).collect();
        Ok(Album { views, photographs, pattern })
    }

    /// What these photographs say of the vertices of the mesh.
    ///
    /// # Errors
    /// Those of [`Photography::album`], and no camera sees the mesh.
    pub fn data(
        &self,
        mesh: &Mesh,
        cameras: CamerasAround,
        m: usize,
        noise: f64,
        seed: u64,
    ) -> Result<Photographed> {
        let Album { views, photographs, pattern } = self.album(mesh, cameras, m, noise, seed)?;
        let (data, evidence) = match self.sampling {
            Sampling::Pixels => {
                let ViewOptions { images, weights, samples, border, .. } = ViewOptions::default();
                let (pure, grazing) = (self.pure, self.grazing);
                let options = ViewOptions { images, weights, samples, pure, grazing, border };
                let Viewed { means, evidence, .. } =
                    of_photographs(&views, &photographs, mesh, &options)?;
                (means, Some(evidence))
            }
            Sampling::Vertices => (colors_of_vertices(mesh, &views, &photographs)?, None),
        };
        Ok(Photographed { data, evidence, pattern })
    }

    /// View i with the camera that the reader of the photographs believes in.
    fn as_known(&self, (i, view): (usize, View)) -> View {
        // The directions of successive views differ by the golden angle.
        let angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()) * i as f64;
        let shift = [angle.cos(), angle.sin()].map(|x| self.principal_error * x);
        View { camera: view.camera.shifted(shift), ..view }
    }
}

/// The mean color of the pixels at each vertex; unknown where no view sees it.
fn colors_of_vertices(mesh: &Mesh, views: &[View], photographs: &[Photograph]) -> Result<Data> {
    let mut sums = vec![[0.0; 4]; mesh.vertices.len()];
    for (view, photograph) in views.iter().zip(photographs) {
        let Photograph { width, height, .. } = *photograph;
        let zbuffer = ZBuffer::new(mesh, &view.camera, [width, height], 1);
        for (x, sums) in mesh.vertices.iter().zip(&mut sums) {
            let at = view.camera.project(*x);
            let inside = |x: f64, n: usize| (-0.5..n as f64 - 0.5).contains(&x);
            if !(at.w > 0.0 && inside(at.x, width) && inside(at.y, height)) {
                continue;
            }
            let pixel = at.y.round() as usize * width + at.x.round() as usize;
            if at.w >= (1.0 - DEPTH_TOLERANCE) * zbuffer.nearness[pixel] {
                let [r, g, b] = photograph.pixels[pixel].map(|c| c.clamp(0.0, 1.0));
                sums.iter_mut().zip([r, g, b, 1.0]).for_each(|(sum, x)| *sum += x);
            }
        }
    }
    // 0 / 0 where no view sees the vertex.
    let means = sums.iter().flat_map(|[r, g, b, n]| [r / n, g / n, b / n]).collect();
    Data::new(3, means)
}
