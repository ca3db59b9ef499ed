//! Densities, fits that are minimizers, starts that know neighbors, and coarse data that stand for finer ones.

use super::density::{FLOOR, costs, distance, masses};
use super::*;
use crate::data::ModelName;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::Mass;
use crate::samples::{
    assert_within, bumpy, fitted_energy, random_data, random_labels, rng, shape, to_fit,
    with_isolated_vertices,
};
use crate::sweep::with_threads;

/// Parameters of three regions of these data.
fn three(model: &Histogram) -> Vec<Frequencies> {
    model.start(Initial::Random, 3, &vec![1.0; model.vertices()], &mut rng(200)).unwrap()
}

fn data(dimension: usize, values: Vec<f64>) -> Data {
    Data::new(dimension, values).unwrap()
}

fn fit<const M: usize>(model: &Histogram, weights: &[Row<M>], mu: &mut [Frequencies]) -> f64 {
    model.fit(Weights::of(weights), mu).unwrap()
}

/// Midpoints of cells of half a bin, on which the interpolation is multilinear, so that sums over them integrate exactly;
/// and the volume of a cell.
fn midpoints(grid: &Grid) -> (Data, f64) {
    let (d, bins, ranges) = (grid.dimension(), grid.bins(), grid.ranges());
    let cells: usize = bins.iter().map(|n| 2 * n).product();
    let mut values = Vec::new();
    for cell in 0..cells {
        let mut rest = cell;
        for i in 0..d {
            let t = ((rest % (2 * bins[i])) as f64 + 0.5) / (2 * bins[i]) as f64;
            rest /= 2 * bins[i];
            values.push(ranges[i][0] + t * (ranges[i][1] - ranges[i][0]));
        }
    }
    (data(d, values), grid.log_volume().exp() / f64::from(1 << d))
}

/// Each datum is the mean of the centers of its bins, if it is within the range of the centers.
#[test]
fn shares_interpolate_linearly() {
    for d in 1..=MAX_DIMENSION {
        let points = random_data(300, d, 201);
        let grid = Grid::of(&points).unwrap();
        let ranges = grid.ranges();
        for k in 0..300 {
            let corners = grid.corners(points.at(k));
            assert_within(corners.iter().map(|(_, share)| share).sum(), 1.0, 1e-15, 1.0);
            for (i, &c) in points.at(k).iter().enumerate() {
                let half = 0.5 * (ranges[i][1] - ranges[i][0]) / grid.bins()[i] as f64;
                let mean: f64 = corners.iter().map(|(b, share)| share * grid.center(b)[i]).sum();
                let expected = c.clamp(ranges[i][0] + half, ranges[i][1] - half);
                assert_within(mean, expected, 1e-13, 1.0);
            }
            assert!(corners.iter().all(|(b, share)| b < grid.len() && share >= 0.0));
        }
    }
}

/// F is symmetric, its rows have the sum 1, and no entry is negative.
#[test]
fn smoothing_is_symmetric_and_keeps_the_mass() {
    for d in 1..=MAX_DIMENSION {
        let grid = Grid::of(&random_data(50, d, 202)).unwrap();
        let [mut a, mut b]: [Vec<f64>; 2] =
            [203, 204].map(|seed| random_data(grid.len(), 1, seed).values);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (old_a, old_b) = (a.clone(), b.clone());
        grid.smooth(&mut a);
        grid.smooth(&mut b);
        assert_within(dot(&a, &old_b), dot(&old_a, &b), 1e-13, dot(&a, &old_b));
        assert_within(a.iter().sum(), old_a.iter().sum(), 1e-13, grid.len() as f64);
        let mut ones = vec![1.0; grid.len()];
        grid.smooth(&mut ones);
        assert!(ones.iter().all(|x| (x - 1.0).abs() < 1e-13));
    }
}

