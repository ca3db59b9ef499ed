//! Densities, fits that are minimizers, starts that know spreads, and coarse data that stand for finer ones.

use nalgebra::{DMatrix, SymmetricEigen};

use super::*;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Mass, Quadrature};
use crate::samples::{
    assert_within, bumpy, fitted_energy, random_data, random_labels, rng, shape, to_fit,
    with_isolated_vertices,
};

fn moments<const D: usize>(mean: [f64; D], covariance: [[f64; D]; D]) -> Moments {
    let covariance = covariance.iter().map(|row| row.to_vec()).collect();
    Moments { mean: mean.to_vec(), covariance }
}

fn matrix(mu: &Moments) -> DMatrix<f64> {
    let d = mu.mean.len();
    DMatrix::from_fn(d, d, |i, j| mu.covariance[i][j])
}

fn with_covariance(mu: &Moments, sigma: &DMatrix<f64>) -> Moments {
    let row = |i: usize| sigma.row(i).iter().copied().collect();
    Moments { mean: mu.mean.clone(), covariance: (0..mu.mean.len()).map(row).collect() }
}

/// Three regions in the plane: round, oblique, and thin.
fn three() -> Vec<Moments> {
    vec![
        moments([0.2, 0.9], [[0.3, 0.0], [0.0, 0.3]]),
        moments([0.5, 0.1], [[0.5, 0.3], [0.3, 0.4]]),
        moments([1.4, 0.3], [[0.9, -0.2], [-0.2, 0.05]]),
    ]
}

/// Sums over a fine grid of the plane of exp(-s), which is smooth and falls to zero: exact up to rounding.
#[test]
fn costs_are_minus_logarithms_of_densities() {
    let cells = 600;
    let at = |i: usize| 24.0 * (i as f64 / cells as f64 - 0.5);
    let points = (0..cells * cells).flat_map(|k| [at(k / cells), at(k % cells)]);
    let data = Data::new(2, points.collect()).unwrap();
    let mu = three();
    let costs = Gaussian::new(&data).unwrap().costs::<3>(&mu);
    let cell = (24.0 / cells as f64).powi(2);
    for (p, mu) in mu.iter().enumerate() {
        let integral = |f: &dyn Fn(&[f64]) -> f64| -> f64 {
            (0..data.len()).map(|k| cell * (-costs[k].0[p]).exp() * f(data.at(k))).sum()
        };
        assert_within(integral(&|_| 1.0), 1.0, 1e-11, 1.0);
        for i in 0..2 {
            assert_within(integral(&|c| c[i]), mu.mean[i], 1e-11, 1.0);
            for j in 0..2 {
                let product = |c: &[f64]| (c[i] - mu.mean[i]) * (c[j] - mu.mean[j]);
                assert_within(integral(&product), mu.covariance[i][j], 1e-11, 1.0);
            }
        }
    }
}

/// In one dimension, and in four, which has no code of its own, against the formula with an inverse and a determinant.
#[test]
fn costs_are_those_of_the_formula_in_any_dimension() {
    let mut rng = rng(151);
    for d in [1, 2, 3, 4, MAX_DIMENSION] {
        let data = random_data(50, d, 152);
        let root = DMatrix::from_fn(d, d, |_, _| rng.random_range(-1.0..1.0));
        let sigma = &root * root.transpose() + 0.1 * DMatrix::identity(d, d);
        let mean = Moments { mean: (0..d).map(|_| rng.random()).collect(), covariance: Vec::new() };
        let mu = with_covariance(&mean, &sigma);
        let costs = Gaussian::new(&data).unwrap().costs::<1>(std::slice::from_ref(&mu));
        let precision = sigma.clone().try_inverse().unwrap();
        let constant = 0.5 * (sigma.determinant().ln() + d as f64 * std::f64::consts::TAU.ln());
        for (k, cost) in costs.iter().enumerate() {
            let x = DMatrix::from_fn(d, 1, |i, _| data.at(k)[i] - mu.mean[i]);
            let expected = 0.5 * (x.transpose() * &precision * &x)[(0, 0)] + constant;
            assert_within(cost.0[0], expected, 1e-10, 1.0 + expected.abs());
        }
    }
}

