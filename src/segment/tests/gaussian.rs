//! Regions with normal distributions: equal means, negative costs, units.

use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::data::synthetic::waves;
use crate::sweep::sum;

/// Data of mean 0 in R^d on two regions of waves, with one deviation in each.
fn equal_means(mesh: &Mesh, d: usize, deviations: [f64; 2], seed: u64) -> (Data, Vec<usize>) {
    let truth = waves(mesh, 2, 0.0, 0).labels;
    let mut rng = rng(seed);
    let drawn = |&p: &usize| -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        (0..d).map(|_| deviations[p] * normal()).collect()
    };
    let values = truth.iter().flat_map(drawn).collect();
    (Data::new(d, values).unwrap(), truth)
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

/// Regions of equal means and different spreads, which means do not tell apart.
#[test]
fn regions_that_differ_by_their_spread_are_found() {
    let mesh = shape("torus:100x60");
    let mesh = mesh.clone().scaled(1.0 / mesh.area().sqrt());
    for (d, seed) in [1, 3].into_iter().flat_map(|d| (0..5).map(move |seed| (d, seed))) {
        let (data, truth) = equal_means(&mesh, d, [0.05, 0.3], seed);
        for coarse_to_fine in [false, true] {
            let model = Gaussian::new(&data).unwrap();
            let right = accuracy(&mesh, &model, &truth, seed, coarse_to_fine);
            assert!(right > 0.97, "{d}, {seed}: {right}");
        }
        let constant = accuracy(&mesh, &PiecewiseConstant::new(&data), &truth, seed, false);
        assert!(constant < 0.75, "{d}, {seed}: {constant}");
    }
}

