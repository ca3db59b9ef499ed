//! The level lines {u = t} of two regions, and a threshold t by the coarea formula.
//!
//! ```text
//! E(t) = sum_k f_k,0 [u_k >= t] + f_k,1 [u_k < t] + sqrt(2) lambda |{u = t}|          int_0^1 E(t) dt = E(U)
//! ```
//!
//! for u linear on each face: sum_j |(K U)_j| is sqrt(2) times the total variation of u, which is the integral of the lengths
//! of the level lines. Hence E(t) <= E(U) for some t. On one of the halves of an interval, the mean of E is at most
//! that on the whole; bisection ends at the first midpoint whose energy is at most the mean on its interval.

use nalgebra::Vector3;

use crate::mesh::Mesh;
use crate::sweep::sum;

/// Bisections at most: then intervals are shorter than the rounding of U in [`Cells`](super::Cells).
const BISECTIONS: u32 = 40;

/// The relative rounding error of sums over the mesh.
const ROUNDING: f64 = 1e-12;

/// Where the level line {u = t} meets a face, if it does: corner i is on its side alone, and the ends of the line are
/// x_i + alpha (x_j - x_i) for the two other corners j.
pub struct LevelLine {
    /// Corner i and the two others, in the orientation of the face.
    pub corners: [usize; 3],
    /// One for each of the others.
    pub alpha: [f64; 2],
}

impl LevelLine {
    /// The line between the corners with u above t and the others.
    #[inline]
    pub fn new(u: [f64; 3], t: f64, is_above: [bool; 3]) -> Option<Self> {
        let alone = |&i: &usize| {
            is_above[i] != is_above[(i + 1) % 3] && is_above[i] != is_above[(i + 2) % 3]
        };
        let i = (0..3).find(alone)?;
        let others = [(i + 1) % 3, (i + 2) % 3];
        let alpha = others.map(|j| (u[i] - t) / (u[i] - u[j]));
        Some(LevelLine { corners: [i, others[0], others[1]], alpha })
    }

    /// Its length in a face with the corners x.
    #[inline]
    pub fn length(&self, x: [Vector3<f64>; 3]) -> f64 {
        let [i, j, k] = self.corners;
        (self.alpha[1] * (x[k] - x[i]) - self.alpha[0] * (x[j] - x[i])).norm()
    }
}

/// A threshold t with E(t) <= E(U) up to rounding, preferably 1/2, for two regions with integrated costs f and lambda;
/// `energy` is E(U), and u(k) is the first entry of u_k.
pub fn threshold(
    mesh: &Mesh,
    f: impl Fn(usize) -> [f64; 2] + Sync,
    lambda: f64,
    u: impl Fn(usize) -> f64 + Sync,
    energy: f64,
) -> f64 {
    let length = |j: usize, t: f64| {
        let u = mesh.faces[j].map(|v| u(v as usize));
        let line = LevelLine::new(u, t, u.map(|u| u >= t));
        line.map_or(0.0, |line| line.length(mesh.corners(j).map(|x| x.coords)))
    };
    let weight = std::f64::consts::SQRT_2 * lambda;
    let at = |t: f64| {
        let data = sum(mesh.vertices.len(), |k| f(k)[usize::from(u(k) < t)]);
        data + weight * sum(mesh.faces.len(), |j| length(j, t))
    };
    // The mean of E on an interval. The length of a line in a face is linear between the values at the corners.
    let mean = |[a, b]: [f64; 2]| {
        let data = sum(mesh.vertices.len(), |k| {
            let share = (u(k).clamp(a, b) - a) / (b - a);
            // A forbidden label has no share.
            let [first, second] = f(k);
            (if share > 0.0 { share * first } else { 0.0 })
                + if share < 1.0 { (1.0 - share) * second } else { 0.0 }
        });
        let lines = sum(mesh.faces.len(), |j| {
            let mut ends = mesh.faces[j].map(|v| u(v as usize).clamp(a, b));
            ends.sort_unstable_by(f64::total_cmp);
            let part = |low: f64, high: f64| {
                if low < high { (high - low) * length(j, 0.5 * (low + high)) } else { 0.0 }
            };
            part(ends[0], ends[1]) + part(ends[1], ends[2])
        });
        data + weight * lines / (b - a)
    };
    let (mut interval, mut mean_on_interval) = ([0.0, 1.0], energy);
    for _ in 0..BISECTIONS {
        let [a, b] = interval;
        let middle = 0.5 * (a + b);
        let excess = at(middle) - mean_on_interval;
        if excess <= ROUNDING * energy.abs() || excess.is_nan() {
            break;
        }
        let halves = [[a, middle], [middle, b]];
        let means = halves.map(mean);
        let lower = usize::from(means[1] < means[0]);
        (interval, mean_on_interval) = (halves[lower], means[lower]);
    }
    0.5 * (interval[0] + interval[1])
}
