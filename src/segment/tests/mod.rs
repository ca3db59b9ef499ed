//! The alternation recovers the painted regions, is reproducible, and ends with a valid certificate.

mod ends;
mod gaussian;
mod histogram;
mod levels;
mod models;
mod seeds;

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use rand::RngExt;
use strum::IntoEnumIterator;

use super::alternation::{SETTLED_CHANGE, UNSETTLED_CHANGE};
use super::*;
use crate::data::constant::Mean;
use crate::data::gaussian::{Gaussian, Moments};
use crate::data::l1::Median;
use crate::data::{Cost, Data, Initial, L1, PiecewiseConstant, Scale, Weights};
use crate::mesh::coarsen::Coarsening;
use crate::operator::Mass;
use crate::run::{Sample, Stop};
use crate::samples::{assert_within, rng, shape};
use crate::seeds::Seeds;
use crate::solve::problem_of;
use crate::solver::{Method, chambolle_pock};

const PALETTE: [[f64; 3]; 3] = [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.2, 0.1, 0.7]];

fn go(_: Option<&Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The unit sphere in three bands of equal area, with noise of the given amplitude.
fn painted(mesh: &Mesh, noise: f64) -> (Data, Vec<usize>) {
    let mut rng = rng(111);
    let band = |z: f64| {
        if z < -1.0 / 3.0 {
            0
        } else if z < 1.0 / 3.0 {
            1
        } else {
            2
        }
    };
    let truth: Vec<usize> = mesh.vertices.iter().map(|x| band(x.z)).collect();
    let values = truth
        .iter()
        .flat_map(|&p| PALETTE[p])
        .map(|c| c + noise * rng.random_range(-1.0..1.0))
        .collect();
    (Data::new(3, values).unwrap(), truth)
}

fn request(lambda: f64, mass: Mass) -> Request {
    Request {
        lambda,
        relaxation: Default::default(),
        mass,
        method: Method::default(),
        stop: Stop { relative_gap: Some(1e-4), iterations: Some(20_000), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    }
}

fn alternation(initial: Initial, seed: u64) -> Alternation {
    Alternation { regions: 3, initial, seed, every: 10, labels: None, seeds: Seeds::default() }
}

/// The region of each color of the palette, by the nearest mean; all three must be different.
fn matched<D: DataModel>(parameters: &[D::Parameters], tolerance: f64) -> [usize; 3] {
    let found = PALETTE.map(|color| {
        let distance = |mean: &[f64]| -> f64 {
            mean.iter().zip(color).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let of = |p: usize| distance(D::value(&parameters[p]));
        let best = (0..3).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap();
        assert!(of(best) <= tolerance, "{color:?} is missing in {parameters:?}");
        best
    });
    assert!(found[0] != found[1] && found[1] != found[2] && found[0] != found[2]);
    found
}

#[test]
fn three_colors_are_recovered() {
    let mesh = shape("sphere:4");
    let (data, truth) = painted(&mesh, 0.25);
    for mass in Mass::iter() {
        for initial in [Initial::KMeans, Initial::Random] {
            let request = request(0.03, mass);
            let found = segment(
                &mesh,
                &PiecewiseConstant::new(&data),
                &alternation(initial, 5),
                &request,
                &mut go,
            )
            .unwrap();
            let region = matched::<PiecewiseConstant>(&found.parameters, 0.03);
            let labels = &found.solution.labels;
            let right =
                truth.iter().zip(labels).filter(|&(&t, &l)| region[t] == l as usize).count();
            assert!(right as f64 > 0.97 * truth.len() as f64, "{mass:?}, {initial:?}: {right}");
            let summary = &found.solution.summary;
            assert_eq!(summary.status, Status::Converged, "{mass:?}, {initial:?}");
            assert!(summary.dual_bound <= summary.energy && summary.relative_gap <= 1e-4);
            assert!(found.estimates > 0);
        }
    }
}

/// Data of any size have the same labels, and means of their size: powers of two change nothing else. Lambda has the
/// size of the costs, which is the square of that of the data.
#[test]
fn data_of_any_size_have_the_same_regions() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.25);
    let segmented = |exponent: i32| {
        let (factor, of_costs) = (f64::from(exponent).exp2(), f64::from(2 * exponent).exp2());
        let values = data.values.iter().map(|x| factor * x).collect();
        let data = Data::new(3, values).unwrap();
        let request = request(of_costs * 0.03, Mass::Barycentric);
        let alternation = alternation(Initial::KMeans, 5);
        let mut last = 0.0;
        let mut observe = |sample: Option<&Sample>| {
            last = sample.map_or(last, |sample| sample.energy);
            ControlFlow::Continue(())
        };
        let model = PiecewiseConstant::new(&data);
        let found = segment(&mesh, &model, &alternation, &request, &mut observe).unwrap();
        (found, last, factor, of_costs)
    };
    let (expected, last_expected, ..) = segmented(0);
    for exponent in [-480, -250, -130, 130, 250, 460] {
        let (found, last, factor, of_costs) = segmented(exponent);
        assert_eq!(found.solution.labels, expected.solution.labels, "2^{exponent}");
        assert_eq!(found.estimates, expected.estimates, "2^{exponent}");
        let (a, b) = (&found.solution.summary, &expected.solution.summary);
        assert_eq!((a.status, a.relative_gap), (b.status, b.relative_gap), "2^{exponent}");
        assert_eq!(a.energy, of_costs * b.energy, "2^{exponent}");
        assert_eq!(last, of_costs * last_expected, "2^{exponent}");
        for (a, b) in found.parameters.iter().zip(&expected.parameters) {
            let (a, b) = (PiecewiseConstant::value(a), PiecewiseConstant::value(b));
            assert!(a.iter().zip(b).all(|(a, b)| *a == factor * b), "2^{exponent}");
        }
    }
}

/// A step ratio that is not chosen is that of re-estimated costs, and one that is chosen is kept.
#[test]
fn the_step_ratio_is_that_of_estimates() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.9);
    let found = |step_ratio| {
        let method = chambolle_pock::Settings { step_ratio, ..Default::default() }.into();
        let request = Request { method, ..request(0.05, Mass::Barycentric) };
        let alternation = alternation(Initial::Random, 5);
        let model = PiecewiseConstant::new(&data);
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        found.solution.trace.iter().map(|sample| sample.energy).collect::<Vec<_>>()
    };
    let default = found(None);
    assert_eq!(default, found(Some(0.5)));
    assert_ne!(default, found(Some(1.5)));
}

