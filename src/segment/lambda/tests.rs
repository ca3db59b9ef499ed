//! The search for lambda: what counts as a region, when it ends, and what does not disturb it.

use super::*;
use crate::data::{Data, L1, PiecewiseConstant};
use crate::operator::Mass;
use crate::run::Sample;
use crate::samples::{rng, shape};
use crate::segment::segment;
use rand::RngExt;
use std::ops::ControlFlow;

/// The piecewise constant model of these data, without parameters.
fn estimate(data: &Data) -> ModelEstimate<'_, PiecewiseConstant<'_>> {
    ModelEstimate::new(Cow::Owned(PiecewiseConstant::new(data)), Vec::new())
}

fn explained(labels: &[Row<4>], data: &Data, area: &[f64]) -> Explained {
    let mut estimate = estimate(data);
    let mut rng = Pcg64::seed_from_u64(0);
    estimate.start(Initial::Random, 4, area, &mut rng).unwrap();
    let scale = estimate.scale(area);
    Explained::of(labels, &mut estimate, area, scale).unwrap()
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
    Alternation {
        regions: 3,
        initial: Initial::KMeans,
        seed: 0,
        every: 10,
        labels: None,
        seeds: Seeds::default(),
    }
}

fn request() -> Request {
    Request {
        lambda: 0.0,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: crate::solver::Method::default(),
        stop: Stop { relative_gap: Some(1e-4), iterations: Some(5000), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    }
}

/// Three bands of the unit sphere at 0, 0.5 and 1, with noise.
fn bands(noise: f64) -> (Mesh, Data) {
    let mesh = shape("sphere:3");
    let mut rng = rng(142);
    let value = |z: f64| 0.5 * f64::from(u8::from(z > -0.3)) + 0.5 * f64::from(u8::from(z > 0.3));
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
    let model = estimate(data);
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
    let model = estimate(&data);
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
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go);
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
    let labels = segment(&mesh, &model, &alternation(), &request, &mut go).unwrap().solution.labels;
    let labels: Vec<Row<4>> = labels.iter().map(|&p| Row::one_hot(p as usize)).collect();
    let cells = barycentric_areas(&mesh);
    let mut rng = Pcg64::seed_from_u64(0);
    let mut estimate = estimate(&data);
    estimate.start(Initial::KMeans, 3, &cells, &mut rng).unwrap();
    let clusters = explained(&labels_without_cuts(&estimate), &data, &cells);
    let kept = explained(&labels, &data, &cells);
    assert_eq!((clusters.regions, kept.regions, found.regions), (3, 3, 3));
    assert!(kept.costs < 0.95 * clusters.costs && kept.costs >= EXPLAINED_SHARE * clusters.costs);
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
    let rounding = crate::rounding::Rounding::Argmax;
    let request = Request { lambda, stop, rounding, ..request() };
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
    let model = estimate(&data);
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
