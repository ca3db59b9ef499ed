//! The energy of a colored surface in front of cameras, and its gradient with respect to the vertices X.
//!
//! ```text
//! E(X, U, mu) = sigma sum_i int_image_i e_i dw + lambda TV(U) + kappa Area + (eta / 2) |L X|^2
//! ```
//!
//! with S x S samples a pixel. sigma is set once and never again while X moves. The terms are those of `covered.rs`,
//! `length.rs`, `area.rs` and `roughness.rs`; the gradient of the images has the parts of `interior.rs`, `contour.rs` and
//! `lit.rs`. The images are summed one by one and then over the cameras in their order, so that the sums do not depend on
//! the number of threads.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::coloring::{Coloring, Look};
use super::edges::{Edges, Neighbors};
use super::images::Image;
use super::length::Contrasts;
use super::lit::Light;
use super::scene::{Scene, Seen};
use super::{area, contour, covered, interior, roughness};
use crate::mesh::Mesh;
use crate::optics::zbuffer::ZBuffer;
use crate::sweep;

/// The results of at most this many views are in memory.
const VIEWS_AT_A_TIME: usize = 32;

/// What the terms weigh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// sigma, area per pixel.
    pub sigma: f64,
    /// lambda of the length of the cuts.
    pub lambda: f64,
    /// kappa of the area.
    pub kappa: f64,
    /// eta of the roughness.
    pub eta: f64,
}

/// How finely images are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// S: a pixel has S x S samples.
    pub samples: usize,
    /// Samples per pixel along contours.
    pub contour: f64,
}

impl Default for Sampling {
    fn default() -> Self {
        Sampling { samples: 2, contour: 2.0 }
    }
}

/// The terms of the energy, with their weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Terms {
    /// Of the images.
    pub images: f64,
    /// Of the cuts.
    pub cuts: f64,
    /// Of the area.
    pub area: f64,
    /// Of the roughness.
    pub roughness: f64,
}

impl Terms {
    /// E.
    pub fn sum(&self) -> f64 {
        self.images + self.cuts + self.area + self.roughness
    }
}

/// The energy and its gradient at a surface.
pub struct Slope {
    /// The energy.
    pub terms: Terms,
    /// dE/dX_k, V vectors.
    pub gradient: Vec<Vector3<f64>>,
    /// The length of the visible contours in all images, in pixels.
    pub contour_pixels: f64,
}

/// The energy as a function of X, for labels and colors that are given.
pub struct Energy<'a> {
    images: &'a [Image],
    sampling: Sampling,
    weights: Weights,
    light: Option<Light>,
    edges: &'a Edges,
    neighbors: &'a Neighbors,
    looks: Vec<Look>,
    /// Whether anything slides along the surface: it is shaded, or not of one color.
    has_interior: bool,
    contrasts: Contrasts,
    /// The energy of the images without a surface, without sigma.
    empty: f64,
}

impl<'a> Energy<'a> {
    /// That of labels and colors on a mesh, of which `edges` and `neighbors` are those.
    pub fn new(
        images: &'a [Image],
        sampling: Sampling,
        weights: Weights,
        mesh: &Mesh,
        (edges, neighbors): (&'a Edges, &'a Neighbors),
        coloring: &Coloring,
        light: Option<Light>,
    ) -> Self {
        Energy {
            images,
            sampling,
            weights,
            light,
            edges,
            neighbors,
            looks: coloring.looks(),
            has_interior: light.is_some() || !coloring.is_uniform(),
            contrasts: Contrasts::new(mesh, coloring),
            empty: images.iter().map(Image::empty).sum(),
        }
    }

    /// The same energy, whose gradient has only the contours of the images: neither `interior.rs` nor `lit.rs`.
    pub fn contours_only(self) -> Self {
        Energy { has_interior: false, ..self }
    }

    /// E of a mesh with the faces of the one that it was made for.
    pub fn terms(&self, mesh: &Mesh) -> Terms {
        let shading = self.light.map(|light| light.shading(mesh));
        let scene = Scene { mesh, looks: &self.looks, shading: shading.as_deref() };
        let s = self.sampling.samples;
        let images: Vec<&Image> = self.images.iter().collect();
        let sums = sweep::results(images, |image| {
            let zbuffer = ZBuffer::new(mesh, &image.camera, image.size(), s);
            self.share(image) * covered::sum(&scene, image, &zbuffer, s)
        });
        self.with_covered(mesh, sums.into_iter().sum())
    }