/// The final energy and bound are those of the reported parameters.
#[test]
fn the_certificate_is_for_the_reported_parameters() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.2);
    for mass in Mass::iter() {
        let request = request(0.05, mass);
        let found = segment(
            &mesh,
            &PiecewiseConstant::new(&data),
            &alternation(Initial::KMeans, 1),
            &request,
            &mut go,
        )
        .unwrap();
        let costs = || PiecewiseConstant::new(&data).costs::<3>(&found.parameters);
        let problem = problem_of::<3>(&mesh, 3, costs(), &request).unwrap();
        let u = regions::rows::<3>(found.solution.u.view());
        let summary = &found.solution.summary;
        let energy = problem.baseline + problem.energy(&u);
        assert_within(energy, summary.energy, 1e-12, summary.energy);
        let s = regions::array(&costs(), 3);
        let start = crate::start::Start::Uniform;
        let exact = crate::solve::solve(&mesh, &s, &start, &request, &mut go).unwrap().summary;
        assert!(summary.dual_bound <= exact.energy && exact.dual_bound <= summary.energy);
    }
}

/// Neither half of the alternation increases the energy, except that a solve for U leaves a gap.
fn the_energy_of_a_model_does_not_rise<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    first: &[D::Parameters],
) {
    for mass in Mass::iter() {
        let request = request(0.05, mass);
        let mut mu = first.to_vec();
        let mut before = f64::INFINITY;
        for _ in 0..6 {
            let s = regions::array(&model.costs::<3>(&mu), 3);
            let start = crate::start::Start::Uniform;
            let solution = crate::solve::solve(mesh, &s, &start, &request, &mut go).unwrap();
            let (energy, baseline) = (solution.summary.energy, solution.summary.baseline);
            let gap = 1e-4 * (energy - baseline);
            assert!(energy <= before + gap, "{mass:?}: {before} {energy}");
            let u = regions::rows::<3>(solution.u.view());
            model.fit(Weights::of(&mass.on(mesh).integrate::<3>(&u)), &mut mu).unwrap();
            let problem = problem_of::<3>(mesh, 3, model.costs(&mu), &request).unwrap();
            before = problem.baseline + problem.energy(&u);
            let rounding = 1e-12 * (energy - baseline);
            assert!(before <= energy + rounding, "{mass:?}: {energy} {before}");
        }
    }
}

