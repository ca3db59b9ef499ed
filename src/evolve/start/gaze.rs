//! Where cameras look, and the ball that all of them see.
//!
//! ```text
//! x = argmin sum_i |(I - d_i d_i^T) (x - C_i)|^2        d_i: the ray through the middle of image i
//! ```
//!
//! x is the point nearest to all these rays; the ball around it reaches up to the pyramids of rays through the borders of
//! the images.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::data::views::Ball;
use crate::error::{Error, Result};
use crate::optics::pinhole::Pinhole;

/// The smallest eigenvalue of the normal matrix, per camera, below which the rays count as parallel: two cameras whose
/// directions differ by a degree have half of this.
const LEAST_CURVATURE: f64 = 1.5e-4;

/// The largest ball, around the point at which the cameras look, that every image shows whole. Each camera comes with the
/// width and height of its image in pixels.
///
/// # Errors
/// There are no cameras, they look in the same direction, or that point is outside of an image.
pub fn around(cameras: &[(Pinhole, [usize; 2])]) -> Result<Ball> {
    let center = convergence(cameras)?;
    let radius = cameras.iter().map(|(camera, size)| distance_to_pyramid(camera, *size, center));
    let radius = radius.fold(f64::INFINITY, f64::min);
    if radius > 0.0 {
        return Ok(Ball { center, radius });
    }
    Err(Error::unsuitable(
        "the cameras do not all look at one point, so that no sphere to start from can be chosen; give its center and \
         radius with --start sphere:X,Y,Z,R",
    ))
}

/// The point nearest to the rays through the middles of the images.
pub fn convergence(cameras: &[(Pinhole, [usize; 2])]) -> Result<Point3<f64>> {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (camera, size) in cameras {
        let d = ray(camera, size.map(|n| (n as f64 - 1.0) / 2.0)).normalize();
        let across = Matrix3::identity() - d * d.transpose();
        matrix += across;
        right += across * camera.center().coords;
    }
    let curvature = matrix.symmetric_eigenvalues().min();
    let solution = matrix.cholesky().map(|factors| Point3::from(factors.solve(&right)));
    match solution.filter(|_| curvature > LEAST_CURVATURE * cameras.len() as f64) {
        Some(center) => Ok(center),
        None => Err(Error::unsuitable(
            "the cameras look in about the same direction, so that the distance of the surface is unknown; give a start \
             with --start sphere:X,Y,Z,R or --start MESH",
        )),
    }
}

/// The direction R^T K^-1 (w, 1) of the ray through a point of the image.
fn ray(camera: &Pinhole, [x, y]: [f64; 2]) -> Vector3<f64> {
    let ([fx, skew, cx, _, fy, cy, ..], r, _) = camera.numbers();
    let across = (y - cy) / fy;
    Matrix3::from_row_slice(&r).transpose()
        * Vector3::new((x - cx - skew * across) / fx, across, 1.0)
}

/// The distance from a point to the nearest side of the pyramid of rays of an image; negative outside of it.
fn distance_to_pyramid(camera: &Pinhole, size: [usize; 2], x: Point3<f64>) -> f64 {
    let [right, bottom] = size.map(|n| n as f64 - 0.5);
    let corners = [[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]];
    let rays = corners.map(|corner| ray(camera, corner));
    let distance = |i: usize| {
        // Clockwise in the image, whose y axis points down: these normals point inwards.
        let inwards = rays[i].cross(&rays[(i + 1) % 4]).normalize();
        inwards.dot(&(x - camera.center()))
    };
    (0..4).map(distance).fold(f64::INFINITY, f64::min)
}
