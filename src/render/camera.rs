//! A perspective camera that fits the mesh into a square picture.
//!
//! In the camera's axes (x right, y up, z towards the viewer), an eye at (cx, cy, D) with half-slope t sees
//! (x, y, z) iff |x - cx| <= t (D - z) and |y - cy| <= t (D - z). Over all vertices the first asks for
//! t D + cx >= a = max(x + t z) and t D - cx >= b = max(t z - x): the nearest eye has cx = (a - b) / 2 and
//! t D = (a + b) / 2, and D is the larger of what x and y ask for.

use nalgebra::{Matrix3, Point3, Vector3};

/// Half of the field of view of 25 degrees.
const HALF_ANGLE: f64 = 12.5 * std::f64::consts::PI / 180.0;
/// The share of the half-width that stays free around the mesh.
const MARGIN: f64 = 0.07;

#[derive(Clone, Debug)]
pub(super) struct Camera {
    /// Rows: right, up, towards the viewer.
    axes: Matrix3<f64>,
    /// The eye in these axes.
    eye: Vector3<f64>,
}

/// A vertex on the image plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected {
    /// Sample coordinates: x to the right and y downwards in [0, size].
    pub x: f64,
    pub y: f64,
    /// Reciprocal distance along the axis, which is linear over the image of a plane; larger is nearer.
    pub w: f64,
}

/// The slope of the picture's border.
pub(super) fn half_slope() -> f64 {
    HALF_ANGLE.tan()
}

impl Camera {
    /// Looks against `towards` (from the mesh to the viewer) with `up` upwards; both need not be unit or
    /// orthogonal, but must be independent. `points` are the vertices to fit.
    pub fn fit(towards: Vector3<f64>, up: Vector3<f64>, points: &[Point3<f64>]) -> Self {
        let back = towards.normalize();
        let right = up.cross(&back).normalize();
        let axes = Matrix3::from_rows(&[
            right.transpose(),
            back.cross(&right).transpose(),
            back.transpose(),
        ]);
        let t = half_slope() * (1.0 - MARGIN);
        let mut bounds = [f64::NEG_INFINITY; 4];
        let mut nearest = f64::NEG_INFINITY;
        for point in points {
            let p = axes * point.coords;
            let reach = [p.x + t * p.z, t * p.z - p.x, p.y + t * p.z, t * p.z - p.y];
            for (bound, r) in bounds.iter_mut().zip(reach) {
                *bound = bound.max(r);
            }
            nearest = nearest.max(p.z);
        }
        let [a, b, c, d] = bounds;
        let distance = (a + b).max(c + d) / (2.0 * t);
        Camera { axes, eye: Vector3::new((a - b) / 2.0, (c - d) / 2.0, distance) }
    }

    /// A direction in the camera's axes.
    pub fn rotate(&self, direction: Vector3<f64>) -> Vector3<f64> {
        self.axes * direction
    }

    /// From a point of the mesh to the eye, in the camera's axes.
    pub fn to_eye(&self, point: Point3<f64>) -> Vector3<f64> {
        self.eye - self.axes * point.coords
    }

    /// The point on a picture of size x size samples.
    pub fn project(&self, point: Point3<f64>, size: usize) -> Projected {
        let ray = self.to_eye(point);
        let w = 1.0 / ray.z;
        let scale = 0.5 * size as f64 / half_slope();
        Projected {
            x: 0.5 * size as f64 - ray.x * w * scale,
            y: 0.5 * size as f64 + ray.y * w * scale,
            w,
        }
    }
}