#[test]
fn the_energy_does_not_rise() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let first = [[0.4; 3], [0.5; 3], [0.6, 0.4, 0.5]].map(|mu| mu.to_vec());
    let means = first.clone().map(|mean| Mean { mean });
    the_energy_of_a_model_does_not_rise(&mesh, &PiecewiseConstant::new(&data), &means);
    let medians = first.clone().map(|median| Median { median });
    the_energy_of_a_model_does_not_rise(&mesh, &L1::new(&data), &medians);
    let covariance = [[0.1, 0.02, 0.0], [0.02, 0.1, 0.0], [0.0, 0.0, 0.2]].map(|row| row.to_vec());
    let normal = first.map(|mean| Moments { mean, covariance: covariance.to_vec() });
    the_energy_of_a_model_does_not_rise(&mesh, &Gaussian::new(&data).unwrap(), &normal);
}

#[test]
fn the_same_seed_gives_the_same_result() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.3);
    for initial in [Initial::KMeans, Initial::Random] {
        let result = |seed: u64| {
            let request = request(0.03, Mass::Barycentric);
            let found = segment(
                &mesh,
                &PiecewiseConstant::new(&data),
                &alternation(initial, seed),
                &request,
                &mut go,
            )
            .unwrap();
            (found.solution.u, found.parameters, found.estimates)
        };
        assert_eq!(result(3), result(3));
        assert_ne!(result(3).0, result(4).0, "{initial:?}: the seed has no effect");
    }
}

/// Means are area-weighted: where vertices are dense, each one counts less.
#[test]
fn parameters_are_area_weighted_means() {
    let mut mesh = shape("grid:60x20");
    mesh.vertices.iter_mut().for_each(|x| x.x = x.x.powi(3));
    let data = Data::new(1, mesh.vertices.iter().map(|x| x.x).collect()).unwrap();
    for mass in Mass::iter() {
        let alternation = Alternation { regions: 2, ..alternation(Initial::KMeans, 5) };
        let found = segment(
            &mesh,
            &PiecewiseConstant::new(&data),
            &alternation,
            &request(1e-3, mass),
            &mut go,
        )
        .unwrap();
        let u = regions::rows::<2>(found.solution.u.view());
        let weights = mass.on(&mesh).integrate(&u);
        for (p, region) in found.parameters.iter().enumerate() {
            let total: f64 = weights.iter().map(|w| w.0[p]).sum();
            let mean =
                weights.iter().zip(&data.values).map(|(w, c)| w.0[p] * c).sum::<f64>() / total;
            assert!((region.mean[0] - mean).abs() < 2e-3, "{mass:?}: {region:?} {mean}");
        }
    }
}

/// Data in another unit, with lambda scaled accordingly, take the same steps to the same labels.
#[test]
fn the_unit_of_the_data_does_not_matter() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let found = |unit: f64, regions: usize| {
        let values = data.values.iter().map(|c| c * unit).collect();
        let alternation = Alternation { regions, ..alternation(Initial::Random, 5) };
        let request = request(0.05 * unit * unit, Mass::Barycentric);
        let data = Data::new(3, values).unwrap();
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        (found.estimates, found.solution.labels)
    };
    for regions in [3, 5] {
        let one = found(1.0, regions);
        // Powers of two round nothing.
        for exponent in [-14, 14] {
            assert_eq!(found(2.0_f64.powi(exponent), regions), one, "{exponent}");
        }
    }
}

/// More regions than colors, in padded rows, do no harm.
#[test]
fn nine_regions_for_three_colors_are_solved() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.0);
    let alternation = Alternation { regions: 9, ..alternation(Initial::KMeans, 2) };
    let request = request(0.01, Mass::Barycentric);
    let found =
        segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go).unwrap();
    assert_eq!((found.parameters.len(), found.solution.u.dim().1), (9, 9));
    assert!(found.solution.summary.energy.is_finite());
    assert!(found.solution.u.outer_iter().all(|row| (row.sum() - 1.0).abs() < 1e-12));
}

#[test]
fn invalid_requests_are_refused() {
    let mesh = shape("sphere:1");
    let (data, _) = painted(&mesh, 0.0);
    let short = Data::new(3, vec![0.0; 9]).unwrap();
    let cases = [
        (&short, 3, 0.1, "vertices"),
        (&data, 1, 0.1, "regions"),
        (&data, 65, 0.1, "regions"),
        (&data, 3, -1.0, "lambda"),
        (&data, 3, f64::NAN, "lambda"),
    ];
    for (data, regions, lambda, word) in cases {
        let alternation = Alternation { regions, ..alternation(Initial::KMeans, 0) };
        let request = request(lambda, Mass::Barycentric);
        let Err(error) =
            segment(&mesh, &PiecewiseConstant::new(data), &alternation, &request, &mut go)
        else {
            panic!("{word} passes");
        };
        let message = error.to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
    }
}
