//! A dental arch: fourteen crowns, region 1 to 14 from one end to the other, in gums, region 0.
//!
//! ```text
//! r = 14 u mod 1,   b = 2 sqrt( r (1 - r) )          0 between two teeth, 1 in the middle of one
//! x(u, v) = c(u) - w n(u) cos(pi v) + h e_z sin(pi v)   an arch across the ellipse c with normals n
//! crown:  sin(pi v) > 0.5 + 0.15 (1 - b)                the gums rise between teeth
//! ```
//!
//! The half width w and the height h follow b on crowns and are constant on gums, so that there are grooves between teeth;
//! molars are wider than incisors. Below, and at both ends, the surface is open, as a scan is.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

/// Gums and teeth.
pub const PARTS: usize = 1 + TEETH;

const TEETH: usize = 14;

/// The share of the half ellipse at each end that has no teeth.
const MARGIN: f64 = 0.02;

/// The depth of the arch; its half width is 1.
const DEPTH: f64 = 1.25;

const HEIGHT: f64 = 0.34;

/// Over which range of sin(pi v) crowns rise from the gums.
const TRANSITION: f64 = 0.15;

/// The region at (u, v), 0 to 1 each.
pub fn part(u: f64, v: f64) -> usize {
    let Place { tooth, above, .. } = Place::at(u, v);
    if above > 0.0 { 1 + tooth } else { 0 }
}

/// x(u, v).
pub fn point(u: f64, v: f64) -> Point3<f64> {
    let Place { tooth, b, above } = Place::at(u, v);
    let t = PI * (1.0 - MARGIN - (1.0 - 2.0 * MARGIN) * u);
    let c = Vector3::new(t.cos(), DEPTH * t.sin(), 0.0);
    let n = Vector3::new(DEPTH * t.cos(), t.sin(), 0.0).normalize();
    // From incisors, 0, to molars, 1.
    let back = (2.0 * tooth as f64 / (TEETH - 1) as f64 - 1.0).abs();
    let crown = smooth_step(above / TRANSITION + 0.5);
    let w = (0.10 + 0.06 * back) * (1.15 + crown * (0.55 + 0.45 * b - 1.15));
    let h = HEIGHT * (1.0 + crown * (0.82 + 0.18 * b - 1.0));
    let (sin, cos) = (PI * v).sin_cos();
    Point3::from(c - w * cos * n + h * sin * Vector3::z())
}

/// What is at (u, v).
struct Place {
    /// The nearest tooth along the arch, from 0.
    tooth: usize,
    b: f64,
    /// How far sin(pi v) is above the gums; positive on the crown.
    above: f64,
}

impl Place {
    fn at(u: f64, v: f64) -> Self {
        let along = TEETH as f64 * u;
        let tooth = (along as usize).min(TEETH - 1);
        let r = along - tooth as f64;
        let b = 2.0 * (r * (1.0 - r)).max(0.0).sqrt();
        Place { tooth, b, above: (PI * v).sin() - (0.5 + 0.15 * (1.0 - b)) }
    }
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
