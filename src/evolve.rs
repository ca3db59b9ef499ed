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
mod at_rest;
mod bins;
mod clusters;
mod coloring;
mod contour;
mod covered;
mod descent;
mod edges;
mod energy;
mod events;
pub mod folds;
pub mod images;
mod interior;
mod labels;
mod length;
mod lit;
mod metric;
mod plan;
mod quality;
mod quasi_newton;
mod refine;
pub mod remesh;
mod roughness;
mod scene;
pub mod shots;
pub mod silhouette;
pub mod smoothing;
pub mod start;
mod statistics;
mod summary;
mod surface;

use std::ops::ControlFlow;

pub use at_rest::{Level, Reconstruction};
pub use coloring::Coloring;
pub use descent::{End, Step};
pub use energy::{Sampling, Terms};
pub use events::Event;
pub use lit::Light;
pub use metric::Metric;
pub use plan::Plan;
pub use quality::{Quality, known_silhouettes};
pub use summary::Summary;
pub use surface::Surface;

use at_rest::AtRest;
use descent::{Settings, descend};
use edges::Edges;
use energy::Weights;
use images::{Background, Image, Shot, pixel_length};
use refine::refine;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::distance::between;
use crate::solve::check_mesh;
use crate::sweep;

/// Called when something happens; may interrupt the reconstruction, which then ends with the surface that it has reached.
pub type Watch<'a> = &'a mut dyn FnMut(Event<'_>) -> Result<ControlFlow<()>>;

/// Images are shrunk as long as the mean edge of the mesh has at least this many pixels.
const EDGE_PIXELS: f64 = 4.0;

/// The largest motion of a vertex in a step: a share of the diameter of the surface on the first level, pixels on others.
const FIRST_MOVE: f64 = 0.03;
const LATER_MOVE: f64 = 1.5;

/// Steps between new labels.
const EVERY: usize = 5;

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
    let mut images = images_for(shots, &start, pixel, plan);
    let weights = weights(&images.1, &start, plan).ok_or_else(unseen)?;
    let mut surface = first_surface(start, shots, plan)?;
    let (mut trace, mut levels) = (Vec::new(), Vec::new());
    // That of the surface before the next step.
    let mut distance = truth.map(|truth| between(&surface.mesh, truth).mean);
    loop {
        let level = levels.len();
        let (shrunk, of_level) = &images;
        let settings = Settings {
            steps: plan.steps,
            every: EVERY,
            beta: if level == 0 { plan::FIRST_BETA * plan.beta } else { plan.beta },
            // Clusters of pixels do not depend on the surface; albedos do.
            fits_colors: level > 0 || plan.light.is_some(),
            smoothing: plan.smoothing,
            max_move: match level {
                0 => FIRST_MOVE * (surface.mesh.area() / std::f64::consts::PI).sqrt(),
                _ => LATER_MOVE * pixel * *shrunk as f64,
            },
            weights,
            sampling: plan.sampling,
            interior: plan.interior,
        };
        let first = trace.len();
        let mut failure = None;
        let mut observe = |step: &Step, surface: &Surface| {
            let mut tell = |event: Event<'_>| {
                watch(event).unwrap_or_else(|error| {
                    failure = Some(error);
                    ControlFlow::Break(())
                })
            };
            let flow = tell(Event::Step(step, surface));
            let truth = truth.filter(|_| flow.is_continue() && step.is_compared());
            trace.push((step.clone(), distance.take()));
            distance = truth.map(|truth| between(&surface.mesh, truth).mean);
            match distance {
                Some(distance) => tell(Event::Distance(distance)),
                None => flow,
            }
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
        let mut failure = None;
        let mut go_on = |_: Option<&_>| {
            watch(Event::Labels).unwrap_or_else(|error| {
                failure = Some(error);
                ControlFlow::Break(())
            })
        };
        let found = at_rest.reconstruction(&surface, trace_so_far, levels_so_far, &mut go_on)?;
        if let Some(error) = failure {
            return Err(error);
        }
        if end == End::Interrupted || levels.len() == plan.levels {
            return Ok(found);
        }
        if watch(Event::Level(&found))?.is_break() {
            return Ok(found);
        }
        refine(&mut surface, plan.split);
        images = images_for(shots, &surface.mesh, pixel, plan);
    }
}

/// The images at the resolution that suits a mesh, and the number k of pixels in a row that became one.
fn images_for(shots: &[Shot], mesh: &Mesh, pixel: f64, plan: &Plan) -> (usize, Vec<Image>) {
    let edges = Edges::of(mesh);
    let length =
        |[a, b]: &[u32; 2]| (mesh.vertices[*a as usize] - mesh.vertices[*b as usize]).norm();
    let mean = edges.ends.iter().map(length).sum::<f64>() / edges.ends.len() as f64;
    let mut shrunk = 1;
    while mean >= 2.0 * EDGE_PIXELS * pixel * shrunk as f64 {
        shrunk *= 2;
    }
    let image = |shot: &Shot| {
        let image = shot.image(shrunk);
        if plan.background { image } else { image.without_background() }
    };
    (shrunk, sweep::results(shots.iter().collect(), image))
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
    if of_masks && plan.light.is_some() {
        return Err(Error::unsuitable(
            "masks have no light: leave out --model albedo, or give the color of the background instead of the masks",
        ));
    }
    let mu = match of_masks {
        true => vec![[1.0; 3]],
        false => clusters::colors(shots, plan.regions, plan.seed, &mesh, plan.light)?,
    };
    let u = if plan.regions == 1 { vec![1.0; mesh.vertices.len()] } else { Vec::new() };
    let coloring = Coloring { u, mu };
    Ok(Surface { mesh, coloring, q: Vec::new(), light: plan.light, fits_colors: !of_masks })
}

#[cfg(test)]
mod tests;