/// Labels by which region 0 has only the first few vertices and what the mass matrix adds to them, and data whose second
/// coordinate hardly varies there: the fit of region 0 is at the floor.
fn with_a_thin_region(quadrature: &Quadrature<'_>, data: &mut Data, u: &mut [Row<3>]) {
    for u in &mut u[5..] {
        *u = Row([0.0, u.0[1] + u.0[0], u.0[2]]);
    }
    u[..5].fill(Row([0.8, 0.1, 0.1]));
    for (k, w) in quadrature.integrate(u).iter().enumerate().filter(|(_, w)| w.0[0] > 0.0) {
        data.values[2 * k + 1] = 0.5 + 1e-5 * w.0[0];
    }
}

/// The covariance with its eigenvalues relative to G raised to the floor: the nearest feasible one, in some sense.
fn feasible(model: &Gaussian, sigma: &DMatrix<f64>) -> DMatrix<f64> {
    let floor = FLOOR * covariance_of_all(model);
    let root = floor.cholesky().unwrap().l();
    let inverse = root.clone().try_inverse().unwrap();
    let mut eigen = SymmetricEigen::new(&inverse * sigma * inverse.transpose());
    eigen.eigenvalues.apply(|e| *e = e.max(1.0));
    &root * eigen.recompose() * root.transpose()
}

/// G, of all vertices alike.
fn covariance_of_all(model: &Gaussian) -> DMatrix<f64> {
    let (data, n) = (&model.data, model.data.len() as f64);
    let mean = [0, 1].map(|i| data.column(i).iter().sum::<f64>() / n);
    let x = DMatrix::from_fn(2, data.len(), |i, k| data.at(k)[i] - mean[i]);
    &x * x.transpose() / n
}

/// The fitted parameters minimize sum <u, M s> among covariances above the floor, for each quadrature: no feasible
/// change of a mean or of a covariance, small or large, lowers it, whether the floor is reached or not.
#[test]
fn the_fit_is_the_minimizer() {
    let cases = to_fit(153).flat_map(|case| [(case.clone(), false), (case, true)]);
    for ((mesh, mut data, mut u, mass), thin) in cases {
        let quadrature = mass.on(&mesh);
        if thin {
            with_a_thin_region(&quadrature, &mut data, &mut u);
        }
        let model = Gaussian::new(&data).unwrap();
        let energy = |mu: &[Moments]| fitted_energy(&model, &quadrature, &u, mu);
        let mut mu = three();
        let before = energy(&mu);
        let weights = quadrature.integrate(&u);
        model.fit(Weights::of(&weights), &mut mu).unwrap();
        let minimum = energy(&mu);
        assert!(minimum < before);
        let total: f64 = weights.iter().map(|w| w.0.iter().sum::<f64>()).sum();
        let floor = FLOOR * covariance_of_all(&model);
        let lowest = |mu: &Moments| {
            let root = floor.clone().cholesky().unwrap().l().try_inverse().unwrap();
            SymmetricEigen::new(&root * matrix(mu) * root.transpose()).eigenvalues.min()
        };
        let at_floor = mu.iter().filter(|mu| (lowest(mu) - 1.0).abs() < 1e-6).count();
        assert_eq!(at_floor, usize::from(thin), "{mass:?}");
        let mut rng = rng(154);
        for (p, scale) in (0..3).flat_map(|p| [1e-5, 1e-3, 0.1, 1.0].map(|scale| (p, scale))) {
            for _ in 0..20 {
                let mut moved = mu.clone();
                let size = matrix(&mu[p]).trace();
                let mut draw = || scale * rng.random_range(-1.0..1.0);
                let noise = DMatrix::from_fn(2, 2, |_, _| size * draw());
                let sigma = matrix(&mu[p]) + &noise + noise.transpose();
                moved[p] = with_covariance(&mu[p], &feasible(&model, &sigma));
                moved[p].mean.iter_mut().for_each(|x| *x += size.sqrt() * draw());
                let rise = energy(&moved) - minimum;
                assert!(rise >= -1e-12 * total, "{mass:?}, {scale}: {rise}");
                // Along the floor as well: the same eigenvalues in other directions.
                let turn = nalgebra::Rotation2::new(draw()).into_inner();
                let turn = DMatrix::from_fn(2, 2, |i, j| turn[(i, j)]);
                let sigma = feasible(&model, &(&turn * matrix(&mu[p]) * turn.transpose()));
                moved[p] = with_covariance(&mu[p], &sigma);
                let rise = energy(&moved) - minimum;
                assert!(rise >= -1e-12 * total, "{mass:?}, {scale}: {rise}");
            }
        }
        assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
    }
}

