//! A colored surface, and its vertices as one camera sees them.

use nalgebra::Vector3;

use super::coloring::Look;
use super::images::Image;
use crate::mesh::Mesh;
use crate::optics::edge::Projected;

/// A surface, what its regions look like, and how they are lit.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub mesh: &'a Mesh,
    /// v and w of each vertex.
    pub looks: &'a [Look],
    /// s of each vertex; `None` if it is 1 everywhere.
    pub shading: Option<&'a [f64]>,
}

impl Scene<'_> {
    /// v, w and s at a point with these weights of vertices.
    #[inline(always)]
    pub fn mean<const N: usize>(&self, vertices: &[usize; N], weights: &[f64; N]) -> (Look, f64) {
        let mut look = [0.0; 4];
        let mut s = 0.0;
        for (&k, &weight) in vertices.iter().zip(weights) {
            look.iter_mut().zip(self.looks[k]).for_each(|(sum, x)| *sum += weight * x);
            s += weight * self.shading.map_or(1.0, |shading| shading[k]);
        }
        (look, s)
    }
}

/// The vertices in the frame of a camera.
pub struct Seen {
    /// X_k in the axes of the camera.
    pub points: Vec<Vector3<f64>>,
    /// In pixels of the image.
    pub projected: Vec<Projected>,
}

impl Seen {
    pub fn new(mesh: &Mesh, image: &Image) -> Self {
        let points = mesh.vertices.iter().map(|&x| image.camera.to_camera(x)).collect();
        let projected = mesh.vertices.iter().map(|&x| image.camera.project(x)).collect();
        Seen { points, projected }
    }
}

/// e - |I|^2 = -2 s I.v + s^2 w.
#[inline(always)]
pub fn cost_beyond_image(color: [f64; 3], [r, g, b, w]: Look, s: f64) -> f64 {
    s * (s * w - 2.0 * (color[0] * r + color[1] * g + color[2] * b))
}
