//! The descent of a surface at one resolution of its mesh and of the images.
//!
//! ```text
//! repeat: every few steps: statistics, U by the solver from the last U and q, mu
//!   g = gradient;  d = -H g                                                                 quasi_newton.rs
//!   X' = X + alpha d, then a part of the tangential part of (neighbor mean - X') added      smoothing.rs
//!   E(X') <= E(X) + c1 alpha <g, d>,  alpha halved until then
//! ```
//!
//! Where the smoothing costs more than the step gains, the step is made without it, so that E never rises.
//!
//! alpha starts at 1, or less if a vertex would move farther than a given length; at this length while H has no pairs. A
//! failed search is repeated without pairs, with a new U and twice as many samples a row; after three more in a row the
//! level ends.
//!
//! Reference: L. Armijo, *Minimization of functions having Lipschitz continuous first partial derivatives*, Pacific J.
//! Math. 16, 1966.

use std::ops::ControlFlow;

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::edges::{Edges, Neighbors};
use super::energy::{Energy, Sampling, Slope, Terms, Weights};
use super::images::Image;
use super::metric::Metric;
use super::quasi_newton::QuasiNewton;
use super::smoothing;
use super::surface::{Evidence, Surface};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::run::Stop;

/// c1.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// A search fails after this many halvings.
const MAX_HALVINGS: u32 = 8;

/// After a failed search pixels are sampled twice as finely, up to this many samples a row: near the minimum the sampled
/// energy is a step function, whose steps hide its slope.
const MAX_SAMPLES: usize = 4;

/// The level ends after this many failed searches in a row.
const MAX_FAILURES: u32 = 3;

/// Gap and iterations of U during the descent.
const GAP: f64 = 1e-2;
const MAX_ITERATIONS: u64 = 100;

/// How a surface descends.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The largest number of steps.
    pub steps: usize,
    /// Steps between new labels.
    pub every: usize,
    /// beta of the metric.
    pub beta: f64,
    /// Whether the colors of the regions are fitted with new labels. Far from the true surface, where a region would mix the
    /// colors of its neighbors, they are not.
    pub fits_colors: bool,
    /// The part of the tangential differences that is added after each step.
    pub smoothing: f64,
    /// The largest motion of a vertex in a step.
    pub max_move: f64,
    /// What the terms weigh.
    pub weights: Weights,
    /// How finely images are sampled.
    pub sampling: Sampling,
    /// Whether the gradient of the images is more than that of their contours.
    pub interior: bool,
}

/// One step, as in `trace.csv`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Counted over all levels.
    pub step: usize,
    /// From 0.
    pub level: usize,
    /// Counted on its level, from 0.
    #[serde(skip)]
    pub of_level: usize,
    /// E before the step.
    pub energy: f64,
    /// Its terms.
    #[serde(flatten)]
    pub terms: Terms,
    /// The largest motion of a vertex with the smoothing, in units of the mesh; 0 if the search failed.
    #[serde(rename = "move")]
    pub motion: f64,
    /// How often alpha was halved.
    pub halvings: u32,
    /// The length of the visible contours in all images, in pixels.
    pub contour_pixels: f64,
}

/// Steps from one comparison with the truth to the next.
const COMPARED_EVERY: usize = 10;

impl Step {
    /// Whether the surface is compared with the truth after this step: the first of a level, and every tenth.
    pub fn is_compared(&self) -> bool {
        self.of_level.is_multiple_of(COMPARED_EVERY)
    }
}

/// How a level ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// No step lowers the energy any further.
    Settled,
    /// The number of steps is reached.
    StepLimit,
    /// The observer ended it.
    Interrupted,
}

impl End {
    /// The end in words. Only the labels are certified.
    pub fn sentence(self) -> &'static str {
        match self {
            End::Settled => {
                "settled: no step lowers the energy further, so the surface is a local minimum; its labels are certified for it"
            }
            End::StepLimit => {
                "stopped at the step limit: the surface still moved, and is near a local minimum at best; its labels are certified \
                 for it"
            }
            End::Interrupted => {
                "interrupted: the surface reached is kept; its labels are those of the last check"
            }
        }
    }
}

/// Called after each step with the surface; may end the descent.
pub type Observer<'a> = &'a mut dyn FnMut(&Step, &Surface) -> ControlFlow<()>;