/// Away from the floor the mean cost of a region is (1/2) log det Sigma + (d/2) (1 + log 2 pi): the trace of
/// Sigma^-1 Sigma is d.
#[test]
fn the_cost_of_a_fitted_region_is_its_entropy() {
    for (mesh, data, u, mass) in to_fit(155) {
        let (model, quadrature) = (Gaussian::new(&data).unwrap(), mass.on(&mesh));
        let (weights, mut mu) = (quadrature.integrate(&u), three());
        model.fit(Weights::of(&weights), &mut mu).unwrap();
        let entropy =
            |mu: &Moments| 0.5 * matrix(mu).determinant().ln() + 1.0 + std::f64::consts::TAU.ln();
        let region = |p: usize| weights.iter().map(|w| w.0[p]).sum::<f64>() * entropy(&mu[p]);
        let expected: f64 = (0..3).map(region).sum();
        let energy = fitted_energy(&model, &quadrature, &u, &mu);
        assert_within(energy, expected, 1e-12, expected.abs());
    }
}

/// The data A C + b have the parameters A mu + b and A Sigma A^T, and costs that differ by log |det A|, from any start.
#[test]
fn models_are_affinely_equivariant() {
    let data = random_data(500, 2, 156);
    let (a, b) = ([[3.0, -1.0], [200.0, 40.0]], [7.0, -900.0]);
    let image = |c: &[f64]| [0, 1].map(|i| a[i][0] * c[0] + a[i][1] * c[1] + b[i]);
    let mapped = Data::new(2, data.values.chunks(2).flat_map(image).collect()).unwrap();
    let determinant: f64 = 3.0 * 40.0 + 200.0;
    let models = [&data, &mapped].map(|data| Gaussian::new(data).unwrap());
    let a = DMatrix::from_fn(2, 2, |i, j| a[i][j]);
    let u = random_labels::<3>(500, 3, &mut rng(157));
    for initial in [Initial::KMeans, Initial::Random] {
        let mut mu = models
            .each_ref()
            .map(|model| model.start(initial, 3, &[1.0; 500], &mut rng(158)).unwrap());
        for fitted in [false, true] {
            if fitted {
                models
                    .iter()
                    .zip(&mut mu)
                    .for_each(|(model, mu)| _ = model.fit(Weights::of(&u), mu).unwrap());
            }
            for (one, other) in mu[0].iter().zip(&mu[1]) {
                let mean = image(&one.mean);
                let expected = with_covariance(
                    &Moments { mean: mean.to_vec(), covariance: Vec::new() },
                    &(&a * matrix(one) * a.transpose()),
                );
                assert!(normal::distance(&expected, other) < 1e-6, "{initial:?}");
            }
            let [one, other] = [0, 1].map(|i| models[i].costs::<3>(&mu[i]));
            for (one, other) in one.iter().zip(&other) {
                let shift = *other - *one;
                assert!((0..3).all(|p| (shift.0[p] - determinant.ln()).abs() < 1e-5));
            }
        }
    }
}