/// The interpolated density has the integral 1, and exp(-s) at most that.
#[test]
fn densities_integrate_to_one() {
    for d in 1..=MAX_DIMENSION {
        let points = random_data(400, d, 205);
        let model = Histogram::new(&points).unwrap();
        let mu = three(&model);
        let (cells, volume) = midpoints(&model.grid);
        let at = Histogram { data: Cow::Borrowed(&cells), ..model.clone() };
        let costs = at.costs::<3>(&mu);
        for (p, mu) in mu.iter().enumerate() {
            let density: Vec<f64> =
                mu.mass.iter().map(|mass| mass * (-model.grid.log_volume()).exp()).collect();
            let interpolated = |k: usize| {
                let corners = model.grid.corners(cells.at(k));
                corners.iter().map(|(b, share)| share * density[b]).sum::<f64>()
            };
            let integral: f64 = (0..cells.len()).map(|k| volume * interpolated(k)).sum();
            assert_within(integral, 1.0, 1e-12, 1.0);
            let integral: f64 = costs.iter().map(|s| volume * (-s.0[p]).exp()).sum();
            assert!(integral < 1.0 && integral > 0.5, "{d}: {integral}");
        }
    }
}

/// The logarithm of a normal density is quadratic, so that F adds half of the ratio of its variance, in squared bins the
/// number of passes / 2, to that of the density. This is what exp(-s) lacks to the integral 1.
#[test]
fn smoothing_adds_half_of_a_ratio_of_variances() {
    let points = data(1, (0..=1000).map(|k| f64::from(k) / 100.0 - 5.0).collect());
    let grid = Grid::of(&points).unwrap();
    let width = grid.log_volume().exp();
    let (sigma, center) = (0.8, |b: usize| grid.center(b)[0]);
    let normal =
        |c: f64| (-0.5 * (c / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt());
    let mass: Vec<f64> = (0..grid.len()).map(|b| normal(center(b)) * width).collect();
    assert_within(mass.iter().sum(), 1.0, 1e-8, 1.0);
    let f = costs(&grid, &mass);
    for (b, f) in f.iter().enumerate().take(grid.len() - 20).skip(20) {
        let expected = 0.5 * 4.0 * width * width / (sigma * sigma) - normal(center(b)).ln();
        assert_within(*f, expected, 1e-11, 1.0 + expected.abs());
    }
}

/// Masses are at least the floor, have the sum 1, and are proportional to the smoothed counts above the floor.
#[test]
fn masses_satisfy_the_conditions_of_optimality() {
    let grid = Grid::of(&random_data(50, 1, 206)).unwrap();
    let mut draw = rng(207);
    for exponent in [1, 4, 12, 40] {
        let counts: Vec<f64> =
            (0..grid.len()).map(|_| draw.random::<f64>().powi(exponent)).collect();
        let mass = masses(&grid, counts.clone());
        let (mut smooth, floor) = (counts, FLOOR / grid.len() as f64);
        grid.smooth(&mut smooth);
        assert_within(mass.iter().sum(), 1.0, 1e-14, 1.0);
        let ratio = |b: usize| mass[b] / smooth[b];
        let least = (0..mass.len()).map(ratio).fold(f64::INFINITY, f64::min);
        assert!(mass.iter().all(|&x| x >= floor));
        let at_floor = |b: usize| mass[b] == floor;
        assert!((0..mass.len()).all(|b| at_floor(b) || ratio(b) <= least * (1.0 + 1e-14)));
        assert_eq!((0..mass.len()).any(at_floor), exponent > 4, "{exponent}");
    }
}

/// The fit minimizes sum <u, M s> for each quadrature among all masses above the floor. The increase for other masses D' is
/// sum_b (F W_p)_b log(D_b / D'_b).
#[test]
fn the_fit_is_the_minimizer() {
    for (mesh, data, u, mass) in to_fit(208) {
        let (model, quadrature) = (Histogram::new(&data).unwrap(), mass.on(&mesh));
        let energy = |mu: &[Frequencies]| fitted_energy(&model, &quadrature, &u, mu);
        let mut mu = three(&model);
        let before = energy(&mu);
        let weights = quadrature.integrate(&u);
        fit(&model, &weights, &mut mu);
        let minimum = energy(&mu);
        assert!(minimum < before);
        let total: f64 = weights.iter().map(|w| w.0.iter().sum::<f64>()).sum();
        let mut rng = rng(209);
        for p in 0..3 {
            let mut sums = vec![0.0; model.grid.len()];
            for (k, w) in weights.iter().enumerate() {
                let corners = model.grid.corners(data.at(k));
                corners.iter().for_each(|(b, share)| sums[b] += share * w.0[p]);
            }
            model.grid.smooth(&mut sums);
            for size in [1e-4, 1e-2, 0.5] {
                let noise = sums.iter().map(|_| rng.random_range(-1.0..1.0_f64));
                let mut other: Vec<f64> =
                    mu[p].mass.iter().zip(noise).map(|(x, t)| x * (size * t).exp()).collect();
                // A mixture with the uniform density is above the floor.
                let total_mass: f64 = other.iter().sum();
                let bins = other.len() as f64;
                other.iter_mut().for_each(|x| *x = (1.0 - FLOOR) * *x / total_mass + FLOOR / bins);
                let log = |b: usize| sums[b] * (mu[p].mass[b] / other[b]).ln();
                let expected: f64 = (0..other.len()).map(log).sum();
                let mut moved = mu.clone();
                moved[p].mass = other;
                let rise = energy(&moved) - minimum;
                assert!(rise > 0.0, "{mass:?}, {size}: {rise}");
                assert_within(rise, expected, 1e-11, total);
            }
        }
        assert_eq!(fit(&model, &weights, &mut mu), 0.0);
    }
}

/// The mean is that of the data that are within the range of the centers of the bins.
#[test]
fn the_mean_is_that_of_the_data() {
    let mut values: Vec<f64> = (0..1000).map(|k| f64::from(k % 10)).collect();
    values[3] = 1e6;
    let points = data(1, values);
    let model = Histogram::new(&points).unwrap();
    let high = model.grid.ranges()[0][1];
    assert!(high < 20.0);
    let inner: Vec<Row<1>> =
        points.values.iter().map(|&c| Row([if c > 0.5 && c < 8.5 { 1.0 } else { 0.0 }])).collect();
    let mut mu = vec![three(&model).swap_remove(0)];
    fit(&model, &inner, &mut mu);
    let (sum, mass) = (points.values.iter().zip(&inner))
        .fold((0.0, 0.0), |(sum, mass), (c, w)| (sum + w.0[0] * c, mass + w.0[0]));
    assert_within(mu[0].mean[0], sum / mass, 1e-13, 1.0);
}

/// Unknown vertices cost nothing and do not affect bins and parameters.
#[test]
fn unknown_vertices_are_ignored() {
    let known = random_data(40, 2, 210);
    let rows = known.values.chunks(2).flat_map(|c| [c, &[f64::NAN, 7.0]]);
    let all_rows = data(2, rows.flatten().copied().collect());
    let [all, some] = [&all_rows, &known].map(|data| Histogram::new(data).unwrap());
    let u = random_labels::<3>(80, 3, &mut rng(211));
    let of_known: Vec<Row<3>> = u.iter().step_by(2).copied().collect();
    let (mut mu, mut expected) = (three(&some), three(&some));
    fit(&all, &u, &mut mu);
    fit(&some, &of_known, &mut expected);
    assert_eq!(mu, expected);
    let costs = all.costs::<3>(&mu);
    assert!(costs.iter().skip(1).step_by(2).all(|s| *s == Row::ZERO));
    assert!(costs.iter().step_by(2).zip(some.costs::<3>(&mu)).all(|(a, b)| *a == b));
    assert!(all.is_known(0) && !all.is_known(1));
}

#[test]
fn an_empty_region_keeps_its_parameters() {
    let points = random_data(9, 2, 212);
    let model = Histogram::new(&points).unwrap();
    let mut mu = three(&model);
    let first = mu.clone();
    let change = fit(&model, &[Row([0.2, 0.0, 0.0]); 9], &mut mu);
    assert_eq!(mu[1..], first[1..]);
    assert_eq!(change, Histogram::distance(&mu[0], &first[0]));
    // Costs of the regions that pad a row are zero.
    assert!(model.costs::<4>(&mu).iter().all(|s| s.0[3] == 0.0));
}

/// Data a C + b in each coordinate have the same masses, in the reverse order if a < 0, and costs that differ by log |a|.
#[test]
fn neither_the_unit_nor_the_zero_of_a_coordinate_matters() {
    let points = random_data(500, 2, 213);
    for ([a, b], exact) in
        [([1e3, -7.0], false), ([-0.25, 0.0], true), ([2.0_f64.powi(40), 0.0], true)]
    {
        let image = points.values.chunks(2).flat_map(|c| [a * c[0] + b, c[1]]);
        let mapped = data(2, image.collect());
        let models = [&points, &mapped].map(|data| Histogram::new(data).unwrap());
        let u = random_labels::<3>(500, 3, &mut rng(214));
        let mut mu = models.each_ref().map(three);
        models.iter().zip(&mut mu).for_each(|(model, mu)| _ = fit(model, &u, mu));
        let tolerance = if exact { 1e-14 } else { 1e-10 };
        for (one, other) in mu[0].iter().zip(&mu[1]) {
            let n = one.bins[1];
            for (i, one) in one.mass.chunks(n).enumerate() {
                let i = if a < 0.0 { other.bins[0] - 1 - i } else { i };
                let other = &other.mass[i * n..][..n];
                assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < tolerance));
            }
            assert_within(other.mean[0], a * one.mean[0] + b, 1e-10, a.abs());
        }
        let [one, other] = [0, 1].map(|i| models[i].costs::<3>(&mu[i]));
        for (one, other) in one.iter().zip(&other) {
            let shift = *other - *one;
            assert!((0..3).all(|p| (shift.0[p] - a.abs().ln()).abs() < 1e-8));
        }
    }
}

