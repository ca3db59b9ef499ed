//! A calibrated camera.
//!
//! ```text
//! x_cam = R x + t        pixel = K x_cam / z        center C = -R^T t
//! ```
//!
//! The camera's axes are x to the right, y down, z forward. **Integer pixel coordinates are pixel centers**: pixel (c, r)
//! covers [c - 1/2, c + 1/2] x [r - 1/2, r + 1/2], and the first one is (0, 0), at the upper left.
//!
//! Reference: R. Hartley, A. Zisserman, *Multiple View Geometry in Computer Vision*, 2003, chapter 6.

use nalgebra::{Matrix3, Point3, Vector3};

use super::edge::Projected;
use crate::error::{Error, Result};

/// R^T R may differ from I by this much: cameras are written with six digits or more.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// A pinhole camera without lens distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    k: Matrix3<f64>,
    r: Matrix3<f64>,
    t: Vector3<f64>,
}

impl Pinhole {
    /// A camera from K (upper triangular, scaled to K_33 = 1), R and t.
    ///
    /// # Errors
    /// Numbers that are not finite; a K that is not upper triangular, singular, or without positive focal lengths; an R
    /// that is no rotation.
    pub fn new(k: Matrix3<f64>, r: Matrix3<f64>, t: Vector3<f64>) -> Result<Self> {
        let fail = |message: &str| Err(Error::unsuitable(message));
        if !k.iter().chain(&r).chain(&t).all(|x| x.is_finite()) {
            return fail("K, R and t must be finite numbers");
        }
        let largest = k.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        if [k[(1, 0)], k[(2, 0)], k[(2, 1)]].iter().any(|x| x.abs() > 1e-12 * largest) {
            return fail(
                "K is not upper triangular; it is fx, skew, cx, 0, fy, cy, 0, 0, 1, row by row",
            );
        }
        let k = k / k[(2, 2)];
        let [fx, fy] = [k[(0, 0)], k[(1, 1)]];
        if !k.iter().all(|x| x.is_finite()) || fx == 0.0 || fy == 0.0 {
            return fail("K is singular; its focal lengths fx and fy must be positive, in pixels");
        }
        if fx < 0.0 || fy < 0.0 {
            return fail(
                "K has a negative focal length; negate the rows of R and t of that axis instead (x is to the right, y \
                 down, z forward)",
            );
        }
        if (r.transpose() * r - Matrix3::identity()).abs().max() > ROTATION_TOLERANCE {
            return fail("R is not a rotation: R^T R is not the identity");
        }
        if r.determinant() < 0.0 {
            return fail(
                "R mirrors the scene: its determinant is -1 instead of 1; negate the row of the axis that is reversed (x \
                 is to the right, y down, z forward)",
            );
        }
        Ok(Pinhole { k, r, t })
    }

    /// K, R (both row by row) and t; [`Pinhole::new`] makes the same camera of them, bit by bit.
    pub fn numbers(&self) -> ([f64; 9], [f64; 9], [f64; 3]) {
        let rows = |m: &Matrix3<f64>| std::array::from_fn(|i| m[(i / 3, i % 3)]);
        (rows(&self.k), rows(&self.r), self.t.into())
    }

    /// The camera of the same images at s times the resolution: f_x, f_y times s, c' = (c + 1/2) s - 1/2.
    pub fn scaled(&self, s: f64) -> Self {
        let mut k = self.k;
        for i in 0..2 {
            k[(i, 2)] = (k[(i, 2)] + 0.5) * s - 0.5;
        }
        for entry in [(0, 0), (0, 1), (1, 1)] {
            k[entry] *= s;
        }
        Pinhole { k, ..*self }
    }

    /// The camera with its principal point moved by these numbers of pixels.
    pub fn shifted(&self, [x, y]: [f64; 2]) -> Self {
        let mut k = self.k;
        k[(0, 2)] += x;
        k[(1, 2)] += y;
        Pinhole { k, ..*self }
    }

    /// x_cam = R x + t.
    #[inline(always)]
    pub fn to_camera(&self, x: Point3<f64>) -> Vector3<f64> {
        self.r * x.coords + self.t
    }

    /// The pixel of a point, and 1/z, which is not positive for points behind the camera.
    #[inline(always)]
    pub(crate) fn project(&self, x: Point3<f64>) -> Projected {
        let at = self.to_camera(x);
        let w = 1.0 / at.z;
        let k = &self.k;
        Projected {
            x: (k[(0, 0)] * at.x + k[(0, 1)] * at.y) * w + k[(0, 2)],
            y: k[(1, 1)] * at.y * w + k[(1, 2)],
            w,
        }
    }