/// The distance squared is the integral of (s_b - s_a) (exp(-s_a) - exp(-s_b)).
#[test]
fn the_distance_is_the_symmetric_divergence() {
    let cells = 20_000;
    let points = (0..cells).map(|i| 60.0 * (i as f64 / cells as f64 - 0.5));
    let data = Data::new(1, points.collect()).unwrap();
    let (a, b) = (moments([0.3], [[0.5]]), moments([-0.4], [[2.0]]));
    let costs = Gaussian::new(&data).unwrap().costs::<2>(&[a.clone(), b.clone()]);
    let term = |s: &Row<2>| (s.0[1] - s.0[0]) * ((-s.0[0]).exp() - (-s.0[1]).exp());
    let integral: f64 = costs.iter().map(term).sum::<f64>() * 60.0 / cells as f64;
    assert_within(Gaussian::distance(&a, &b).powi(2), integral, 1e-11, 1.0);
    assert_eq!(Gaussian::distance(&a, &b), Gaussian::distance(&b, &a));
    assert_eq!(Gaussian::distance(&a, &a), 0.0);
    // For a common covariance it is the Mahalanobis distance.
    let c = moments([1.3], [[0.5]]);
    assert_within(Gaussian::distance(&a, &c), 1.0 / 0.5_f64.sqrt(), 1e-14, 1.0);
    // A relative change of a variance by d is one of d / sqrt 2, however small.
    let d = moments([0.3], [[0.5 * (1.0 + 1e-9)]]);
    assert_within(Gaussian::distance(&a, &d), 1e-9 / 2.0_f64.sqrt(), 1e-6, 1e-9);
}

/// Of what is not known, costs, parameters and the floor take no notice.
#[test]
fn unknown_vertices_count_for_nothing() {
    let known = random_data(40, 2, 159);
    let rows = known.values.chunks(2).flat_map(|c| [c, &[f64::NAN, 7.0]]);
    let data = Data::new(2, rows.flatten().copied().collect()).unwrap();
    let [all, some] = [&data, &known].map(|data| Gaussian::new(data).unwrap());
    let u = random_labels::<3>(80, 3, &mut rng(160));
    let of_known: Vec<Row<3>> = u.iter().step_by(2).copied().collect();
    let (mut mu, mut expected) = (three(), three());
    all.fit(Weights::of(&u), &mut mu).unwrap();
    some.fit(Weights::of(&of_known), &mut expected).unwrap();
    assert_eq!(mu, expected);
    let costs = all.costs::<3>(&mu);
    assert!(costs.iter().skip(1).step_by(2).all(|s| *s == Row::ZERO));
    assert!(costs.iter().step_by(2).zip(some.costs::<3>(&mu)).all(|(a, b)| *a == b));
    assert!(all.is_known(0) && !all.is_known(1));
}

#[test]
fn an_empty_region_keeps_its_parameters() {
    let data = random_data(9, 2, 161);
    let model = Gaussian::new(&data).unwrap();
    let mut mu = three();
    let first = mu.clone();
    let change = model.fit(Weights::of(&[Row([0.2, 0.0, 0.0]); 9]), &mut mu).unwrap();
    assert_eq!(mu[1..], first[1..]);
    assert_eq!(change, Gaussian::distance(&mu[0], &first[0]));
    // Costs of the regions that pad a row are zero.
    assert!(model.costs::<4>(&mu).iter().all(|s| s.0[3] == 0.0));
}

