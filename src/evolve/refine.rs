//! Finer faces between levels.

use super::remesh::{flip, split_long};
use super::surface::Surface;

/// An edge is flipped where the directions of its faces differ by at most this, in radians.
const FLIP_ANGLE: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// Divides the edges that are longer than `split` times the median and flips edges, or divides all faces. Labels are
/// interpolated.
pub fn refine(surface: &mut Surface, split: Option<f64>) {
    // A factor of 0 divides all faces.
    let divided = split_long(&surface.mesh, split.unwrap_or(0.0));
    let m = surface.coloring.regions();
    let interpolated = |&(a, b, weight): &(u32, u32, f64)| {
        let row = |k: u32| &surface.coloring.u[k as usize * m..][..m];
        let pairs = row(a).iter().zip(row(b));
        pairs.map(|(a, b)| (1.0 - weight) * a + weight * b).collect::<Vec<f64>>()
    };
    let u = divided.parents.iter().flat_map(interpolated).collect();
    surface.coloring.u = u;
    surface.q.clear();
    surface.mesh = match split {
        Some(_) => flip(&divided.mesh, FLIP_ANGLE).mesh,
        None => divided.mesh,
    };
}
