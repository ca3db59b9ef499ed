//! A surface at rest: its last labels and colors, with the certificate of the labels, and its quality.

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use super::descent::{End, Step};
use super::edges::{Edges, Neighbors};
use super::energy::{Energy, Terms, Weights};
use super::images::{Image, Shot};
use super::plan::Plan;
use super::quality::Quality;
use super::surface::{Evidence, Surface, costs};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::distance::{Distances, between};
use crate::mesh::geometry::barycentric_areas;
use crate::operator::Mass;
use crate::relaxation::Relaxation;
use crate::rounding::Rounding;
use crate::run::Stop;
use crate::solve::{Observer, Request, Solution, solve};
use crate::solver::Method;
use crate::start::Start;

/// Labels and colors take turns this many times.
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
    /// All steps, now and then with the distance of the surface before the step to the truth.
    pub trace: Vec<(Step, Option<f64>)>,
    /// The levels so far.
    pub levels: Vec<Level>,
}

impl Reconstruction {
    /// How the last level ended.
    pub fn end(&self) -> End {
        self.levels.last().map_or(End::StepLimit, |level| level.end)
    }
}

/// A level of mesh and images.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    pub end: End,
}

/// What a surface at rest is judged by.
pub struct AtRest<'a> {
    pub shots: &'a [Shot],
    pub truth: Option<&'a Mesh>,
    pub plan: &'a Plan,
    pub images: &'a [Image],
    pub weights: Weights,
}

impl AtRest<'_> {
    /// The labels and the colors for all pixels, certified, and the quality of the surface.
    pub fn reconstruction(
        &self,
        surface: &Surface,
        trace: Vec<(Step, Option<f64>)>,
        levels: Vec<Level>,
        go_on: Observer<'_>,
    ) -> Result<Reconstruction> {
        let Weights { sigma, lambda, .. } = self.weights;
        let samples = self.plan.sampling.samples;
        let mut surface = surface.clone();
        let stop = Stop {
            relative_gap: Some(LAST_GAP),
            iterations: Some(LAST_ITERATIONS),
            ..Stop::default()
        };
        for _ in 0..LAST_FITS {
            let sums = surface.statistics(self.images, samples);
            surface.segment(&sums, sigma, lambda, Some(Evidence::All), &stop, &mut *go_on)?;
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
                relaxation: Relaxation::default(),
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
            let found = solve(&surface.mesh, &s, &start, &request, &mut *go_on)?;
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
