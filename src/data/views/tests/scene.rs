//! Cameras around the origin, what they see of a color in space, and the second formula of the statistics.

use nalgebra::{Point3, Vector3};

use crate::data::views::statistics::Sums;
use crate::data::views::synthetic::{self, Photograph};
use crate::data::views::{Ball, around};
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;

pub struct Camera {
    pub pinhole: Pinhole,
    /// Width and height in pixels.
    pub size: [usize; 2],
}

/// A ball of radius 1 around the origin.
pub const BALL: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 1.0 };

/// n cameras that look at the origin from a distance; a ball of radius 1 fills nine tenths of the image.
pub fn cameras(n: usize, distance: f64, size: [usize; 2]) -> Vec<Camera> {
    let views = around(&BALL, n, distance, size.map(|n| n as u32)).unwrap();
    views.into_iter().map(|view| Camera { pinhole: view.camera, size }).collect()
}

/// The image of a surface whose color is a function of the position, as the mean of s x s samples a pixel.
pub fn rendered(
    mesh: &Mesh,
    Camera { pinhole, size }: &Camera,
    s: usize,
    color: impl Fn(Vector3<f64>) -> [f64; 3],
    background: [f64; 3],
) -> Photograph {
    let at = |j: usize, beta: [f64; 3]| {
        let corners = mesh.corners(j);
        color((0..3).map(|a| corners[a].coords * beta[a]).sum())
    };
    synthetic::rendered(mesh, pinhole, *size, s, at, background)
}

/// W, Q and C of one camera by n^2 midpoints on each face: the weight of a point is -det K (x.n) / z^3 dsigma, and a ray
/// decides whether it is visible. The image is a function of the position in units of its width and height.
pub fn on_faces(
    mesh: &Mesh,
    Camera { pinhole, size }: &Camera,
    n: usize,
    image: impl Fn(f64, f64) -> [f64; 3],
) -> Vec<Sums> {
    let corners: Vec<[Vector3<f64>; 3]> =
        (0..mesh.faces.len()).map(|j| mesh.corners(j).map(|x| pinhole.to_camera(x))).collect();
    let mut sums = vec![[0.0; 5]; mesh.vertices.len()];
    for (j, &[a, b, c]) in corners.iter().enumerate() {
        let normal = (b - a).cross(&(c - a)) / 2.0;
        if a.dot(&normal) >= 0.0 {
            continue;
        }
        for beta in midpoints(n) {
            let x = a * beta[0] + b * beta[1] + c * beta[2];
            if corners.iter().enumerate().any(|(i, face)| i != j && hides(face, &x)) {
                continue;
            }
            let area = -pinhole.pixels_per_unit() * x.dot(&normal) / x.z.powi(3) / (n * n) as f64;
            let world: Vector3<f64> =
                mesh.corners(j).iter().zip(beta).map(|(x, beta)| x.coords * beta).sum();
            let at = pinhole.project(Point3::from(world));
            let color = image((at.x + 0.5) / size[0] as f64, (at.y + 0.5) / size[1] as f64);
            let [r, g, b] = color;
            let terms = [1.0, r * r + g * g + b * b, r, g, b];
            for (&k, beta) in mesh.faces[j].iter().zip(beta) {
                let sums = sums[k as usize].iter_mut().zip(terms);
                sums.for_each(|(sum, term)| *sum += area * beta * term);
            }
        }
    }
    sums
}

/// The barycentric coordinates of the centroids of n^2 equal parts of a triangle.
fn midpoints(n: usize) -> Vec<[f64; 3]> {
    let step = 1.0 / (3 * n) as f64;
    let mut points = Vec::new();
    for i in 0..n {
        for k in 0..n - i {
            let up = [3 * i + 1, 3 * k + 1].map(|x| x as f64 * step);
            points.push([up[0], up[1], 1.0 - up[0] - up[1]]);
            if i + k + 1 < n {
                let down = [3 * i + 2, 3 * k + 2].map(|x| x as f64 * step);
                points.push([down[0], down[1], 1.0 - down[0] - down[1]]);
            }
        }
    }
    points
}

/// Whether a face meets the segment from the camera to x before x.
fn hides([a, b, c]: &[Vector3<f64>; 3], x: &Vector3<f64>) -> bool {
    let (ab, ac) = (b - a, c - a);
    let across = x.cross(&ac);
    let determinant = ab.dot(&across);
    if determinant == 0.0 {
        return false;
    }
    let u = -a.dot(&across) / determinant;
    let other = (-a).cross(&ab);
    let v = x.dot(&other) / determinant;
    let t = ac.dot(&other) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < 1.0 - 1e-9
}
