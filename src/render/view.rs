//! The choice of a view that shows what there is to see.
//!
//! A flat mesh is seen straight on. Others are tried from all around their up axis, slightly from above, at low
//! resolution; the view with the best sum of visible area, visible cut and visible regions wins, each in
//! proportion to the best that any of the views offers. Regions count double, or small ones would stay hidden.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::bands;
use super::camera::{Camera, half_slope};
use super::labels::LabelField;
use super::visibility::Visibility;
use crate::mesh::Mesh;

const SIZE: usize = 128;
const AZIMUTHS: usize = 12;
/// Of visible area, cut and regions.
const WEIGHTS: [f64; 3] = [1.0, 1.0, 2.0];
/// How much better a later candidate must be, so that rounding does not decide between equals.
const MARGIN: f64 = 1e-3;
/// Tangents of the heights above the horizon, and how much a view from there is liked: the higher one is for
/// shapes that lie.
const ELEVATIONS: [(f64, f64); 2] = [(0.25, 1.0), (0.9, 0.8)];
/// Thinner than this share of its length, a mesh counts as flat.
const FLAT: f64 = 0.02;
/// Z is up if the mesh is this much taller along it than wide.
const TALL: f64 = 1.5;

/// `mesh` is centered and has no unreferenced vertices.
pub(super) fn choose(mesh: &Mesh, component: &[u32], field: &LabelField) -> Camera {
    if let Some((towards, up)) = straight_on(mesh) {
        return Camera::fit(towards, up, &mesh.vertices);
    }
    let up = up_axis(mesh);
    let front = if up == Vector3::y() { Vector3::z() } else { -Vector3::y() };
    let side = up.cross(&front);
    let mut cameras = Vec::new();
    for (elevation, _) in ELEVATIONS {
        for i in 0..AZIMUTHS {
            let (sine, cosine) = (TAU * i as f64 / AZIMUTHS as f64).sin_cos();
            let horizontal = cosine * front + sine * side;
            let towards = horizontal + elevation * up;
            cameras.push(Camera::fit(towards, up, &mesh.vertices));
        }
    }
    let merits = bands::map(&cameras, |camera| merit(mesh, component, field, camera));
    let best = [0, 1, 2].map(|c| merits.iter().map(|merit| merit[c]).fold(0.0, f64::max));
    let score = |i: usize| -> f64 {
        let terms = (0..3).filter(|&c| best[c] > 0.0);
        let sum: f64 = terms.map(|c| WEIGHTS[c] * merits[i][c] / best[c]).sum();
        sum * ELEVATIONS[i / AZIMUTHS].1
    };
    let mut chosen = 0;
    for i in 1..cameras.len() {
        if score(i) > (1.0 + MARGIN) * score(chosen) {
            chosen = i;
        }
    }
    cameras.swap_remove(chosen)
}

/// The direction to the viewer of a flat mesh, and its up.
fn straight_on(mesh: &Mesh) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let count = mesh.vertices.len() as f64;
    let mean = mesh.vertices.iter().map(|x| x.coords).sum::<Vector3<f64>>() / count;
    let mut covariance = Matrix3::zeros();
    for x in &mesh.vertices {
        let offset = x.coords - mean;
        covariance += offset * offset.transpose();
    }
    let eigen = covariance.symmetric_eigen();
    let (least, value) = eigen.eigenvalues.argmin();
    if value.max(0.0).sqrt() > FLAT * eigen.eigenvalues.max().sqrt() {
        return None;
    }
    let normal: Vector3<f64> = eigen.eigenvectors.column(least).into();
    let facing: f64 = (0..mesh.faces.len()).map(|j| mesh.area_vector(j).dot(&normal)).sum();
    let towards = if facing < 0.0 { -normal } else { normal };
    let up = if normal.y.abs() < 0.9 { Vector3::y() } else { -Vector3::z() };
    Some((towards, up))
}

fn up_axis(mesh: &Mesh) -> Vector3<f64> {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for x in &mesh.vertices {
        low = low.inf(&x.coords);
        high = high.sup(&x.coords);
    }
    let extent = high - low;
    if extent.z > TALL * extent.x.max(extent.y) { Vector3::z() } else { Vector3::y() }
}

/// Visible area, visible length of the cut, and how evenly the regions show: the exponential of the entropy of
/// their shares of the picture, which is m for m equal shares.
fn merit(mesh: &Mesh, component: &[u32], field: &LabelField, camera: &Camera) -> [f64; 3] {
    let visibility = Visibility::new(mesh, component, camera, SIZE);
    let regions = field.seen(&visibility);
    let mut area = 0.0;
    let mut seen = Vec::new();
    for (i, &p) in regions.iter().enumerate() {
        if let Some(j) = visibility.face(i) {
            let ray = camera.to_eye(mesh.corners(j)[0]);
            let normal = camera.rotate(mesh.area_vector(j));
            let cosine = normal.dot(&ray).abs() / (normal.norm() * ray.norm());
            area += (2.0 * half_slope() * ray.z / SIZE as f64).powi(2) / cosine.max(0.25);
            if seen.len() <= p as usize {
                seen.resize(p as usize + 1, 0.0);
            }
            seen[p as usize] += 1.0;
        }
    }
    let total: f64 = seen.iter().sum();
    let entropy: f64 = seen
        .iter()
        .filter(|&&count| count > 0.0)
        .map(|count| -(count / total) * (count / total).ln())
        .sum();
    let cut = field.crossings(&visibility, &regions).len() as f64;
    [area, cut, entropy.exp()]
}
