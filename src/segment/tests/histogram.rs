//! Regions with histograms: equal means and covariances, negative costs, units.

use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::data::Histogram;
use crate::data::synthetic::waves;

/// Data in R^d of two regions of waves, given by the region and a source of normal numbers.
fn drawn(
    mesh: &Mesh,
    d: usize,
    seed: u64,
    of: impl Fn(usize, &mut dyn FnMut() -> f64) -> Vec<f64>,
) -> (Data, Vec<usize>) {
    let truth = waves(mesh, 2, 0.0, 0).labels;
    let mut rng = rng(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let values = truth.iter().flat_map(|&p| of(p, &mut normal)).collect();
    (Data::new(d, values).unwrap(), truth)
}

/// +-1 with noise, and normal data of the same mean and variance.
fn two_peaks_and_one(p: usize, normal: &mut dyn FnMut() -> f64) -> Vec<f64> {
    vec![match p {
        0 => f64::signum(normal()) + 0.2 * normal(),
        _ => 1.04_f64.sqrt() * normal(),
    }]
}

/// Two colors with noise, and two other ones with the same mean.
fn pairs_of_colors(p: usize, normal: &mut dyn FnMut() -> f64) -> Vec<f64> {
    let s = 0.3 * f64::signum(normal());
    let color = [[0.5 + s, 0.5, 0.5 - s], [0.5 + s, 0.5, 0.5 + s]][p];
    color.iter().map(|c| c + 0.1 * normal()).collect()
}

/// Two colors with noise, and their mean with more noise.
fn colors_and_their_mean(p: usize, normal: &mut dyn FnMut() -> f64) -> Vec<f64> {
    let s = 0.3 * f64::signum(normal());
    match p {
        0 => [0.5 + s, 0.5, 0.5 - s].iter().map(|c| c + 0.1 * normal()).collect(),
        _ => (0..3).map(|_| 0.5 + 0.2 * normal()).collect(),
    }
}

/// The fraction of correct labels of two regions, with lambda chosen by default.
fn accuracy<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    truth: &[usize],
    seed: u64,
    coarse_to_fine: bool,
) -> f64 {
    let alternation = Alternation { regions: 2, ..alternation(Initial::KMeans, seed) };
    let request = Request { coarse_to_fine, ..request(0.0, Mass::Barycentric) };
    let lambda = lambda::of_data(mesh, model, &alternation, &request, &mut go).unwrap();
    let request = Request { lambda, ..request };
    let found = segment(mesh, model, &alternation, &request, &mut go).unwrap();
    let summary = &found.solution.summary;
    assert_eq!(summary.status, Status::Converged);
    assert!(summary.dual_bound <= summary.energy && summary.relative_gap <= 1e-4);
    let labels = truth.iter().zip(&found.solution.labels);
    let right = labels.filter(|&(&t, &l)| t == l as usize).count() as f64 / truth.len() as f64;
    right.max(1.0 - right)
}

/// Regions of equal means; those of the first case have equal variances, too, so that normal distributions do not separate them.
#[test]
fn regions_of_the_same_mean_are_found() {
    let mesh = shape("torus:100x60");
    let mesh = mesh.clone().scaled(1.0 / mesh.area().sqrt());
    for seed in 0..5 {
        let cases = [
            drawn(&mesh, 1, seed, two_peaks_and_one),
            drawn(&mesh, 3, seed, pairs_of_colors),
            drawn(&mesh, 3, seed, colors_and_their_mean),
            drawn(&mesh, 1, seed, |p, normal| vec![[0.05, 0.3][p] * normal()]),
            drawn(&mesh, 3, seed, |p, normal| (0..3).map(|_| [0.05, 0.3][p] * normal()).collect()),
        ];
        for (i, (data, truth)) in cases.iter().enumerate() {
            let model = Histogram::new(data).unwrap();
            for coarse_to_fine in [false, true] {
                let right = accuracy(&mesh, &model, truth, seed, coarse_to_fine);
                assert!(right > 0.97, "case {i}, {seed}, {coarse_to_fine}: {right}");
            }
            let constant = accuracy(&mesh, &PiecewiseConstant::new(data), truth, seed, false);
            assert!(constant < 0.75, "case {i}, {seed}: {constant}");
        }
        let (data, truth) = &cases[0];
        let gaussian = accuracy(&mesh, &Gaussian::new(data).unwrap(), truth, seed, false);
        assert!(gaussian < 0.75, "{seed}: {gaussian}");
    }
}

/// The final energy, which is negative for densities above 1, and its bound are those of the reported parameters.
#[test]
fn the_certificate_holds_for_negative_costs() {
    let mesh = shape("sphere:3");
    let (mut data, _) = painted(&mesh, 0.2);
    data.values[..30].fill(f64::NAN);
    let model = Histogram::new(&data).unwrap();
    for mass in Mass::iter() {
        let request = request(0.05, mass);
        let alternation = alternation(Initial::KMeans, 1);
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let summary = &found.solution.summary;
        assert!(summary.energy < 0.0 && summary.status == Status::Converged);
        let costs = || model.costs::<3>(&found.parameters);
        let problem = problem_of::<3>(&mesh, 3, costs(), &request).unwrap();
        let u = regions::rows::<3>(found.solution.u.view());
        let energy = problem.baseline + problem.energy(&u);
        assert_within(energy, summary.energy, 1e-12, summary.energy.abs());
        let s = regions::array(&costs(), 3);
        let start = crate::start::Start::Uniform;
        let exact = crate::solve::solve(&mesh, &s, &start, &request, &mut go).unwrap().summary;
        assert!(summary.dual_bound <= exact.energy && exact.dual_bound <= summary.energy);
    }
}

/// Costs are logarithms of densities: data in other units have the same labels for the same lambda.
#[test]
fn the_units_of_the_coordinates_do_not_matter() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let found = |[a, b]: [[f64; 3]; 2]| {
        let values = data.values.chunks(3).flat_map(|c| [0, 1, 2].map(|i| a[i] * c[i] + b[i]));
        let data = Data::new(3, values.collect()).unwrap();
        let model = Histogram::new(&data).unwrap();
        let alternation = alternation(Initial::KMeans, 5);
        let request = request(0.0, Mass::Barycentric);
        let lambda = lambda::of_data(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let request = Request { lambda, ..request };
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        (lambda, found.solution.labels)
    };
    let one = found([[1.0; 3], [0.0; 3]]);
    assert_eq!(found([[2.0_f64.powi(14); 3], [0.0; 3]]), one);
    assert_eq!(found([[0.25, 255.0, 3.0], [-3.0, 10.0, 0.5]]), one);
}