/// For normal densities of variances s and t with the same mean, H^2 = 1 - sqrt(2 sqrt(s t) / (s + t)).
#[test]
fn the_distance_is_that_of_hellinger() {
    let points = data(1, (0..10_000).map(|k| f64::from(k) / 500.0 - 10.0).collect());
    let grid = Grid::of(&points).unwrap();
    let normal = |variance: f64| -> Vec<f64> {
        let density = |b: usize| (-0.5 * grid.center(b)[0].powi(2) / variance).exp();
        let total: f64 = (0..grid.len()).map(density).sum();
        (0..grid.len()).map(|b| density(b) / total).collect()
    };
    let (s, t) = (0.5_f64, 2.0);
    let expected = (1.0 - (2.0 * (s * t).sqrt() / (s + t)).sqrt()).sqrt();
    assert_within(distance(&normal(s), &normal(t)), expected, 1e-10, 1.0);
    assert_eq!(distance(&normal(s), &normal(s)), 0.0);
    let disjoint = |b: usize| [0, 1].map(|i| if i == b { 1.0 } else { 0.0 });
    assert_eq!(distance(&disjoint(0), &disjoint(1)), 1.0);
}

/// On a level and on the next, with vertices of which nothing is known and vertices without faces.
#[test]
fn coarse_costs_are_the_restricted_ones() {
    let mesh = with_isolated_vertices(bumpy(24));
    for d in 1..=MAX_DIMENSION {
        let mut data = random_data(mesh.vertices.len(), d, 215);
        data.values[..10 * d].fill(f64::NAN);
        let weights = Mass::Barycentric.weights(&mesh);
        let mut model = Histogram::new(&data).unwrap();
        let mu = three(&model);
        let costs = |model: &Histogram, weights: &[f64]| -> Vec<Row<3>> {
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

/// The fit to a coarse mesh is that to the fine one with prolonged labels.
#[test]
fn the_fit_of_coarse_data_is_that_of_the_fine_ones() {
    let mesh = shape("torus:30x20");
    let data = random_data(mesh.vertices.len(), 2, 216);
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |_| true);
    let model = Histogram::new(&data).unwrap();
    let restricted = model.restricted(&level, &weights, &coarse);
    let u = random_labels::<3>(coarse.len(), 3, &mut rng(217));
    let fine = crate::transfer::prolong(&level.parents, &u);
    let weighted = |u: &[Row<3>], w: &[f64]| -> Vec<Row<3>> {
        u.iter().zip(w).map(|(&u, &w)| u * w).collect()
    };
    let (mut mu, mut expected) = (three(&model), three(&model));
    fit(&restricted, &weighted(&u, &coarse), &mut mu);
    fit(&model, &weighted(&fine, &weights), &mut expected);
    for (mu, expected) in mu.iter().zip(&expected) {
        assert!(Histogram::distance(mu, expected) < 1e-12);
        assert_within(mu.mean[0], expected.mean[0], 1e-12, 1.0);
    }
}

#[test]
fn vertices_keep_their_data_in_another_order() {
    let (mesh, _): (Mesh, _) = crate::samples::shuffled(&shape("torus:30x20"), &mut rng(218));
    let data = random_data(mesh.vertices.len(), 2, 219);
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |_| true);
    let fine = Histogram::new(&data).unwrap();
    let mu = three(&fine);
    let restricted = fine.restricted(&level, &weights, &coarse);
    for (model, mesh) in [(&fine, &mesh), (&restricted, &level.mesh)] {
        let order = Order::of(mesh);
        let costs = model.costs::<3>(&mu);
        let moved = model.in_order(&order).costs::<3>(&mu);
        let vertices = order.vertices().expect("a shuffled mesh has another order");
        assert!(vertices.iter().zip(&moved).all(|(&k, s)| *s == costs[k as usize]));
    }
}

/// Two regions with the same mean and variance in stripes: data at +-1, and normal data.
fn striped(n: usize, seed: u64) -> Data {
    use rand_distr::{Distribution, StandardNormal};
    let mut rng = rng(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let values = (0..n).map(|k| match k / 40 % 2 {
        0 => f64::signum(normal()) + 0.2 * normal(),
        _ => 1.04_f64.sqrt() * normal(),
    });
    data(1, values.collect())
}

/// Neighbors separate regions of equal mean and variance. In a random numbering there is nothing to be seen of them, and
/// the start is clusters of the values.
#[test]
fn the_start_uses_neighbors_if_they_say_anything() {
    for seed in 0..5 {
        let points = striped(8000, 230 + seed);
        let own = |k: usize| Row::one_hot(k / 40 % 2);
        let truth: Vec<Row<2>> = (0..8000).map(own).collect();
        let start = |points: &Data| {
            let model = Histogram::new(points).unwrap();
            let mut expected =
                model.start(Initial::Random, 2, &[1.0; 8000], &mut rng(seed)).unwrap();
            fit(&model, &truth, &mut expected);
            let mu = model.start(Initial::KMeans, 2, &[1.0; 8000], &mut rng(seed)).unwrap();
            let off = |a: usize, b: usize| {
                f64::max(
                    Histogram::distance(&mu[0], &expected[a]),
                    Histogram::distance(&mu[1], &expected[b]),
                )
            };
            f64::min(off(0, 1), off(1, 0))
        };
        let near = start(&points);
        assert!(near < 0.15, "{seed}: {near}");
        let mut shuffled: Vec<f64> = points.values.clone();
        rand::seq::SliceRandom::shuffle(&mut shuffled[..], &mut rng(seed));
        let far = start(&data(1, shuffled));
        assert!(far > 0.3, "{seed}: {far}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let points = random_data(40_000, 2, 220);
    let u = random_labels::<4>(40_000, 4, &mut rng(221));
    let run = |threads: usize| {
        with_threads(Some(threads), || {
            let model = Histogram::new(&points).unwrap();
            let mut mu = model.start(Initial::KMeans, 4, &[1e-3; 40_000], &mut rng(222)).unwrap();
            let first = mu.clone();
            fit(&model, &u, &mut mu);
            (first, model.costs::<4>(&mu), mu)
        })
        .unwrap()
    };
    let one = run(1);
    assert!([2, 3, 7].iter().all(|&threads| run(threads) == one));
}

/// Data that do not vary in some direction, or at all, or by columns of very different units, have finite costs; a
/// direction without variance has no part in their differences.
#[test]
fn degenerate_data_have_finite_costs() {
    let line = random_data(200, 1, 223);
    let three_times = |scales: [f64; 3]| {
        data(3, line.values.iter().flat_map(|x| scales.map(|s| s * x)).collect())
    };
    let u = random_labels::<3>(200, 3, &mut rng(224));
    let differences = |data: &Data| -> Vec<f64> {
        let model = Histogram::new(data).unwrap();
        let mut mu = model.start(Initial::KMeans, 3, &[1.0; 200], &mut rng(225)).unwrap();
        fit(&model, &u, &mut mu);
        let costs = model.costs::<3>(&mu);
        costs.iter().flat_map(|s| [s.0[1] - s.0[0], s.0[2] - s.0[0]]).collect()
    };
    let expected = differences(&line);
    for scales in [[1.0, 0.0, 0.0], [0.0, 1e6, 0.0], [0.0, 0.0, 1e-90]] {
        for (found, expected) in differences(&three_times(scales)).iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10, "{scales:?}: {found} {expected}");
        }
    }
    assert!(differences(&three_times([1e-6, 1e6, 3.0])).iter().all(|x| x.is_finite()));
    for value in [0.0, 0.1, 1e300] {
        let constant = data(1, vec![value; 200]);
        assert!(differences(&constant).iter().all(|x| *x == 0.0));
        assert_eq!(Histogram::new(&constant).unwrap().scale(&[1.0; 200]).cost, 0.0);
    }
}

#[test]
fn unsuitable_data_are_refused_in_a_sentence() {
    let message = |data: &Data| Histogram::new(data).err().unwrap().to_string();
    let wide = message(&random_data(40, 4, 226));
    assert!(wide.contains("4 columns") && wide.contains("at most 3"), "{wide}");
    let huge = message(&data(1, vec![-1.7e308, 0.0, 1.7e308]));
    assert!(huge.contains("scale the data") && !huge.contains('\n'), "{huge}");
    assert_eq!("histogram".parse(), Ok(ModelName::Histogram));
}

/// Parameters survive a file; those that have no costs for these data are refused, with the region.
#[test]
fn parameters_from_outside_are_checked() {
    let points = random_data(300, 2, 227);
    let model = Histogram::new(&points).unwrap();
    let mu = three(&model);
    let text = serde_json::to_string(&mu).unwrap();
    assert_eq!(serde_json::from_str::<Vec<Frequencies>>(&text).unwrap(), mu);
    assert!(model.check(&mu).is_ok());
    let refused = |change: &dyn Fn(&mut Frequencies), why: &str| {
        let mut mu = mu.clone();
        change(&mut mu[1]);
        let message = model.check(&mu).unwrap_err().to_string();
        assert!(message.contains("region 1") && message.contains(why), "{message}");
    };
    refused(&|mu| mu.mean.push(0.0), "3 numbers for data of 2 columns");
    refused(&|mu| mu.mean[0] = f64::NAN, "not finite");
    refused(&|mu| mu.range[1][0] -= 1.0, "other bins");
    refused(&|mu| mu.bins = vec![4, 4], "other bins");
    refused(&|mu| _ = mu.mass.pop(), "a mass for each");
    refused(&|mu| mu.mass[5] = 0.0, "must be positive");
    refused(&|mu| mu.mass[5] = f64::NAN, "must be positive");
    refused(&|mu| mu.mass[5] += 0.01, "sum 1");
}