/// On a level and on the next, with vertices of which nothing is known and vertices without faces.
#[test]
fn coarse_costs_are_the_restricted_ones() {
    let mesh = with_isolated_vertices(bumpy(24));
    for d in [1, 2, 4] {
        let mut data = random_data(mesh.vertices.len(), d, 162);
        data.values[..10 * d].fill(f64::NAN);
        let mut rng = rng(163);
        let weights = Mass::Barycentric.weights(&mesh);
        let mut model = Gaussian::new(&data).unwrap();
        let mu = model.start(Initial::Random, 3, &weights, &mut rng).unwrap();
        let mu: Vec<Moments> = mu.into_iter().zip([0.1, 0.5, 1.0]).map(narrower).collect();
        let costs = |model: &Gaussian, weights: &[f64]| -> Vec<Row<3>> {
            model.costs::<3>(&mu).iter().zip(weights).map(|(&s, &w)| s * w).collect()
        };
        let (mut fine, mut weights) = (mesh.clone(), weights);
        let mut exact = costs(&model, &weights);
        let size = exact.iter().map(|f| f.max_abs()).fold(0.0, f64::max);
        for _ in 0..2 {
            let level = fine.coarsened();
            let coarse = level.restricted(&weights, |v| model.is_known(v));
            model = model.restricted(&level, &weights, &coarse);
            exact = crate::transfer::restrict(&level, &exact);
            (fine, weights) = (level.mesh, coarse);
            let off =
                costs(&model, &weights).into_iter().zip(&exact).map(|(f, &e)| (f - e).max_abs());
            let off = off.fold(0.0, f64::max);
            assert!(off <= 1e-12 * size, "{d}: {off} of {size}");
        }
    }
}

fn narrower((mu, factor): (Moments, f64)) -> Moments {
    let sigma = factor * matrix(&mu);
    with_covariance(&mu, &sigma)
}

/// The fit to a coarse mesh is that to the fine one with prolonged labels, and so are the moments of all data.
#[test]
fn the_fit_of_coarse_data_is_that_of_the_fine_ones() {
    let mesh = shape("torus:30x20");
    let data = random_data(mesh.vertices.len(), 2, 164);
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |_| true);
    let model = Gaussian::new(&data).unwrap();
    let restricted = model.restricted(&level, &weights, &coarse);
    let u = random_labels::<3>(coarse.len(), 3, &mut rng(165));
    let fine = crate::transfer::prolong(&level.parents, &u);
    let weighted = |u: &[Row<3>], w: &[f64]| -> Vec<Row<3>> {
        u.iter().zip(w).map(|(&u, &w)| u * w).collect()
    };
    let (mut mu, mut expected) = (three(), three());
    restricted.fit(Weights::of(&weighted(&u, &coarse)), &mut mu).unwrap();
    model.fit(Weights::of(&weighted(&fine, &weights)), &mut expected).unwrap();
    for (mu, expected) in mu.iter().zip(&expected) {
        assert!(Gaussian::distance(mu, expected) < 1e-12);
    }
}

#[test]
fn vertices_keep_their_data_in_another_order() {
    let (mesh, _): (Mesh, _) = crate::samples::shuffled(&shape("torus:30x20"), &mut rng(166));
    let data = random_data(mesh.vertices.len(), 2, 167);
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |_| true);
    let model = Gaussian::new(&data).unwrap().restricted(&level, &weights, &coarse);
    let order = Order::of(&level.mesh);
    let costs = model.costs::<3>(&three());
    let moved = model.in_order(&order).costs::<3>(&three());
    let vertices = order.vertices().expect("a shuffled mesh has another order");
    assert!(vertices.iter().zip(&moved).all(|(&k, s)| *s == costs[k as usize]));
}

/// Normal data of the given deviations around given means, in equal parts and mixed order.
fn normal_data<const D: usize>(parts: &[([f64; D], [f64; D])], n: usize, seed: u64) -> Data {
    use rand_distr::{Distribution, StandardNormal};
    let mut rng = rng(seed);
    let mut values = Vec::new();
    for k in 0..n {
        let (mean, deviation) = parts[k % parts.len()];
        for i in 0..D {
            let x: f64 = StandardNormal.sample(&mut rng);
            values.push(mean[i] + deviation[i] * x);
        }
    }
    Data::new(D, values).unwrap()
}

