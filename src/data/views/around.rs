//! Calibrated cameras all around a surface.
//!
//! ```text
//! h_i = 1 - (2 i + 1) / n,   angle_i = pi (3 - sqrt 5) i        0 <= i < n
//! C_i = center + distance ( sqrt(1 - h_i^2) sin angle_i, h_i, sqrt(1 - h_i^2) cos angle_i )
//! ```
//!
//! The directions are those of a Fibonacci sphere, of about equal distances from each other. Every camera looks at the
//! center of a ball around the surface, with the y axis upwards, and the contour of that ball fills nine tenths of the
//! shorter side of the image.
//!
//! Reference: R. Swinbank, R. J. Purser, *Fibonacci grids: A novel approach to global modelling*, Q. J. R. Meteorol. Soc.
//! 132, 2006.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use nalgebra::{Matrix3, Point3, Vector3};

use super::view::View;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;

/// The share of the shorter side of an image that the ball fills.
const FILLED: f64 = 0.9;

/// The distance of the cameras from the center of the ball, in radii.
const DISTANCE: f64 = 4.0;

/// The largest number of cameras.
const MAX_CAMERAS: usize = 1000;

/// The largest number of pixels of an image.
const MAX_PIXELS: u64 = 1 << 26;

const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// Cameras around any surface; as a text `N` or `N:WxH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CamerasAround {
    /// N, from 1 to 1000.
    pub cameras: usize,
    /// Width and height of their images in pixels.
    pub size: [u32; 2],
}

impl FromStr for CamerasAround {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (cameras, size) = match text.split_once(':') {
            None => (text, Some(DEFAULT_SIZE)),
            Some((cameras, size)) => {
                let numbers = size.split_once('x').and_then(|(width, height)| {
                    Some([width.parse::<u32>().ok()?, height.parse::<u32>().ok()?])
                });
                let possible = |[width, height]: &[u32; 2]| {
                    (1..=MAX_PIXELS).contains(&(u64::from(*width) * u64::from(*height)))
                };
                (cameras, numbers.filter(possible))
            }
        };
        let cameras = cameras.parse().ok().filter(|cameras| (1..=MAX_CAMERAS).contains(cameras));
        match (cameras, size) {
            (Some(cameras), Some(size)) => Ok(CamerasAround { cameras, size }),
            (None, _) => Err(format!("the number of cameras must be from 1 to {MAX_CAMERAS}")),
            (_, None) => Err(format!(
                "the size of the images must be WxH, such as 640x480, of 1 to {MAX_PIXELS} pixels"
            )),
        }
    }
}

impl fmt::Display for CamerasAround {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let CamerasAround { cameras, size: [width, height] } = self;
        write!(f, "{cameras}:{width}x{height}")
    }
}

impl CamerasAround {
    /// Their views of a mesh that has a face with an area.
    ///
    /// # Errors
    /// Those of [`around`].
    pub fn views(&self, mesh: &Mesh) -> Result<Vec<View>> {
        let ball = Ball::of(mesh).expect("a face has an area");
        around(&ball, self.cameras, DISTANCE, self.size)
    }
}

/// A ball around a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// In the units of the mesh.
    pub center: Point3<f64>,
    /// Above 0, in the units of the mesh.
    pub radius: f64,
}

impl Ball {
    /// The smallest ball around the center of the bounding box that contains all faces; `None` if these have no extent
    /// or there are none. Vertices without faces do not count.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let corners = || mesh.faces.iter().flatten().map(|&k| mesh.vertices[k as usize]);
        let low = corners().reduce(|a, b| a.inf(&b))?;
        let high = corners().reduce(|a, b| a.sup(&b))?;
        let center = low + (high - low) / 2.0;
        let radius = corners().map(|x| (x - center).norm()).fold(0.0, f64::max);
        (radius > 0.0 && radius.is_finite()).then_some(Ball { center, radius })
    }
}

