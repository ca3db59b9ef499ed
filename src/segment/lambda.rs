//! A default lambda for data of any kind, and a smaller lambda that keeps the regions which a given one empties.
//!
//! ```text
//! lambda_i = 0.02 (scale of the costs) sqrt(area) / 2^i              for constant data the variance without outliers
//! R(U)     = min_mu int s_mu - min_mu sum_p int u_p s_{mu_p}         costs that labels explain, relative to one region
//! ```
//!
//! lambda_0 weighs a cut as much as an error of one standard deviation within a fiftieth of the size of the surface.
//! This suits colors and textures, but empties all regions but one where the data vary over shorter distances, as
//! curvature does. So lambda is halved until, on a coarse mesh with the model restricted to it, no region that the
//! clusters of the data use is empty and the labels explain at least two thirds of what the clusters explain, which
//! ignore cuts. Data of coarse vertices have little noise, so noise does not make lambda smaller.

use std::borrow::Cow;
use std::time::Instant;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::alternation::{Alternation, JointProblem};
use super::coarse::restrict;
use super::compiled::Compiled;
use crate::coarse::Hierarchy;
use crate::data::{DataModel, Initial, Scale};
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::operator::Stencil;
use crate::problem::rounded;
use crate::regions::with_regions;
use crate::run::Stop;
use crate::solve::{Observer, Request, model_mesh};

/// Maximum number of vertices of the mesh on which lambdas are tried.
const MAX_TRIAL_VERTICES: usize = 4000;

/// Relative gap of a trial: its labels need not be exact.
const TRIAL_GAP: f64 = 1e-2;
/// Maximum number of steps of a trial.
const MAX_TRIAL_STEPS: u64 = 200;

/// Maximum number of lambdas that are tried, each half of the previous one.
const MAX_TRIALS: i32 = 14;

/// The fraction of what the clusters explain that labels must explain.
const EXPLAINED_SHARE: f64 = 2.0 / 3.0;

/// The default lambda for data of any kind: the first of lambda_0, lambda_1, ... that loses no region, or lambda_0 if
/// all of them do.
///
/// # Errors
/// Data whose costs leave the range of double precision, and a fit that fails.
pub fn of_data<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let cells = barycentric_areas(mesh);
    let initial = initial_lambda(model.scale(&cells).cost, cells.iter().sum());
    if !initial.is_finite() {
        return Err(Error::unsuitable(
            "the costs of the data leave the range of double precision; scale the data down",
        ));
    }
    let (usable, _) = model_mesh(mesh)?;
    let request = Request { lambda: initial, ..request.clone() };
    let found = find_separating(&usable, model, alternation, &request, observe)?;
    Ok(found.lambda.unwrap_or(initial))
}

/// lambda_0 for costs of the given scale on a surface of the given area.
fn initial_lambda(cost: f64, area: f64) -> f64 {
    0.02 * cost * area.sqrt()
}

/// The result of a search for lambda.
pub(super) struct Separation {
    /// How many distinct regions, larger than a speck, the clusters of the data have.
    pub regions: usize,
    /// The first lambda that keeps all of these and explains enough; `None` if all fail.
    pub lambda: Option<f64>,
}

/// Searches lambda, lambda / 2, ..., starting with that of the request, for the first that leaves no region empty and
/// explains enough. The mesh has no faces without area.
///
/// # Errors
/// Costs that leave the range of double precision, and a fit that fails.
pub(super) fn find_separating<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation> {
    with_regions!(
        alternation.regions,
        find_separating_compiled::<D>(mesh, model, alternation, request, observe)
    )
}