/// Parts that differ in their means, in their spreads alone, in both, or in the directions in which they are long.
#[test]
fn mixtures_are_found_from_any_seed() {
    fn check<const D: usize>(parts: &[([f64; D], [f64; D])]) {
        for seed in 0..5 {
            let data = normal_data(parts, 9000, seed);
            let model = Gaussian::new(&data).unwrap();
            let weights = vec![1e-3; 9000];
            let start =
                |seed| model.start(Initial::KMeans, parts.len(), &weights, &mut rng(seed)).unwrap();
            let mu = start(seed);
            assert_eq!(mu, start(seed));
            for (mean, deviation) in parts {
                let mut covariance = [[0.0; D]; D];
                (0..D).for_each(|i| covariance[i][i] = deviation[i] * deviation[i]);
                let truth = moments(*mean, covariance);
                let nearest =
                    mu.iter().map(|mu| Gaussian::distance(mu, &truth)).fold(9.0, f64::min);
                assert!(nearest < 0.3, "{seed}: {truth:?} is not in {mu:?}");
            }
        }
    }
    check(&[([0.0], [0.05]), ([0.0], [0.3])]);
    check(&[([0.0; 3], [0.05; 3]), ([0.0; 3], [0.3; 3])]);
    check(&[([0.0, 0.0], [0.1, 1.0]), ([0.0, 0.0], [1.0, 0.1])]);
    check(&[([0.0], [1.0]), ([6.0], [1.0]), ([12.0], [1.0]), ([18.0], [0.2])]);
    check(&[
        ([0.0, 0.0], [0.1; 2]),
        ([0.0, 0.0], [1.0; 2]),
        ([6.0, 0.0], [0.1; 2]),
        ([6.0, 0.0], [1.0; 2]),
    ]);
}

/// Data that do not vary in some direction (gray in three channels), or at all, or by columns of very different units,
/// have finite costs; a direction without variance has no part in their differences.
#[test]
fn degenerate_data_have_finite_costs() {
    let line = random_data(200, 1, 168);
    let three_times = |scales: [f64; 3]| {
        Data::new(3, line.values.iter().flat_map(|x| scales.map(|s| s * x)).collect()).unwrap()
    };
    let u = random_labels::<3>(200, 3, &mut rng(169));
    let differences = |data: &Data| -> Vec<f64> {
        let model = Gaussian::new(data).unwrap();
        let mut mu = model.start(Initial::KMeans, 3, &[1.0; 200], &mut rng(170)).unwrap();
        model.fit(Weights::of(&u), &mut mu).unwrap();
        let costs = model.costs::<3>(&mu);
        costs.iter().flat_map(|s| [s.0[1] - s.0[0], s.0[2] - s.0[0]]).collect()
    };
    let expected = differences(&line);
    for scales in [[1.0; 3], [1.0, 0.0, 0.0], [1e-6, 1e6, 3.0], [1e-90, 1e90, 0.0]] {
        let found = differences(&three_times(scales));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-6, "{scales:?}: {found} {expected}");
        }
    }
    for value in [0.0, 0.1, 1e300] {
        let constant = Data::new(1, vec![value; 200]).unwrap();
        assert!(differences(&constant).iter().all(|x| *x == 0.0));
        assert_eq!(Gaussian::new(&constant).unwrap().scale(&[1.0; 200]).cost, 0.0);
    }
}

#[test]
fn data_that_cannot_be_fitted_are_refused_in_a_sentence() {
    let message = |data: &Data| Gaussian::new(data).err().unwrap().to_string();
    let wide = message(&random_data(40, MAX_DIMENSION + 1, 171));
    assert!(wide.contains("17 columns") && wide.contains("at most 16"), "{wide}");
    for unit in [1e200, 1e-200] {
        let values = random_data(40, 1, 172).values.iter().map(|x| unit * x).collect();
        let message = message(&Data::new(1, values).unwrap());
        assert!(message.contains("scale the data") && !message.contains('\n'), "{message}");
    }
}
