//! A perspective camera that fits the mesh, and the window of its image plane that the picture shows.
//!
//! In the camera's axes (x right, y up, z toward the viewer), an eye at (cx, cy, D) with half-slope t sees
//! (x, y, z) iff |x - cx| <= t (D - z) and |y - cy| <= t (D - z). Over all vertices the first requires
//! t D + cx >= a = max(x + t z) and t D - cx >= b = max(t z - x): the nearest eye has cx = (a - b) / 2 and
//! t D = (a + b) / 2, and D is the larger of the values required by x and y. The window is the bounding box of the
//! projected vertices.

use nalgebra::{Matrix3, Point3, Vector3};

use super::edge::Projected;

/// Half the field of view, which is 25 degrees.
const HALF_ANGLE: f64 = 12.5 * std::f64::consts::PI / 180.0;

#[derive(Clone, Debug)]
pub struct Camera {
    /// Rows: right, up, toward the viewer.
    axes: Matrix3<f64>,
    /// The eye in these axes.
    eye: Vector3<f64>,
    /// The window in slopes: left, bottom, right, top.
    window: [f64; 4],
    /// Pixels per unit of slope.
    scale: f64,
    /// Empty pixels on each side.
    margin: f64,
}

impl Camera {
    /// Fits the vertices `points`. `towards` points from the mesh to the viewer and `up` upward in the picture; they
    /// need not be unit or orthogonal, but must be linearly independent.
    pub fn fit(towards: Vector3<f64>, up: Vector3<f64>, points: &[Point3<f64>]) -> Self {
        let back = towards.normalize();
        let right = up.cross(&back).normalize();
        let axes = Matrix3::from_rows(&[
            right.transpose(),
            back.cross(&right).transpose(),
            back.transpose(),
        ]);
        let t = HALF_ANGLE.tan();
        let mut bounds = [f64::NEG_INFINITY; 4];
        for point in points {
            let p = axes * point.coords;
            let reach = [p.x + t * p.z, t * p.z - p.x, p.y + t * p.z, t * p.z - p.y];
            for (bound, r) in bounds.iter_mut().zip(reach) {
                *bound = bound.max(r);
            }
        }
        let [a, b, c, d] = bounds;
        let distance = (a + b).max(c + d) / (2.0 * t);
        let eye = Vector3::new((a - b) / 2.0, (c - d) / 2.0, distance);
        let window = window(&axes, &eye, points);
        Camera { axes, eye, window, scale: 1.0, margin: 0.0 }
    }

    /// Width and height of the window, in slopes.
    pub fn extent(&self) -> [f64; 2] {
        let [left, lower, right, upper] = self.window;
        [right - left, upper - lower]
    }

    /// The distance of the eye from the origin along the optical axis.
    pub fn distance(&self) -> f64 {
        self.eye.z
    }

    /// The same view of the vertices from another distance, which must not be smaller.
    pub fn at_distance(self, distance: f64, points: &[Point3<f64>]) -> Self {
        let eye = Vector3::new(self.eye.x, self.eye.y, distance);
        Camera { eye, window: window(&self.axes, &eye, points), ..self }
    }

    /// The same view at a scale, with a margin around the window.
    pub fn scaled(self, scale: f64, margin: f64) -> Self {
        Camera { scale, margin, ..self }
    }

    /// The same view in a picture whose longer side has `size` pixels.
    pub fn with_longer_side(self, size: f64) -> Self {
        let [width, height] = self.extent();
        self.scaled(size / width.max(height), 0.0)
    }

    /// Width and height of the picture in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.extent()
            .map(|extent| (extent * self.scale + 2.0 * self.margin).ceil().max(1.0) as usize)
    }

    /// Rows: right, up, toward the viewer.
    pub fn axes(&self) -> Matrix3<f64> {
        self.axes
    }

    /// A direction in the camera's axes.
    pub fn rotate(&self, direction: Vector3<f64>) -> Vector3<f64> {
        self.axes * direction
    }

    /// The vector from a point of the mesh to the eye, in the camera's axes.
    pub fn to_eye(&self, point: Point3<f64>) -> Vector3<f64> {
        self.eye - self.axes * point.coords
    }

    /// The width of a pixel where the reciprocal distance is w.
    pub fn pixel_width(&self, w: f64) -> f64 {
        1.0 / (w * self.scale)
    }

    /// The change of w per pixel on a surface inclined by 45 degrees.
    pub fn depth_per_pixel(&self, w: f64) -> f64 {
        w / self.scale
    }

    pub fn project(&self, point: Point3<f64>) -> Projected {
        let ray = self.to_eye(point);
        let w = 1.0 / ray.z;
        Projected {
            x: self.margin + (-ray.x * w - self.window[0]) * self.scale,
            y: self.margin + (self.window[3] + ray.y * w) * self.scale,
            w,
        }
    }
}

/// The bounding box of the projected vertices, in slopes.
fn window(axes: &Matrix3<f64>, eye: &Vector3<f64>, points: &[Point3<f64>]) -> [f64; 4] {
    let mut window = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for point in points {
        let ray = eye - axes * point.coords;
        let (x, y) = (-ray.x / ray.z, -ray.y / ray.z);
        window = [window[0].min(x), window[1].min(y), window[2].max(x), window[3].max(y)];
    }
    window
}