/// Descends from a surface. Steps are numbered from `first` on.
///
/// # Errors
/// Costs of labels beyond double precision.
pub fn descend(
    surface: &mut Surface,
    images: &[Image],
    settings: &Settings,
    (level, first): (usize, usize),
    observe: Observer<'_>,
) -> Result<End> {
    let Settings { weights, mut sampling, .. } = *settings;
    let edges = Edges::of(&surface.mesh);
    let neighbors = Neighbors::along(&edges, surface.mesh.vertices.len());
    let metric = Metric::new(&surface.mesh, settings.beta);
    let stop =
        Stop { relative_gap: Some(GAP), iterations: Some(MAX_ITERATIONS), ..Stop::default() };
    let mut energy: Option<Energy> = None;
    let mut newton = QuasiNewton::default();
    let mut before: Option<Before> = None;
    let mut failures = 0;
    for step in 0..settings.steps {
        if step % settings.every == 0 || energy.is_none() {
            let sums = surface.statistics(images, sampling.samples);
            let Weights { sigma, lambda, .. } = weights;
            let mut go_on = |_: Option<&_>| ControlFlow::Continue(());
            let evidence = settings.fits_colors.then_some(Evidence::Nearer);
            surface.segment(&sums, sigma, lambda, evidence, &stop, &mut go_on)?;
            let Surface { mesh, coloring, light, .. } = &*surface;
            let topology = (&edges, &neighbors);
            let whole = Energy::new(images, sampling, weights, mesh, topology, coloring, *light);
            energy = Some(if settings.interior { whole } else { whole.contours_only() });
            before = None;
        }
        let Some(current) = &energy else { unreachable!("it has just been made") };
        let Slope { terms, gradient, contour_pixels } = current.slope(&surface.mesh);
        if let Some(Before { vertices: x, gradient: g }) = before.take() {
            let s = surface.mesh.vertices.iter().zip(x).map(|(next, x)| next - x);
            newton.add(s.collect(), gradient.iter().zip(g).map(|(next, g)| next - g).collect());
        }
        let direction = newton.descend(&metric, &gradient);
        let search = Search {
            energy: current,
            mesh: &surface.mesh,
            before: terms.sum(),
            smoothing: settings.smoothing,
        };
        let longest_alpha = if newton.is_empty() { f64::INFINITY } else { 1.0 };
        let found = search.along(&direction, &gradient, longest_alpha, settings.max_move);
        let (motion, halvings) =
            found.as_ref().map_or((0.0, MAX_HALVINGS), |found| (found.motion, found.halvings));
        let record = Step {
            step: first + step,
            level,
            of_level: step,
            energy: terms.sum(),
            terms,
            motion,
            halvings,
            contour_pixels,
        };
        match found {
            Some(Found { mesh, .. }) => {
                let last = std::mem::replace(&mut surface.mesh, mesh);
                before = Some(Before { vertices: last.vertices, gradient });
                failures = 0;
            }
            None if 2 * sampling.samples <= MAX_SAMPLES => {
                sampling.samples *= 2;
                energy = None;
            }
            None => {
                failures += 1;
                energy = None;
            }
        }
        if energy.is_none() {
            newton = QuasiNewton::default();
        }
        if observe(&record, surface).is_break() {
            return Ok(End::Interrupted);
        }
        if failures == MAX_FAILURES {
            return Ok(End::Settled);
        }
    }
    Ok(End::StepLimit)
}

/// The vertices and the gradient before the last step, if the energy has been the same since.
struct Before {
    vertices: Vec<Point3<f64>>,
    gradient: Vec<Vector3<f64>>,
}

/// A search along a direction.
struct Search<'a> {
    energy: &'a Energy<'a>,
    mesh: &'a Mesh,
    /// E here.
    before: f64,
    /// The part of the tangential differences that is added.
    smoothing: f64,
}

/// A step that lowers the energy enough.
struct Found {
    mesh: Mesh,
    /// The largest motion of a vertex.
    motion: f64,
    halvings: u32,
}

impl Search<'_> {
    fn along(
        &self,
        direction: &[Vector3<f64>],
        gradient: &[Vector3<f64>],
        longest_alpha: f64,
        max_move: f64,
    ) -> Option<Found> {
        let slope: f64 = gradient.iter().zip(direction).map(|(g, d)| g.dot(d)).sum();
        let longest = direction.iter().map(Vector3::norm).fold(0.0, f64::max);
        if !(slope < 0.0 && longest > 0.0) {
            return None;
        }
        let mut alpha = longest_alpha.min(max_move / longest);
        let mut mesh = self.mesh.clone();
        for halvings in 0..MAX_HALVINGS {
            for ((x, from), d) in mesh.vertices.iter_mut().zip(&self.mesh.vertices).zip(direction) {
                *x = from + alpha * d;
            }
            let enough = self.before + SUFFICIENT_DECREASE * alpha * slope;
            let smoothed = (self.smoothing > 0.0).then(|| Mesh {
                vertices: smoothing::tangential(&mesh, self.smoothing)
                    .into_iter()
                    .map(Point3::from)
                    .collect(),
                ..mesh.clone()
            });
            for mesh in smoothed.into_iter().chain([mesh.clone()]) {
                if self.energy.terms(&mesh).sum() <= enough {
                    let moves = mesh.vertices.iter().zip(&self.mesh.vertices);
                    let motion = moves.map(|(x, from)| (x - from).norm()).fold(0.0, f64::max);
                    return Some(Found { mesh, motion, halvings });
                }
            }
            alpha *= 0.5;
        }
        None
    }
}