    /// E and its gradient.
    pub fn slope(&self, mesh: &Mesh) -> Slope {
        let shading = self.light.map(|light| light.shading(mesh));
        let scene = Scene { mesh, looks: &self.looks, shading: shading.as_deref() };
        let mut gradient = vec![Vector3::zeros(); mesh.vertices.len()];
        let mut by_shading = vec![0.0; shading.as_ref().map_or(0, Vec::len)];
        let (mut covered, mut contour_pixels) = (0.0, 0.0);
        for images in self.images.chunks(VIEWS_AT_A_TIME) {
            let views: Vec<&Image> = images.iter().collect();
            for view in sweep::results(views, |image| self.view(&scene, image)) {
                covered += view.covered;
                contour_pixels += view.contour_pixels;
                gradient.iter_mut().zip(view.gradient).for_each(|(sum, g)| *sum += g);
                by_shading.iter_mut().zip(view.by_shading).for_each(|(sum, x)| *sum += x);
            }
        }
        let Weights { sigma, lambda, kappa, eta } = self.weights;
        gradient.iter_mut().for_each(|g| *g *= sigma);
        if let Some(light) = self.light {
            by_shading.iter_mut().for_each(|x| *x *= sigma);
            light.add_gradient(mesh, &by_shading, &mut gradient);
        }
        if lambda > 0.0 {
            self.contrasts.add_gradient(mesh, lambda, &mut gradient);
        }
        if kappa > 0.0 {
            area::add_gradient(mesh, kappa, &mut gradient);
        }
        if eta > 0.0 {
            roughness::add_gradient(self.neighbors, &mesh.vertices, eta, &mut gradient);
        }
        Slope { terms: self.with_covered(mesh, covered), gradient, contour_pixels }
    }

    /// omega / S^2.
    fn share(&self, image: &Image) -> f64 {
        image.omega / (self.sampling.samples * self.sampling.samples) as f64
    }

    fn view(&self, scene: &Scene, image: &Image) -> View {
        let Sampling { samples, contour } = self.sampling;
        let share = self.share(image);
        let zbuffer = ZBuffer::new(scene.mesh, &image.camera, image.size(), samples);
        let seen = Seen::new(scene.mesh, image);
        let mut gradient = vec![Vector3::zeros(); scene.mesh.vertices.len()];
        let (covered, mut by_shading) = if self.has_interior {
            let found =
                interior::add_gradient(scene, image, &seen, &zbuffer, samples, &mut gradient);
            (found.covered, found.by_shading)
        } else {
            (covered::sum(scene, image, &zbuffer, samples), Vec::new())
        };
        gradient.iter_mut().for_each(|g| *g *= share);
        by_shading.iter_mut().for_each(|x| *x *= share);
        let contour_pixels =
            contour::add_gradient(scene, self.edges, image, &seen, contour, &mut gradient);
        gradient.iter_mut().for_each(|g| *g = image.camera.scene_direction(*g));
        View { covered: share * covered, gradient, by_shading, contour_pixels }
    }

    fn with_covered(&self, mesh: &Mesh, covered: f64) -> Terms {
        let Weights { sigma, lambda, kappa, eta } = self.weights;
        let times = |weight: f64, value: &dyn Fn() -> f64| {
            if weight > 0.0 { weight * value() } else { 0.0 }
        };
        Terms {
            images: sigma * (self.empty + covered),
            cuts: times(lambda, &|| self.contrasts.total_variation(mesh)),
            area: times(kappa, &|| mesh.area()),
            roughness: times(eta, &|| roughness::roughness(self.neighbors, &mesh.vertices)),
        }
    }
}

/// What one image says, without sigma, in the axes of the scene.
struct View {
    covered: f64,
    gradient: Vec<Vector3<f64>>,
    by_shading: Vec<f64>,
    contour_pixels: f64,
}
