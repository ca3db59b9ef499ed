//! Surfaces that evolve until they look like their images.
//!
//! ```text
//! E(X, U, mu) = sigma sum_i int_image_i e_i dw + lambda TV(U) + kappa Area + (eta / 2) |L X|^2
//! e = sum_p u_p |I - s mu_p|^2 where a ray meets the surface X first,   |I - b|^2 elsewhere
//! ```
//!
//! U, mu and X take turns: labels by the solver for the costs of the surface as it is (`labels.rs`), colors by their
//! formula (`statistics.rs`), and descent on the vertices in a Sobolev metric (`descent.rs`), on a coarse mesh and coarse
//! images first. The labels are certified for the last surface. The surface is a local minimum: nothing certifies it, and
//! its topology stays that of the start.
//!
//! Reference for the data term: Delaunoy et al., ICCV 2009, section 3.2. For the contours and what is behind them:
//! P. Gargallo, E. Prados, P. Sturm, *Minimizing the reprojection error in surface reconstruction from images*, ICCV 2007;
//! A. Delaunoy, E. Prados, *Gradient flows for optimizing triangular mesh-based surfaces: applications to 3D reconstruction
//! problems dealing with visibility*, IJCV 95, 2011.

mod area;
mod bins;
mod clusters;
mod coloring;
mod contour;
mod covered;
mod descent;
mod edges;
mod energy;
pub mod folds;
pub mod images;
mod interior;
mod labels;
mod length;
mod lit;
mod metric;
mod plan;
mod quality;
pub mod remesh;
mod roughness;
mod scene;
pub mod silhouette;
pub mod smoothing;
pub mod start;
mod statistics;
mod surface;

use std::ops::ControlFlow;

use ndarray::Array2;

pub use coloring::Coloring;
pub use descent::{End, Step};
pub use energy::{Sampling, Terms};
pub use lit::Light;
pub use metric::Metric;
pub use plan::Plan;
pub use quality::Quality;
pub use surface::Surface;

use descent::{Settings, descend};
use edges::{Edges, Neighbors};
use energy::{Energy, Weights};
use images::{Background, Image, Shot, pixel_length};
use remesh::{flip, split_long};
use surface::{Evidence, costs};

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::distance::{Distances, between};
use crate::mesh::geometry::barycentric_areas;
use crate::operator::Mass;
use crate::rounding::Rounding;
use crate::run::Stop;
use crate::solve::{Request, Solution, check_mesh, solve};
use crate::solver::Method;
use crate::start::Start;
use crate::sweep;

/// Images are shrunk as long as the mean edge of the mesh has at least this many pixels.
const EDGE_PIXELS: f64 = 4.0;

/// The largest motion of a vertex in a step: a share of the diameter of the surface on the first level, pixels on others.
const FIRST_MOVE: f64 = 0.03;
const LATER_MOVE: f64 = 1.5;

/// beta on the first level, on which vertices move far, in units of that of later ones.
const FIRST_BETA: f64 = 2.0;

/// Steps between new labels.
const EVERY: usize = 5;

/// Steps between distances to the truth in the trace.
const DISTANCE_EVERY: usize = 10;

/// An edge is flipped where the directions of its faces differ by at most this, in radians.
const FLIP_ANGLE: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// When the surface rests, labels and colors take turns this many times.
const LAST_FITS: usize = 3;

/// Gap and iterations of the last labels.
const LAST_GAP: f64 = 1e-4;
const LAST_ITERATIONS: u64 = 20_000;

/// A surface that was reconstructed.
pub struct Reconstruction {
    /// The surface, with its labels and colors.
    pub surface: Surface,
    /// The labels with their certificate for the surface; `None` for one region.
    pub solution: Option<Solution>,
    /// The energy of this surface with these labels.
    pub terms: Terms,
    /// sigma and lambda.
    pub sigma: f64,
    /// lambda for the surface as it is.
    pub lambda: f64,
    /// How well it agrees with the images.
    pub quality: Quality,
    /// Distances to the true surface, if that is given.
    pub distances: Option<Distances>,
    /// All steps.
    pub trace: Vec<(Step, Option<f64>)>,
    /// The levels so far.
    pub levels: Vec<Level>,
}

/// A level of mesh and images.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Level {
    /// V.
    pub vertices: usize,
    /// F.
    pub faces: usize,
    /// The images are at 1/k of their resolution.
    pub shrunk: usize,
    /// Steps on this level.
    pub steps: usize,
    /// How it ended.
    #[serde(skip)]
    pub end: End,
}

