//! Cameras around the origin, what they see of a mesh, and the second formula of the statistics.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::data::views::statistics::Sums;
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::optics::zbuffer::ZBuffer;

pub struct Camera {
    pub pinhole: Pinhole,
    /// Width and height in pixels.
    pub size: [usize; 2],
}

/// K, R and t, row by row, of n cameras on a Fibonacci sphere that look at the origin.
pub fn numbers(n: usize, distance: f64, [w, h]: [usize; 2]) -> Vec<([f64; 9], [f64; 9], [f64; 3])> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let camera = |i: usize| {
        let height = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let (angle, radius) = (golden * i as f64 + 0.3, (1.0 - height * height).sqrt());
        let out = Vector3::new(radius * angle.cos(), radius * angle.sin(), height);
        let forward = -out;
        let right = forward.cross(&Vector3::new(0.1, 0.2, 1.0)).normalize();
        let r = Matrix3::from_rows(&[
            right.transpose(),
            forward.cross(&right).transpose(),
            forward.transpose(),
        ]);
        let f = 0.45 * distance * w.min(h) as f64;
        let k = [f, 0.0, w as f64 / 2.0 - 0.3, 0.0, f, h as f64 / 2.0 - 0.6, 0.0, 0.0, 1.0];
        (k, std::array::from_fn(|i| r[(i / 3, i % 3)]), [0.0, 0.0, distance])
    };
    (0..n).map(camera).collect()
}

/// The same as cameras; a ball of radius 1 fills nine tenths of the image.
pub fn around(n: usize, distance: f64, size: [usize; 2]) -> Vec<Camera> {
    let pinhole = |(k, r, t): ([f64; 9], [f64; 9], [f64; 3])| {
        let matrix = |numbers: &[f64]| Matrix3::from_row_slice(numbers);
        Pinhole::new(matrix(&k), matrix(&r), Vector3::from(t)).unwrap()
    };
    numbers(n, distance, size).into_iter().map(|c| Camera { pinhole: pinhole(c), size }).collect()
}

/// The image of a surface whose color is a function of the position, as the mean of s x s samples a pixel.
pub fn rendered(
    mesh: &Mesh,
    Camera { pinhole, size }: &Camera,
    s: usize,
    color: impl Fn(Vector3<f64>) -> [f64; 3],
    background: [f64; 3],
) -> Vec<[f64; 3]> {
    let zbuffer = ZBuffer::new(mesh, pinhole, *size, s);
    let mut image = vec![[0.0; 3]; size[0] * size[1]];
    for sample in 0..zbuffer.width * zbuffer.height {
        let (x, y) = (sample % zbuffer.width, sample / zbuffer.width);
        let front = zbuffer.face(sample).and_then(|j| Some((j, zbuffer.front(j, x, y)?)));
        let seen = match front {
            Some((j, beta)) => {
                let corners = mesh.corners(j);
                color((0..3).map(|a| corners[a].coords * beta[a]).sum())
            }
            None => background,
        };
        let pixel = &mut image[y / s * size[0] + x / s];
        pixel.iter_mut().zip(seen).for_each(|(sum, c)| *sum += c / (s * s) as f64);
    }
    image
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
