//! Curvature at the vertices, of any [`CurvatureKind`].
//!
//! | kind | computed by | observed order on a torus |
//! |---|---|---|
//! | mean | the cotangent Laplacian (`mean.rs`) | 2 |
//! | mean-quadric | a quadric fitted to two rings of vertices (`quadric.rs`) | 2 |
//! | gaussian | the angle defect (`gaussian.rs`) | 2 |
//! | shape-index | the principal curvatures of the quadric | 2 |
//!
//! The shape index is S = (2 / pi) atan((k1 + k2) / (k1 - k2)) (J. J. Koenderink, A. J. van Doorn, *Surface Shape and
//! Curvature Scales*, Image and Vision Computing 10, 1992), with the sign of the mean curvature here. At umbilics it
//! takes its limits 1 and -1. It has no value where the surface is flat.

mod fan;
mod gaussian;
mod kind;
mod mean;
mod quadric;
mod size;

use std::f64::consts::FRAC_2_PI;

use super::Mesh;

#[cfg(test)]
mod tests;

pub use gaussian::gaussian_curvature;
pub use kind::CurvatureKind;
pub use mean::{mean_curvature, rounding_noise};
pub use quadric::{Quadric, quadrics};

/// A curvature at the V vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curvature {
    /// In the unit of its kind; NaN where it is undefined.
    pub values: Vec<f64>,
    /// The standard deviation of the values if coordinates are rounded; NaN or 0 where they are undefined.
    pub noise: Vec<f64>,
    /// The number of vertices without a shape index because the surface is flat there up to rounding.
    pub flat: usize,
}

/// A surface is flat if its curvedness is within this number of standard deviations.
const FLAT_DEVIATIONS: f64 = 6.0;

/// The curvature of a mesh whose coordinates are rounded by up to delta.
///
/// Vertices on the boundary take the mean of their interior neighbors. Reversing every face changes the sign of mean
/// curvatures and of the shape index, which are positive where the surface is convex as seen from the side to which
/// its faces are oriented.
pub fn at_vertices(mesh: &Mesh, kind: CurvatureKind, delta: f64) -> Curvature {
    if kind == CurvatureKind::Mean {
        let values = mean_curvature(mesh);
        return Curvature { values, noise: rounding_noise(mesh, delta), flat: 0 };
    }
    let (mesh, unit) = size::of_ordinary_size(mesh);
    let deviation = delta * unit / 3.0_f64.sqrt();
    let mut curvature = match kind {
        CurvatureKind::Mean => unreachable!("it was returned"),
        CurvatureKind::Gaussian => {
            let (values, noise) = gaussian_curvature(&mesh, delta * unit)
                .into_iter()
                .map(|[k, noise]| (k, noise))
                .unzip();
            Curvature { values, noise, flat: 0 }
        }
        CurvatureKind::MeanQuadric => {
            let mean = |quadric: Quadric| {
                let [k1, k2] = quadric.principal;
                (0.5 * (k1 + k2), deviation * quadric.gain)
            };
            let (values, noise) = quadrics(&mesh).into_iter().map(mean).unzip();
            Curvature { values, noise, flat: 0 }
        }
        CurvatureKind::ShapeIndex => shape_index(&quadrics(&mesh), deviation),
    };
    let factor = unit.powi(kind.inverse_lengths());
    curvature.values.iter_mut().for_each(|value| *value *= factor);
    curvature.noise.iter_mut().for_each(|noise| *noise *= factor);
    curvature
}

/// S, if each coordinate has the given standard deviation.
fn shape_index(quadrics: &[Quadric], deviation: f64) -> Curvature {
    let mut curvature = Curvature::default();
    for &Quadric { principal: [k1, k2], gain } in quadrics {
        let curvedness = (0.5 * (k1 * k1 + k2 * k2)).sqrt();
        let noise = deviation * gain;
        let flat = curvedness <= FLAT_DEVIATIONS * noise;
        curvature.flat += usize::from(flat);
        // The angle atan((k1 + k2) / (k1 - k2)) changes by no more than the curvedness does, relative to it.
        let (value, noise) = match flat {
            true => (f64::NAN, f64::NAN),
            false => (FRAC_2_PI * (k1 + k2).atan2(k1 - k2), FRAC_2_PI * noise / curvedness),
        };
        curvature.values.push(value);
        curvature.noise.push(noise);
    }
    curvature
}