/// What happens on the way.
pub enum Event<'a> {
    /// A step was made; the distance to the truth is there now and then, if that is given.
    Step(&'a Step, Option<f64>),
    /// A level has ended, and another one follows.
    Level(&'a Reconstruction),
    /// The labels of a surface at rest are being computed.
    Labels,
}

/// Called when something happens; may interrupt the reconstruction, which then ends with the surface that it has reached.
pub type Watch<'a> = &'a mut dyn FnMut(Event<'_>) -> Result<ControlFlow<()>>;

/// Reconstructs a surface of the topology of the start from its images, in the units of their cameras.
///
/// # Errors
/// A plan out of range; fewer than two images; a start that no image shows; images that show only background; what `watch`
/// reports.
pub fn reconstruct(
    shots: &[Shot],
    start: &Mesh,
    truth: Option<&Mesh>,
    plan: &Plan,
    watch: Watch<'_>,
) -> Result<Reconstruction> {
    plan.check()?;
    check_mesh(start)?;
    if shots.len() < 2 {
        return Err(Error::unsuitable("one view does not determine a surface; give at least two"));
    }
    let cameras: Vec<_> = shots.iter().map(|shot| shot.view.camera).collect();
    let start = Mesh::new(start.vertices.clone(), start.faces.clone());
    let start = start.without_degenerate_faces().0.into_owned();
    let unseen = || {
        Error::unsuitable(
            "no view sees the start surface; check that it has the coordinates of the cameras, or give another --start",
        )
    };
    let pixel = pixel_length(&cameras, &start).ok_or_else(unseen)?;
    let mut images = images_for(shots, &start, pixel);
    let weights = weights(&images.1, &start, plan).ok_or_else(unseen)?;
    let mut surface = first_surface(start, shots, plan)?;
    let (mut trace, mut levels) = (Vec::new(), Vec::new());
    loop {
        let level = levels.len();
        let (shrunk, of_level) = &images;
        let settings = Settings {
            steps: plan.steps,
            every: EVERY,
            beta: if level == 0 { FIRST_BETA * plan.beta } else { plan.beta },
            smoothing: plan.smoothing,
            max_move: match level {
                0 => FIRST_MOVE * (surface.mesh.area() / std::f64::consts::PI).sqrt(),
                _ => LATER_MOVE * pixel * *shrunk as f64,
            },
            weights,
            sampling: plan.sampling,
        };
        let first = trace.len();
        let mut failure = None;
        let mut observe = |step: &Step, surface: &Surface| {
            let due = (step.step - first).is_multiple_of(DISTANCE_EVERY);
            let truth = truth.filter(|_| due);
            let distance = truth.map(|truth| between(&surface.mesh, truth).mean);
            let flow = watch(Event::Step(step, distance));
            trace.push((step.clone(), distance));
            flow.unwrap_or_else(|error| {
                failure = Some(error);
                ControlFlow::Break(())
            })
        };
        let end = descend(&mut surface, of_level, &settings, (level, first), &mut observe)?;
        if let Some(error) = failure {
            return Err(error);
        }
        levels.push(Level {
            vertices: surface.mesh.vertices.len(),
            faces: surface.mesh.faces.len(),
            shrunk: *shrunk,
            steps: trace.len() - first,
            end,
        });
        let at_rest = AtRest { shots, truth, plan, images: of_level, weights };
        let (trace_so_far, levels_so_far) = (trace.clone(), levels.clone());
        let found = at_rest.reconstruction(&surface, trace_so_far, levels_so_far, watch)?;
        if end == End::Interrupted || levels.len() == plan.levels {
            return Ok(found);
        }
        if watch(Event::Level(&found))?.is_break() {
            return Ok(found);
        }
        refine(&mut surface, plan.split);
        images = images_for(shots, &surface.mesh, pixel);
    }
}

/// Finer faces, with the labels interpolated.
fn refine(surface: &mut Surface, split: Option<f64>) {
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

/// The images at the resolution that suits a mesh, and the number k of pixels in a row that became one.
fn images_for(shots: &[Shot], mesh: &Mesh, pixel: f64) -> (usize, Vec<Image>) {
    let edges = Edges::of(mesh);
    let length =
        |[a, b]: &[u32; 2]| (mesh.vertices[*a as usize] - mesh.vertices[*b as usize]).norm();
    let mean = edges.ends.iter().map(length).sum::<f64>() / edges.ends.len() as f64;
    let mut shrunk = 1;
    while mean >= 2.0 * EDGE_PIXELS * pixel * shrunk as f64 {
        shrunk *= 2;
    }
    (shrunk, sweep::results(shots.iter().collect(), |shot: &Shot| shot.image(shrunk)))
}

/// sigma = A / sum_k W_k of the start, and lambda for its area; `None` if no image shows it.
fn weights(images: &[Image], start: &Mesh, plan: &Plan) -> Option<Weights> {
    let sums = statistics::statistics(images, start, None, plan.sampling.samples, &[]);
    let pixels: f64 = sums.iter().map(|sums| sums.w).sum();
    let area = start.area();
    (pixels > 0.0).then(|| Weights {
        sigma: area / pixels,
        lambda: plan.lambda * area.sqrt(),
        kappa: plan.kappa,
        eta: plan.eta,
    })
}

/// The start with its first colors.
fn first_surface(mesh: Mesh, shots: &[Shot], plan: &Plan) -> Result<Surface> {
    let of_masks = shots.iter().any(|shot| matches!(shot.background, Background::Mask));
    if of_masks && plan.regions > 1 {
        return Err(Error::unsuitable("masks have one region; use --regions 1"));
    }
    let mu = match of_masks {
        true => vec![[1.0; 3]],
        false => clusters::colors(shots, plan.regions, plan.seed)?,
    };
    let u = if plan.regions == 1 { vec![1.0; mesh.vertices.len()] } else { Vec::new() };
    let coloring = Coloring { u, mu };
    Ok(Surface { mesh, coloring, q: Vec::new(), light: plan.light, fits_colors: !of_masks })
}

/// What a surface at rest is judged by.
struct AtRest<'a> {
    shots: &'a [Shot],
    truth: Option<&'a Mesh>,
    plan: &'a Plan,
    images: &'a [Image],
    weights: Weights,
}

impl AtRest<'_> {
    /// The labels and the colors for all pixels, certified, and the quality of the surface.
    fn reconstruction(
        &self,
        surface: &Surface,
        trace: Vec<(Step, Option<f64>)>,
        levels: Vec<Level>,
        watch: Watch<'_>,
    ) -> Result<Reconstruction> {
        let Weights { sigma, lambda, .. } = self.weights;
        let samples = self.plan.sampling.samples;
        let mut surface = surface.clone();
        let mut go_on = |_: Option<&_>| watch(Event::Labels).unwrap_or(ControlFlow::Continue(()));
        let stop = Stop {
            relative_gap: Some(LAST_GAP),
            iterations: Some(LAST_ITERATIONS),
            ..Stop::default()
        };
        for _ in 0..LAST_FITS {
            let sums = surface.statistics(self.images, samples);
            surface.segment(&sums, sigma, lambda, Evidence::All, &stop, &mut go_on)?;
        }
        let m = surface.coloring.regions();
        let mut solution = None;
        let sums = surface.statistics(self.images, samples);
        if m > 1 {
            let f = costs(&sums, &surface.coloring.mu, sigma);
            let area = barycentric_areas(&surface.mesh);
            // f is that of the images, whatever the areas of the vertices; those that are not seen are unknown.
            let seen = |k: usize| if sums[k].w > 0.0 { 1.0 } else { f64::NAN };
            let cost = |(k, p): (usize, usize)| seen(k) * f[k * m + p] / area[k];
            let s = Array2::from_shape_fn((area.len(), m), cost);
            let request = Request {
                lambda,
                mass: Mass::Barycentric,
                method: Method::default(),
                stop,
                coarse_to_fine: false,
                keep_dual: false,
                rounding: Rounding::default(),
                label_gap: None,
            };
            let u = Array2::from_shape_vec((area.len(), m), surface.coloring.u.clone());
            let start = u.map_or(Start::Argmin, Start::Given);
            let found = solve(&surface.mesh, &s, &start, &request, &mut go_on)?;
            surface.coloring.u = found.u.iter().copied().collect();
            solution = Some(found);
        }
        let edges = Edges::of(&surface.mesh);
        let neighbors = Neighbors::along(&edges, surface.mesh.vertices.len());
        let Surface { mesh, coloring, light, .. } = &surface;
        let (sampling, topology) = (self.plan.sampling, (&edges, &neighbors));
        let energy =
            Energy::new(self.images, sampling, self.weights, mesh, topology, coloring, *light);
        Ok(Reconstruction {
            terms: energy.terms(mesh),
            quality: Quality::of(mesh, coloring, &sums, self.shots, self.truth),
            distances: self.truth.map(|truth| between(mesh, truth)),
            solution,
            sigma,
            lambda,
            trace,
            levels,
            surface,
        })
    }
}

#[cfg(test)]
mod tests;