    /// d(w) = K^-1 (w, 1), the ray of a point of the image in the axes of the camera; its z is 1.
    #[inline(always)]
    pub(crate) fn ray(&self, [x, y]: [f64; 2]) -> Vector3<f64> {
        let k = &self.k;
        let down = (y - k[(1, 2)]) / k[(1, 1)];
        Vector3::new((x - k[(0, 2)] - k[(0, 1)] * down) / k[(0, 0)], down, 1.0)
    }

    /// R^T v, a direction in the axes of the camera seen in those of the scene.
    #[inline(always)]
    pub(crate) fn scene_direction(&self, v: Vector3<f64>) -> Vector3<f64> {
        self.r.tr_mul(&v)
    }

    /// The center of the camera, C = -R^T t.
    pub fn center(&self) -> Point3<f64> {
        Point3::from(-(self.r.transpose() * self.t))
    }

    /// The camera of the scene moved by x -> c M x + b, with a rotation M.
    #[cfg(test)]
    pub(crate) fn moved(&self, c: f64, m: Matrix3<f64>, b: Vector3<f64>) -> Self {
        let r = self.r * m.transpose();
        Pinhole { r, t: c * self.t - r * b, ..*self }
    }

    /// The camera of the images reflected from left to right, whose K has a negative determinant; no file has such.
    #[cfg(test)]
    pub(crate) fn mirrored(&self, width: usize) -> Self {
        let mut k = self.k;
        k[(0, 0)] *= -1.0;
        k[(0, 1)] *= -1.0;
        k[(0, 2)] = width as f64 - 1.0 - k[(0, 2)];
        Pinhole { k, ..*self }
    }

    /// det K, the number of pixels in a unit of the normalized image plane z = 1.
    pub fn pixels_per_unit(&self) -> f64 {
        self.k[(0, 0)] * self.k[(1, 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_rotation, random_vector, rng};

    fn k() -> Matrix3<f64> {
        Matrix3::new(500.0, 2.0, 319.5, 0.0, 480.0, 239.5, 0.0, 0.0, 1.0)
    }

    #[test]
    fn points_project_through_k_r_and_t() {
        let mut rng = rng(3);
        for _ in 0..20 {
            let r = *random_rotation(&mut rng).matrix();
            let (t, x) = (random_vector(&mut rng) + Vector3::z() * 5.0, random_vector(&mut rng));
            let camera = Pinhole::new(k() * 2.0, r, t).unwrap();
            let at = k() * (r * x + t);
            let found = camera.project(Point3::from(x));
            assert!((found.x - at.x / at.z).abs() <= 1e-10);
            assert!((found.y - at.y / at.z).abs() <= 1e-10);
            assert!((found.w - 1.0 / at.z).abs() <= 1e-12);
            assert!(camera.to_camera(camera.center()).norm() <= 1e-12);
            let ray = camera.ray([found.x, found.y]) - (r * x + t) * found.w;
            assert!(ray.norm() <= 1e-12);
        }
    }

    /// At s times the resolution, the corners of the pixels stay where they are: (-1/2, -1/2) is the corner of both.
    #[test]
    fn scaling_keeps_the_borders_of_the_image() {
        let camera = Pinhole::new(k(), Matrix3::identity(), Vector3::zeros()).unwrap();
        let mut rng = rng(4);
        for s in [0.25, 2.0, 3.0] {
            let x = Point3::from(random_vector(&mut rng) + Vector3::z() * 4.0);
            let [a, b] = [camera.project(x), camera.scaled(s).project(x)];
            assert!(((a.x + 0.5) * s - (b.x + 0.5)).abs() <= 1e-10);
            assert!(((a.y + 0.5) * s - (b.y + 0.5)).abs() <= 1e-10);
        }
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let i = Matrix3::identity();
        let t = Vector3::zeros();
        let fails = |k: Matrix3<f64>, r: Matrix3<f64>, t: Vector3<f64>, clause: &str| {
            let message = Pinhole::new(k, r, t).unwrap_err().to_string();
            assert!(message.contains(clause), "{message}");
        };
        fails(Matrix3::zeros(), i, t, "singular");
        fails(Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)), i, t, "singular");
        fails(Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)), i, t, "singular");
        fails(Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0)), i, t, "negative focal");
        fails(k().transpose(), i, t, "upper triangular");
        fails(k(), Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)), t, "mirrors");
        fails(k(), 2.0 * i, t, "not a rotation");
        fails(k(), i, Vector3::new(0.0, f64::NAN, 0.0), "finite");
    }
}