/// n views of images `view-000.png`, ... of width and height `size` in pixels, at `distance` radii from the center of the
/// ball.
///
/// # Errors
/// Coordinates that are too large for a camera.
///
/// # Panics
/// The distance is not above 1, so that the cameras are in the ball.
pub fn around(ball: &Ball, n: usize, distance: f64, size: [u32; 2]) -> Result<Vec<View>> {
    assert!(distance > 1.0);
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let shorter = f64::from(size[0].min(size[1]));
    // The rays that touch the ball have the slope 1 / sqrt(distance^2 - 1).
    let f = FILLED * shorter / 2.0 * (distance * distance - 1.0).sqrt();
    let [cx, cy] = size.map(|n| (f64::from(n) - 1.0) / 2.0);
    let k = Matrix3::new(f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0);
    let view = |i: usize| {
        let height = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let (angle, radius) = (golden * i as f64, (1.0 - height * height).sqrt());
        let out = Vector3::new(radius * angle.sin(), height, radius * angle.cos());
        let forward = -out.normalize();
        // Never along y, since |height| < 1.
        let right = forward.cross(&Vector3::y()).normalize();
        let down = forward.cross(&right);
        let r = Matrix3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
        let center = ball.center.coords - distance * ball.radius * forward;
        let camera = Pinhole::new(k, r, -(r * center))?;
        Ok(View {
            image: format!("view-{i:03}.png"),
            mask: None,
            background: None,
            size: Some(size),
            camera,
        })
    };
    (0..n).map(view).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_rotation, random_vector, rng, shape, with_isolated_vertices};

    /// The contour of the ball is a circle around the middle of the image, and up is up.
    #[test]
    fn cameras_see_the_ball_in_the_middle_of_their_images() {
        let mut rng = rng(31);
        for (n, distance, size) in [(1, 4.0, [64, 48]), (24, 1.5, [30, 31]), (7, 20.0, [640, 480])]
        {
            let center = Point3::from(5.0 * random_vector(&mut rng));
            let ball = Ball { center, radius: 0.3 };
            let views = around(&ball, n, distance, size).unwrap();
            assert_eq!(views.len(), n);
            for View { camera, size: found, .. } in views {
                assert_eq!(found, Some(size));
                let from_center = (camera.center() - ball.center) / ball.radius;
                assert!((from_center.norm() - distance).abs() <= 1e-12 * distance);
                let middle = size.map(|n| (f64::from(n) - 1.0) / 2.0);
                let seen = |x: Point3<f64>| camera.project(x);
                let at = seen(ball.center);
                assert!((at.x - middle[0]).hypot(at.y - middle[1]) <= 1e-9);
                // The rays that touch the ball do so at this distance from its center, towards the camera.
                let out = from_center.normalize();
                let side = out.cross(&(random_rotation(&mut rng) * out)).normalize();
                let (near, far) = (1.0 / distance, (1.0 - distance.powi(-2)).sqrt());
                let at = seen(ball.center + ball.radius * (near * out + far * side));
                let reach = (at.x - middle[0]).hypot(at.y - middle[1]);
                let expected = 0.45 * f64::from(size[0].min(size[1]));
                assert!((reach - expected).abs() <= 1e-9 * expected, "{reach} {expected}");
                assert!(seen(ball.center + 0.01 * Vector3::y()).y < middle[1]);
            }
        }
    }

    #[test]
    fn directions_are_spread_over_the_sphere() {
        let ball = Ball { center: Point3::origin(), radius: 1.0 };
        let views = around(&ball, 60, 2.0, [10, 10]).unwrap();
        let out: Vec<_> = views.iter().map(|view| view.camera.center().coords / 2.0).collect();
        let mean = out.iter().sum::<Vector3<f64>>() / 60.0;
        assert!(mean.norm() < 0.02, "{mean}");
        for (i, a) in out.iter().enumerate() {
            let nearest =
                out.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, b)| (a - b).norm());
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            // Disks of this diameter cover 40 % of the sphere, and 90 % if they are packed as densely as possible.
            assert!((0.32..0.49).contains(&nearest), "{nearest}");
        }
    }

    #[test]
    fn balls_are_those_of_the_faces() {
        let sphere = shape("sphere:3");
        let ball = Ball::of(&with_isolated_vertices(sphere.clone().scaled(3.0))).unwrap();
        assert!((ball.radius - 3.0).abs() <= 1e-12 && ball.center.coords.norm() <= 1e-12);
        assert_eq!(Ball::of(&Mesh::new(sphere.vertices, Vec::new())), None);
        let point = Mesh::new(vec![Point3::new(1.0, 2.0, 3.0)], vec![[0, 0, 0]]);
        assert_eq!(Ball::of(&point), None);
    }
}