/// The final energy, which is negative, and its bound are those of the reported parameters.
#[test]
fn the_certificate_holds_for_negative_costs() {
    let mesh = shape("sphere:3");
    let (mut data, _) = painted(&mesh, 0.2);
    data.values[..30].fill(f64::NAN);
    let model = Gaussian::new(&data).unwrap();
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

/// Costs are logarithms: data in another unit, or mixed by an affine map, have the same labels for the same lambda.
#[test]
fn neither_the_unit_nor_the_axes_of_the_data_matter() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let found = |map: &dyn Fn(&[f64]) -> [f64; 3], initial: Initial| {
        let values = data.values.chunks(3).flat_map(map).collect();
        let data = Data::new(3, values).unwrap();
        let model = Gaussian::new(&data).unwrap();
        let alternation = alternation(initial, 5);
        let request = request(0.0, Mass::Barycentric);
        let lambda = lambda::of_data(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let request = Request { lambda, ..request };
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        (lambda, found.estimates, found.solution.labels)
    };
    for initial in [Initial::KMeans, Initial::Random] {
        let one = found(&|c| [c[0], c[1], c[2]], initial);
        for exponent in [-14, 14] {
            let unit = 2.0_f64.powi(exponent);
            assert_eq!(found(&|c| [0, 1, 2].map(|i| unit * c[i]), initial), one, "{exponent}");
        }
        let (lambda, _, labels) = found(
            &|c| [c[0] + 0.5 * c[1] - 3.0, 255.0 * (c[1] - c[2]), 0.3 * c[2] + 0.2 * c[0]],
            initial,
        );
        assert_eq!((lambda, labels), (one.0, one.2), "{initial:?}");
    }
}

/// For lambda = 0 the alternation is that of hard assignments and fits (classification EM, Celeux and Govaert 1992,
/// for equal shares), implemented independently here, in the plane: the same parameters and labels from the same
/// start.
#[test]
fn without_cuts_it_is_classification_em() {
    let mesh = shape("sphere:4");
    let mut rng = rng(181);
    let parts = [
        ([0.0, 0.0], [0.3, 0.0, 0.3]),
        ([1.5, 0.5], [0.5, 0.3, 0.2]),
        ([0.0, 2.5], [0.2, -0.1, 0.6]),
    ];
    let mut values = Vec::new();
    for k in 0..mesh.vertices.len() {
        let (mean, [a, b, c]) = parts[k % 3];
        let [x, y]: [f64; 2] = [0; 2].map(|_| StandardNormal.sample(&mut rng));
        values.extend([mean[0] + a * x, mean[1] + b * x + c * y]);
    }
    let data = Data::new(2, values).unwrap();
    let model = Gaussian::new(&data).unwrap();
    let request = request(0.0, Mass::Barycentric);
    let weights = request.mass.weights(&mesh);
    for seed in 0..3 {
        let alternation = alternation(Initial::KMeans, seed);
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        // `segment` draws its start in the same way.
        let mut rng = Pcg64::seed_from_u64(seed);
        let start = model.start(Initial::KMeans, 3, &weights, &mut rng).unwrap();
        let mut mu: Vec<([f64; 2], [f64; 3])> = start
            .iter()
            .map(|mu| {
                let [row, other] = [&mu.covariance[0], &mu.covariance[1]];
                ([mu.mean[0], mu.mean[1]], [row[0], row[1], other[1]])
            })
            .collect();
        let mut labels = vec![9; weights.len()];
        loop {
            let cost = |c: &[f64], (mean, [a, b, d]): &([f64; 2], [f64; 3])| {
                let (x, y, determinant) = (c[0] - mean[0], c[1] - mean[1], a * d - b * b);
                (d * x * x - 2.0 * b * x * y + a * y * y) / determinant + determinant.ln()
            };
            let cheapest = |k: usize| {
                let costs = mu.iter().map(|mu| cost(data.at(k), mu));
                costs.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
            };
            let next: Vec<usize> = (0..weights.len()).map(cheapest).collect();
            if next == labels {
                break;
            }
            labels = next;
            for (p, mu) in mu.iter_mut().enumerate() {
                let n = weights.len();
                let w = |k: usize| if labels[k] == p { weights[k] } else { 0.0 };
                let mass = sum(n, w);
                let mean = [0, 1].map(|i| sum(n, |k| w(k) * data.at(k)[i]) / mass);
                let x = |k: usize, i: usize| data.at(k)[i] - mean[i];
                let moment = |i: usize, j: usize| sum(n, |k| w(k) * x(k, i) * x(k, j)) / mass;
                *mu = (mean, [moment(0, 0), moment(0, 1), moment(1, 1)]);
            }
        }
        let agree = labels.iter().zip(&found.solution.labels).filter(|&(&a, &b)| a == b as usize);
        assert_eq!(agree.count(), labels.len(), "{seed}");
        for (found, (mean, [a, b, c])) in found.parameters.iter().zip(&mu) {
            let covariance = vec![vec![*a, *b], vec![*b, *c]];
            let expected = Moments { mean: mean.to_vec(), covariance };
            assert!(Gaussian::distance(found, &expected) < 1e-6, "{found:?} {expected:?}");
        }
    }
}

/// Up to the largest and the smallest numbers, data are segmented as any, or refused in a sentence.
#[test]
fn data_whose_variances_overflow_are_refused() {
    let mesh = shape("sphere:2");
    let (data, _) = equal_means(&mesh, 3, [1.0, 3.0], 9);
    let mut refused = 0;
    for exponent in
        [-165, -156, -155, -154, -153, -152, -140, 0, 140, 150, 151, 152, 153, 154, 155, 156, 165]
    {
        let values = data.values.iter().map(|x| x * 10_f64.powi(exponent)).collect();
        let data = Data::new(3, values).unwrap();
        let found = Gaussian::new(&data).and_then(|model| {
            let alternation = Alternation { regions: 2, ..alternation(Initial::KMeans, 5) };
            segment(&mesh, &model, &alternation, &request(0.01, Mass::Barycentric), &mut go)
        });
        match found {
            Ok(found) => assert_eq!(found.solution.summary.status, Status::Converged, "{exponent}"),
            Err(error) => {
                assert!(exponent.abs() > 140, "{exponent}: {error}");
                assert!(error.to_string().contains("scale the data"), "{exponent}: {error}");
                refused += 1;
            }
        }
    }
    assert!(refused >= 4);
}
