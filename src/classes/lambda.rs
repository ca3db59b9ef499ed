//! A default lambda for costs of classes, the same for labels of vertices and of faces.
//!
//! ```text
//! lambda_i = 0.01 R_1 / sqrt(area) / 2^i,     R_1 = min_p sum_k f_kp - B
//! ```
//!
//! R_1 is what the best single class costs above the cheapest labels. If two classes of equal area differ by c, lambda_0 =
//! 0.005 c sqrt(area): a cut weighs as much as a wrong class within a two-hundredth of the size of the surface. lambda is halved until,
//! on a coarse mesh, no class that is cheapest on more than a thousandth of the area is lost, and the labels save two thirds of R_1. Costs of
//! coarse vertices are means, which have little noise, so noise makes lambda no smaller.

use ndarray::Array2;

use crate::coarse::{Hierarchy, first_accepted};
use crate::error::Result;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Mass, Stencil};
use crate::problem::Problem;
use crate::regions::{self, with_regions};
use crate::request::{Observer, Request};
use crate::solve::{check_range, integrate, model_mesh};
use crate::start::cheapest_labels;
use crate::transfer::restrict;

/// Maximum number of vertices of the mesh on which lambdas are tried.
const MAX_TRIAL_VERTICES: usize = 4000;

/// Maximum number of lambdas that are tried, each half of the previous one.
const MAX_TRIALS: i32 = 14;

/// The share of R_1 that labels must save.
const SAVED_SHARE: f64 = 2.0 / 3.0;

/// A class that is cheapest on a smaller share of the area may be lost.
const SPECK_AREA_SHARE: f64 = 1e-3;

/// lambda for pointwise costs at the vertices of a mesh, V x m; NaN where unknown. It is 0 where one class is the cheapest
/// everywhere.
///
/// # Errors
/// No face has an area, or the integrated costs leave the range of double precision.
pub fn of_costs(
    mesh: &Mesh,
    s: &Array2<f64>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let (model, _) = model_mesh(mesh)?;
    let known = s.mapv(|s| if s.is_nan() { 0.0 } else { s });
    with_regions!(s.ncols(), of_costs_compiled(&model, &known, request, observe))
}

fn of_costs_compiled<const M: usize>(
    model: &Mesh,
    s: &Array2<f64>,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let m = s.ncols();
    let mut f = integrate(&Mass::Barycentric.on(model), m, &regions::rows::<M>(s.view()));
    let hierarchy = Hierarchy::down_to(model, MAX_TRIAL_VERTICES);
    for level in &hierarchy.levels {
        f = restrict(level, &f);
    }
    let mesh = hierarchy.levels.last().map_or(model, |level| &level.mesh);
    let mut problem = Problem::new(Stencil::new(mesh), f, 0.0).in_relaxation(request.relaxation);
    check_range(&problem)?;
    let cheapest = cheapest_labels(&problem.f);
    let single = |p: usize| problem.data_term(&vec![Row::one_hot(p); problem.f.len()]);
    let best_single = (0..m).map(single).fold(f64::INFINITY, f64::min);
    let initial = 0.01 * best_single / mesh.area().sqrt();
    let areas = Mass::Barycentric.weights(mesh);
    let shares = |u: &[Row<M>]| {
        let mut shares = vec![0.0; m];
        u.iter().zip(&areas).for_each(|(u, area)| shares[u.argmax()] += area / mesh.area());
        shares
    };
    let wanted: Vec<usize> = {
        let shares = shares(&cheapest);
        (0..m).filter(|&p| shares[p] > SPECK_AREA_SHARE).collect()
    };
    if best_single <= 0.0 {
        return Ok(0.0);
    }
    let f = problem.f.clone();
    let accepts = |u: &[Row<M>]| {
        let shares = shares(u);
        let cost: f64 = u.iter().zip(&f).map(|(u, f)| f.0[u.argmax()]).sum();
        wanted.iter().all(|&p| shares[p] > 0.0) && cost <= (1.0 - SAVED_SHARE) * best_single
    };
    let lambdas = (0..MAX_TRIALS).map(|i| initial * 0.5_f64.powi(i));
    let found = first_accepted(mesh, &mut problem, lambdas, request, observe, &accepts)?;
    Ok(found.unwrap_or(initial))
}