fn find_separating_compiled<const M: usize, D: DataModel>(
    finest: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation>
where
    Stencil: Compiled<M>,
{
    let begin = Instant::now();
    let hierarchy = Hierarchy::down_to(finest, MAX_TRIAL_VERTICES);
    let (mut weights, mut model) = (request.mass.weights(finest), Cow::Borrowed(model));
    for level in &hierarchy.levels {
        let (coarse, restricted) = restrict(level, &weights, &*model);
        (weights, model) = (coarse, Cow::Owned(restricted));
    }
    let model = &*model;
    let mesh = hierarchy.levels.last().map_or(finest, |level| &level.mesh);
    let known = |(k, &w): (usize, &f64)| if model.is_known(k) { w } else { 0.0 };
    let known: Vec<f64> = weights.iter().enumerate().map(known).collect();
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let mu = model.start(Initial::KMeans, alternation.regions, &known, &mut rng)?;

    let integrate = |s: &[Row<M>]| s.iter().zip(&known).map(|(&s, &w)| s * w).collect();
    let scale = model.scale(&known);
    let stop = Stop {
        relative_gap: Some(TRIAL_GAP),
        iterations: Some(MAX_TRIAL_STEPS),
        ..request.stop.after(begin.elapsed())
    };
    let explained = |labels: &[Row<M>]| Explained::of(labels, model, &mu, &known, scale);
    let clusters = explained(&labels_without_cuts(model, &mu))?;
    let not_found = Separation { regions: clusters.regions, lambda: None };
    if clusters.costs <= 0.0 {
        return Ok(not_found);
    }
    for i in 0..MAX_TRIALS {
        let request = &Request { lambda: request.lambda * 0.5_f64.powi(i), ..request.clone() };
        let joint = JointProblem {
            mesh,
            model,
            integrate: &integrate,
            scale,
            alternation,
            request,
            merge: false,
        };
        let problem = joint.problem(&mu)?;
        let mut flow = std::ops::ControlFlow::Continue(());
        let mut observe = |_: Option<&_>| {
            flow = observe(None);
            flow
        };
        let spent = begin.elapsed();
        let found = joint.alternate(problem, mu.clone(), None, spent, &stop, &mut observe)?;
        if flow.is_break() {
            return Ok(not_found);
        }
        let reached = explained(&rounded(found.run.best_u()))?;
        if reached.regions >= clusters.regions && reached.costs >= EXPLAINED_SHARE * clusters.costs
        {
            return Ok(Separation { lambda: Some(request.lambda), ..not_found });
        }
    }
    Ok(not_found)
}

/// The labels of minimum cost at each vertex, ignoring cuts.
fn labels_without_cuts<D: DataModel, const M: usize>(
    model: &D,
    mu: &[D::Parameters],
) -> Vec<Row<M>> {
    let s: Vec<Row<M>> = model.costs(mu);
    let cheapest = |s: &Row<M>| (0..mu.len()).min_by(|&a, &b| s.0[a].total_cmp(&s.0[b]));
    s.iter().map(|s| Row::one_hot(cheapest(s).expect("there are regions"))).collect()
}

/// How well labels explain the data.
struct Explained {
    /// R(U).
    costs: f64,
    /// Number of regions that are larger than a speck and have distinct parameters.
    regions: usize,
}

/// A region of less than this fraction of the area is a speck.
const SPECK_AREA_SHARE: f64 = 1e-3;

/// Regions are distinct if their distance exceeds this fraction of the scale of distances, for constant data the
/// standard deviation. With 0.1, two regions of a photograph and two of six on Spot counted as distinct although the
/// fine mesh merged them; 0.2 and 0.3 distinguish the same regions on all data tried.
const DISTINCT_DISTANCE: f64 = 0.25;

impl Explained {
    /// For one-hot labels and the weights of the known vertices; fits start from `mu`.
    fn of<D: DataModel, const M: usize>(
        labels: &[Row<M>],
        model: &D,
        mu: &[D::Parameters],
        known: &[f64],
        scale: Scale,
    ) -> Result<Self> {
        let fitted = |labels: &dyn Fn(usize) -> Row<M>, mu: &[D::Parameters]| -> Result<_> {
            let weights: Vec<Row<M>> =
                known.iter().enumerate().map(|(k, &w)| labels(k) * w).collect();
            let mut mu = mu.to_vec();
            model.fit(&weights, &mut mu)?;
            let costs: f64 =
                model.costs::<M>(&mu).iter().zip(&weights).map(|(&s, w)| w.dot(s)).sum();
            Ok((mu, costs))
        };
        let (_, one) = fitted(&|_| Row::one_hot(0), &mu[..1])?;
        let (mu, within) = fitted(&|k| labels[k], mu)?;
        let mut mass = vec![0.0; mu.len()];
        labels.iter().zip(known).for_each(|(u, &w)| mass[u.argmax()] += w);
        let total: f64 = mass.iter().sum();
        let mut different: Vec<&D::Parameters> = Vec::new();
        for (mu, mass) in mu.iter().zip(mass) {
            let new = different
                .iter()
                .all(|other| D::distance(mu, other) > DISTINCT_DISTANCE * scale.distance);
            if new && mass > SPECK_AREA_SHARE * total {
                different.push(mu);
            }
        }
        Ok(Explained { costs: one - within, regions: different.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Data, L1, PiecewiseConstant};
    use crate::operator::Mass;
    use crate::run::Sample;
    use crate::samples::{rng, shape};
    use crate::segment::segment;
    use rand::RngExt;
    use std::ops::ControlFlow;

    fn explained(labels: &[Row<4>], data: &Data, area: &[f64]) -> Explained {
        let model = PiecewiseConstant::new(data);
        let mut rng = Pcg64::seed_from_u64(0);
        let mu = model.start(Initial::Random, 4, area, &mut rng).unwrap();
        Explained::of(labels, &model, &mu, area, model.scale(area)).unwrap()
    }

    /// Total variance minus the variance within the regions is the variance between their means.
    #[test]
    fn explained_costs_are_the_variance_between_regions() {
        let mut rng = rng(141);
        let n = 500;
        let data = Data::new(2, (0..2 * n).map(|_| rng.random()).collect()).unwrap();
        let area: Vec<f64> = (0..n).map(|_| rng.random()).collect();
        let labels: Vec<Row<4>> = (0..n).map(|_| Row::one_hot(rng.random_range(0..4))).collect();
        let (mut mass, mut moments) = ([0.0; 4], [[0.0; 2]; 4]);
        for (k, u) in labels.iter().enumerate() {
            let p = u.argmax();
            mass[p] += area[k];
            (0..2).for_each(|i| moments[p][i] += area[k] * data.at(k)[i]);
        }
        let total: f64 = mass.iter().sum();
        let mean = [0, 1].map(|i| moments.iter().map(|moment| moment[i]).sum::<f64>() / total);
        let between: f64 = (0..4)
            .flat_map(|p| [0, 1].map(|i| mass[p] * (moments[p][i] / mass[p] - mean[i]).powi(2)))
            .sum();
        let found = explained(&labels, &data, &area);
        assert!((found.costs - between).abs() < 1e-12 * total, "{} {between}", found.costs);
    }

    /// lambda has the unit of a cost times a length.
    #[test]
    fn the_initial_lambda_has_the_right_units() {
        let lambda = initial_lambda(0.5, 4.0);
        assert!((initial_lambda(0.5 * 9.0, 4.0) - 9.0 * lambda).abs() <= 1e-15);
        assert!((initial_lambda(0.5, 4.0 * 9.0) - 3.0 * lambda).abs() <= 1e-15);
    }

    fn alternation() -> Alternation {
        Alternation { regions: 3, initial: Initial::KMeans, seed: 0, every: 10 }
    }

    fn request() -> Request {
        Request {
            lambda: 0.0,
            mass: Mass::Barycentric,
            method: crate::solver::Method::default(),
            stop: Stop { relative_gap: Some(1e-4), iterations: Some(5000), ..Stop::default() },
            coarse_to_fine: false,
            keep_dual: false,
        }
    }

    /// Three bands of the unit sphere at 0, 0.5 and 1, with noise.
    fn bands(noise: f64) -> (Mesh, Data) {
        let mesh = shape("sphere:3");
        let mut rng = rng(142);
        let value =
            |z: f64| 0.5 * f64::from(u8::from(z > -0.3)) + 0.5 * f64::from(u8::from(z > 0.3));
        let noisy = mesh.vertices.iter().map(|x| value(x.z) + noise * rng.random_range(-1.0..1.0));
        let values = noisy.collect();
        (mesh, Data::new(1, values).unwrap())
    }

    /// The result of a search, and how often the observer was called.
    fn searched(mesh: &Mesh, data: &Data, request: &Request, from: f64) -> (Separation, u64) {
        let mut calls = 0;
        let mut observe = |sample: Option<&Sample>| {
            assert!(sample.is_none());
            calls += 1;
            ControlFlow::Continue(())
        };
        let request = Request { lambda: from, ..request.clone() };
        let model = PiecewiseConstant::new(data);
        let found = find_separating(mesh, &model, &alternation(), &request, &mut observe).unwrap();
        (found, calls)
    }

    /// For three bands, one of them narrow: the largest of the halved lambdas that loses no region, or the first one if
    /// it loses none.
    #[test]
    fn the_first_lambda_that_keeps_all_regions_is_taken() {
        let mesh = crate::samples::shape("sphere:3");
        let band = |z: f64| if z > 0.9 { 1.0 } else { 0.5 * f64::from(z > 0.0) };
        let data = Data::new(1, mesh.vertices.iter().map(|x| band(x.z)).collect()).unwrap();
        let model = PiecewiseConstant::new(&data);
        let (alternation, request) = (alternation(), request());
        let mut go = |_: Option<&crate::run::Sample>| std::ops::ControlFlow::Continue(());
        let mut found = |from: f64| {
            let request = Request { lambda: from, ..request.clone() };
            find_separating(&mesh, &model, &alternation, &request, &mut go).unwrap().lambda.unwrap()
        };
        assert_eq!(found(1e-3), 1e-3);
        let lambda = found(2.0);
        assert!(lambda < 2.0 && (2.0 / lambda).log2().fract() == 0.0, "{lambda}");
        let mut empty = |lambda: f64| {
            let request = Request { lambda, ..request.clone() };
            let found = segment(&mesh, &model, &alternation, &request, &mut go);
            found.unwrap().solution.summary.empty_regions.len()
        };
        assert_eq!(empty(lambda), 0);
    }

    #[test]
    fn specks_and_close_regions_do_not_count_as_regions() {
        let values = [vec![0.0; 1000], vec![1.0; 1000], vec![1.01; 1000], vec![5.0; 1]].concat();
        let regions = [vec![0; 1000], vec![1; 1000], vec![2; 1000], vec![3; 1]].concat();
        let labels: Vec<Row<4>> = regions.into_iter().map(Row::one_hot).collect();
        let data = Data::new(1, values).unwrap();
        assert_eq!(explained(&labels, &data, &[1.0; 3001]).regions, 2);
    }

    /// A few outliers, such as those that mark missing values, do not make other regions close.
    #[test]
    fn outliers_leave_regions_distinct() {
        let values = [vec![0.0; 1000], vec![1.0; 1000], vec![1e3; 2]].concat();
        let regions = [vec![0; 1000], vec![1; 1000], vec![2; 2]].concat();
        let labels: Vec<Row<4>> = regions.into_iter().map(Row::one_hot).collect();
        let data = Data::new(1, values).unwrap();
        let found = explained(&labels, &data, &[1.0; 2002]);
        // Specks do not count, wherever they lie.
        assert_eq!(found.regions, 2);
        let all = 2002.0 * data.variance(&[1.0; 2002]);
        assert!((found.costs / all - 1.0).abs() <= 1e-9);
    }

    /// DISTINCT_DISTANCE is a fraction of the standard deviation, not of the variance.
    #[test]
    fn means_are_distinct_beyond_a_quarter_of_the_deviation() {
        // Two halves at 0 and 1, each of two regions: the deviation is 1/2, and a quarter of it 1/8.
        for (distance, regions) in [(0.11, 2), (0.15, 4)] {
            let values = [0.0, distance, 1.0, 1.0 + distance].map(|x| vec![x; 100]).concat();
            let labels: Vec<Row<4>> = (0..400).map(|k| Row::one_hot(k / 100)).collect();
            let data = Data::new(1, values).unwrap();
            assert_eq!(explained(&labels, &data, &[1.0; 400]).regions, regions);
        }
    }

    /// Labels explain less of noisy data than k-means, which follows the noise: two thirds are enough.
    #[test]
    fn two_thirds_of_the_explainable_costs_are_enough() {
        let (mesh, data) = bands(0.4);
        let (found, _) = searched(&mesh, &data, &request(), 0.05);
        let lambda = found.lambda.unwrap();
        let request = Request { lambda, ..request() };
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let model = PiecewiseConstant::new(&data);
        let labels =
            segment(&mesh, &model, &alternation(), &request, &mut go).unwrap().solution.labels;
        let labels: Vec<Row<4>> = labels.iter().map(|&p| Row::one_hot(p as usize)).collect();
        let cells = barycentric_areas(&mesh);
        let mut rng = Pcg64::seed_from_u64(0);
        let mu = model.start(Initial::KMeans, 3, &cells, &mut rng).unwrap();
        let clusters = explained(&labels_without_cuts(&model, &mu), &data, &cells);
        let kept = explained(&labels, &data, &cells);
        assert_eq!((clusters.regions, kept.regions, found.regions), (3, 3, 3));
        assert!(
            kept.costs < 0.95 * clusters.costs && kept.costs >= EXPLAINED_SHARE * clusters.costs
        );
    }

    /// On a mesh that needs no coarsening, a trial takes the steps of `segment`, but to its own gap.
    #[test]
    fn a_trial_takes_the_steps_of_a_segmentation() {
        let (mesh, data) = bands(0.4);
        let lambda = searched(&mesh, &data, &request(), 0.05).0.lambda.unwrap();
        let (found, calls) = searched(&mesh, &data, &request(), lambda);
        assert_eq!(found.lambda, Some(lambda));
        let stop = Stop {
            relative_gap: Some(TRIAL_GAP),
            iterations: Some(MAX_TRIAL_STEPS),
            ..Stop::default()
        };
        let request = Request { lambda, stop, ..request() };
        let mut steps = 0;
        let mut count = |_: Option<&Sample>| {
            steps += 1;
            ControlFlow::Continue(())
        };
        let model = PiecewiseConstant::new(&data);
        let found = segment(&mesh, &model, &alternation(), &request, &mut count).unwrap();
        assert!(found.solution.summary.empty_regions.is_empty() && found.estimates > 1);
        assert_eq!(calls, steps);
    }

    /// Constant data have one region and no variance that labels could explain: no lambda is tried.
    #[test]
    fn no_lambda_is_tried_for_constant_data() {
        let mesh = shape("sphere:3");
        let data = Data::new(1, vec![0.25; mesh.vertices.len()]).unwrap();
        let (found, calls) = searched(&mesh, &data, &request(), 1.0);
        assert_eq!((found.regions, found.lambda, calls), (1, None, 0));
    }

    /// An interrupted search returns the initial lambda, which is robust to outliers.
    #[test]
    fn an_interrupted_search_returns_the_initial_lambda() {
        let (mesh, mut data) = bands(0.0);
        data.values[5] = 1e4;
        let mut calls = 0;
        let mut observe = |_: Option<&Sample>| {
            calls += 1;
            ControlFlow::Break(())
        };
        let model = PiecewiseConstant::new(&data);
        let lambda = of_data(&mesh, &model, &alternation(), &request(), &mut observe).unwrap();
        assert!(calls <= 2, "{calls}");
        let cells = barycentric_areas(&mesh);
        let (robust, all) = (data.robust_variance(&cells), data.variance(&cells));
        assert_eq!(lambda, initial_lambda(robust, cells.iter().sum()));
        assert!(all > 100.0 * robust);
        // The labels of an interrupted trial do not count.
        let request = Request { lambda, ..request() };
        let mut observe = |_: Option<&Sample>| ControlFlow::Break(());
        let found = find_separating(&mesh, &model, &alternation(), &request, &mut observe).unwrap();
        assert_eq!(found.lambda, None);
    }

    /// After the time limit each trial takes a single step.
    #[test]
    fn trials_end_at_the_time_limit() {
        let (mesh, data) = bands(0.4);
        let stop = Stop { time: Some(std::time::Duration::ZERO), ..request().stop };
        let (_, calls) = searched(&mesh, &data, &Request { stop, ..request() }, 0.05);
        assert!(calls <= MAX_TRIALS as u64, "{calls}");
    }

    /// Unknown vertices and faces without area do not change the result.
    #[test]
    fn unknown_vertices_and_flat_faces_change_nothing() {
        let (mesh, data) = bands(0.1);
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let mut found = |mesh: &Mesh, data: &Data| {
            let model = PiecewiseConstant::new(data);
            of_data(mesh, &model, &alternation(), &request(), &mut go).unwrap()
        };
        let lambda = found(&mesh, &data);
        let mut flat = mesh.clone();
        flat.faces.extend([[0, 0, 1], [2, 3, 3]]);
        assert_eq!(found(&flat, &data), lambda);
        let mut unknown = data.clone();
        unknown.values.iter_mut().step_by(9).for_each(|x| *x = f64::NAN);
        let (found, _) = searched(&mesh, &unknown, &request(), lambda);
        assert_eq!((found.regions, found.lambda), (3, Some(lambda)));
    }

    #[test]
    fn data_too_large_to_be_squared_are_refused() {
        let (mesh, mut data) = bands(0.1);
        data.values.iter_mut().for_each(|x| *x *= 1e200);
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let model = PiecewiseConstant::new(&data);
        let error = of_data(&mesh, &model, &alternation(), &request(), &mut go).unwrap_err();
        assert!(error.to_string().contains("the costs of the data"), "{error}");
        // The costs of `l1` are not squared.
        assert!(of_data(&mesh, &L1::new(&data), &alternation(), &request(), &mut go).is_ok());
    }
}
