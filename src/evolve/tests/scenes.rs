//! Surfaces, cameras and images of the tests.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::data::views::{Ball, around};
use crate::evolve::coloring::Coloring;
use crate::evolve::edges::{Edges, Neighbors};
use crate::evolve::energy::{Energy, Sampling, Slope, Weights};
use crate::evolve::images::{Image, Pixel};
use crate::evolve::lit::Light;
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::samples::{random_labels, random_rotation, random_vector, rng, shape};

/// Everything that the energy depends on.
pub struct Case {
    pub mesh: Mesh,
    pub images: Vec<Image>,
    pub coloring: Coloring,
    pub light: Option<Light>,
    pub weights: Weights,
    pub sampling: Sampling,
}

pub const IMAGES_ALONE: Weights = Weights { sigma: 1.0, lambda: 0.0, kappa: 0.0, eta: 0.0 };

impl Case {
    /// A mesh with random labels and colors in front of random images.
    pub fn new(mesh: Mesh, cameras: Vec<Pinhole>, size: usize, rng: &mut Pcg64) -> Self {
        let images = cameras.into_iter().map(|camera| image(camera, size, rng)).collect();
        let coloring = random_coloring(&mesh, 3, rng);
        let sampling = Sampling { samples: 64, contour: 256.0 };
        Case { mesh, images, coloring, light: None, weights: IMAGES_ALONE, sampling }
    }

    pub fn lit(self, rng: &mut Pcg64) -> Self {
        let light = Light { direction: random_vector(rng).normalize(), ambient: 0.2 };
        Case { light: Some(light), ..self }
    }

    pub fn with_samples(self, samples: usize) -> Self {
        Case { sampling: Sampling { samples, ..self.sampling }, ..self }
    }

    fn with_energy<T>(&self, work: impl FnOnce(Energy) -> T) -> T {
        let edges = Edges::of(&self.mesh);
        let neighbors = Neighbors::along(&edges, self.mesh.vertices.len());
        let Case { mesh, images, coloring, light, weights, sampling } = self;
        let energy =
            Energy::new(images, *sampling, *weights, mesh, (&edges, &neighbors), coloring, *light);
        work(energy)
    }

    pub fn slope(&self) -> Slope {
        self.with_energy(|energy| energy.slope(&self.mesh))
    }

    pub fn slope_of_contours(&self) -> Slope {
        self.with_energy(|energy| energy.contours_only().slope(&self.mesh))
    }

    /// E.
    pub fn energy(&self) -> f64 {
        self.with_energy(|energy| energy.terms(&self.mesh).sum())
    }

    /// The central difference of E along a displacement of the vertices.
    pub fn difference(&self, displacement: &[Vector3<f64>], h: f64) -> f64 {
        self.with_energy(|energy| {
            let at = |h: f64| energy.terms(&moved(&self.mesh, displacement, h)).sum();
            (at(h) - at(-h)) / (2.0 * h)
        })
    }
}

pub fn moved(mesh: &Mesh, displacement: &[Vector3<f64>], h: f64) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.vertices.iter_mut().zip(displacement).for_each(|(x, v)| *x += h * v);
    mesh
}

pub fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// An ellipsoid of 162 vertices, turned so that no sample lies on an edge.
pub fn ellipsoid() -> Mesh {
    let mut mesh = shape("sphere:2");
    let rotation = random_rotation(&mut rng(77));
    let turned = |x: Point3<f64>| rotation * Point3::new(0.9 * x.x, 0.7 * x.y, 0.5 * x.z);
    mesh.vertices.iter_mut().for_each(|x| *x = turned(*x));
    mesh
}

/// A torus of 288 vertices that hides parts of itself, within a ball of radius 1.
pub fn torus() -> Mesh {
    let mesh = shape("torus:24x12");
    let largest = mesh.vertices.iter().map(|x| x.coords.norm()).fold(0.0, f64::max);
    mesh.scaled(0.95 / largest)
}

/// n cameras around the origin, whose square images a ball of radius 1 fills to nine tenths.
pub fn cameras(n: usize, size: usize) -> Vec<Pinhole> {
    let ball = Ball { center: Point3::origin(), radius: 1.0 };
    let views = around(&ball, n, 4.0, [size as u32; 2]).unwrap();
    views.into_iter().map(|view| view.camera).collect()
}

/// The middle of their images, magnified, which a ball around the origin of a third of the radius covers.
pub fn close_cameras(n: usize, size: usize) -> Vec<Pinhole> {
    let shift = -(size as f64);
    cameras(n, 3 * size).into_iter().map(|camera| camera.shifted([shift; 2])).collect()
}

/// An image of random colors in front of random backgrounds.
pub fn image(camera: Pinhole, size: usize, rng: &mut Pcg64) -> Image {
    let pixel = |_| Pixel::new(rng.random(), rng.random());
    let pixels = (0..size * size).map(pixel).collect();
    Image { camera, width: size, height: size, omega: 1.0, pixels }
}

pub fn random_coloring(mesh: &Mesh, m: usize, rng: &mut Pcg64) -> Coloring {
    let rows = random_labels::<3>(mesh.vertices.len(), m, rng);
    let u = rows.into_iter().flat_map(|row| row.0[..m].to_vec()).collect();
    Coloring { u, mu: (0..m).map(|_| rng.random()).collect() }
}

/// Displacements of the vertices: noise, a smooth field, a translation, a scaling.
pub fn fields(mesh: &Mesh, rng: &mut Pcg64) -> [(&'static str, Vec<Vector3<f64>>); 4] {
    let noise = mesh.vertices.iter().map(|_| random_vector(rng)).collect();
    let (a, b) = (random_vector(rng), random_vector(rng));
    let smooth = mesh.vertices.iter().map(|x| (3.0 * a.dot(&x.coords)).sin() * b).collect();
    let translation = vec![random_vector(rng); mesh.vertices.len()];
    let scaling = mesh.vertices.iter().map(|x| x.coords).collect();
    [("noise", noise), ("smooth", smooth), ("translation", translation), ("scaling", scaling)]
}
