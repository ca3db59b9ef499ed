//! Medians resist outliers, and coarse data represent the fine ones.

use super::*;
use crate::data::PiecewiseConstant;
use crate::data::constant::Mean;
use crate::field::Row;
use crate::operator::Mass;
use crate::samples::{bumpy, fitted_energy, random_data, random_labels, rng, shape, to_fit};

fn medians<const P: usize>(medians: [&[f64]; P]) -> Vec<Median> {
    medians.map(|median| Median { median: median.to_vec() }).to_vec()
}

#[test]
fn costs_are_sums_of_distances() {
    let data = Data::new(2, vec![0.0, 1.0, 3.0, 5.0]).unwrap();
    let costs = L1::new(&data).costs::<2>(&medians([&[0.0, 0.0], &[3.0, 1.0]]));
    assert_eq!(costs, [Row([1.0, 3.0]), Row([8.0, 4.0])]);
}

/// The fitted medians minimize sum <u, M s>, for each quadrature: moving a coordinate of one of them never decreases
/// it, and moving it beyond all data costs at least the mass times the distance, less the width of the data.
#[test]
fn the_fit_is_the_minimizer() {
    for (mesh, data, u, mass) in to_fit(131) {
        let (model, quadrature) = (L1::new(&data), mass.on(&mesh));
        let energy = |mu: &[Median]| fitted_energy(&model, &quadrature, &u, mu);
        let mut mu = medians([&[0.1, 0.9], &[0.5, 0.5], &[2.0, -1.0]]);
        let before = energy(&mu);
        let weights = quadrature.integrate(&u);
        model.fit(Weights::of(&weights), &mut mu).unwrap();
        let least = energy(&mu);
        assert!(least < before);
        let moves = [1e-6, 1e-3, 1e-2, 0.1, 0.5, 3.0].into_iter().flat_map(|d| [d, -d]);
        for (p, d) in (0..3).flat_map(|p| moves.clone().map(move |d| (p, d))) {
            let region: f64 = weights.iter().map(|w| w.0[p]).sum();
            for i in 0..2 {
                let mut moved = mu.clone();
                moved[p].median[i] += d;
                let rise = energy(&moved) - least;
                let expected = f64::max(d.abs() - 1.0, 0.0) * region;
                assert!(rise >= expected - 1e-13 * before, "{mass:?}, {d}: {rise}");
            }
        }
        assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
    }
}

/// If half of a region lies on either side of a gap, every value between is a median: a value in the gap stays, any
/// other moves to the nearest end.
#[test]
fn the_nearest_of_many_medians_is_taken() {
    let data = Data::new(1, vec![3.0, 0.0, 1.0, 7.0]).unwrap();
    let model = L1::new(&data);
    for (before, after) in [(2.0, 2.0), (0.0, 1.0), (9.0, 3.0), (1.0, 1.0)] {
        let mut mu = medians([&[before]]);
        let change = model.fit(Weights::of(&[Row([1.0]); 4]), &mut mu).unwrap();
        assert_eq!((mu[0].median[0], change), (after, f64::abs(after - before)));
    }
    // A vertex without weight does not bound the gap.
    let weights = [1.0, 1.0, 0.0, 0.0].map(|w| Row([w]));
    let mut mu = medians([&[1.5]]);
    assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
}

/// As long as more than half of a region has one value, the rest does not matter.
#[test]
fn outliers_do_not_move_the_median() {
    let fitted = |far: f64, weight: f64| {
        let data = Data::new(1, [vec![0.25; 60], vec![far; 40]].concat()).unwrap();
        let rows: Vec<Row<1>> =
            (0..100).map(|k| Row([if k < 60 { 1.0 } else { weight }])).collect();
        let mut mu = medians([&[0.5]]);
        L1::new(&data).fit(Weights::of(&rows), &mut mu).unwrap();
        mu[0].median[0]
    };
    for far in [0.5, -3.0, 1e9, -1e300] {
        assert_eq!(fitted(far, 1.0), 0.25);
        // The mass counts, not the number of vertices.
        assert_eq!(fitted(far, 1.6), far);
    }
}

/// Unknown vertices affect neither costs nor medians nor the scale.
#[test]
fn unknown_vertices_are_ignored() {
    let data = Data::new(2, vec![0.0, 1.0, f64::NAN, 7.0, 4.0, 3.0]).unwrap();
    let model = L1::new(&data);
    let mut mu = medians([&[0.0, 0.0], &[3.0, 1.0]]);
    assert_eq!(model.costs::<2>(&mu)[1], Row::ZERO);
    model.fit(Weights::of(&[Row([0.5, 0.0]), Row([9.0, 9.0]), Row([0.25, 2.0])]), &mut mu).unwrap();
    assert_eq!(mu, medians([&[0.0, 1.0], &[4.0, 3.0]]));
    assert_eq!(model.scale(&[1.0, 5.0, 1.0]).distance, 3.0);
}

/// The scale has the unit of the data, and a few distant values change it little.
#[test]
fn the_scale_has_the_unit_of_the_data() {
    let mut data = random_data(1000, 2, 131);
    let area = vec![0.5; 1000];
    let scale = |data: &Data| L1::new(data).scale(&area).cost;
    let one = scale(&data);
    // Half of the deviations of two coordinates: numbers from 0 to 1 deviate by a quarter on average.
    assert!((one - 0.25).abs() < 0.02, "{one}");
    let values = data.values.iter().map(|x| 2.0 * x).collect();
    assert_eq!(scale(&Data { dimension: 2, values }), 2.0 * one);
    data.values[..20].fill(1e9);
    assert!((scale(&data) - one).abs() < 0.05);
    // Two values, one of them rare.
    let values = (0..1000).map(|k| if k < 10 { 1.0 } else { 0.0 }).collect();
    let two = scale(&Data { dimension: 1, values });
    assert!((two - 0.005).abs() < 1e-12, "{two}");
}

/// Initial values are data, not mixtures of them, whatever the seed; a region without vertices has the median of all.
#[test]
fn a_random_start_has_medians() {
    let data = Data::new(1, vec![0.0, 1.0, 5.0, f64::NAN]).unwrap();
    let model = L1::new(&data);
    for seed in 0..20 {
        let mu = model.start(Initial::Random, 9, &[1.0; 4], &mut rng(seed)).unwrap();
        let one_of = |mu: &Median| [0.0, 1.0, 5.0].contains(&mu.median[0]);
        assert!(mu.len() == 9 && mu.iter().all(one_of), "{mu:?}");
        let middle = mu.iter().filter(|mu| mu.median[0] == 1.0).count();
        assert!(middle >= 5, "{mu:?}");
    }
}

/// A few distant values do not become initial regions.
#[test]
fn outliers_do_not_become_initial_regions() {
    let mut rng = rng(135);
    let value = |k: usize| match k % 97 {
        0 => rng.random_range(-1e6..1e6),
        _ => (k % 3) as f64 + rng.random_range(-0.1..0.1),
    };
    let data = Data::new(1, (0..3000).map(value).collect()).unwrap();
    let model = L1::new(&data);
    for seed in 0..5 {
        let mut rng = crate::samples::rng(seed);
        let mu = model.start(Initial::KMeans, 3, &[1.0; 3000], &mut rng).unwrap();
        let mut found: Vec<f64> = mu.iter().map(|mu| mu.median[0]).collect();
        found.sort_by(f64::total_cmp);
        let near = found.iter().zip([0.0, 1.0, 2.0]).all(|(a, b)| (a - b).abs() < 0.05);
        assert!(near, "{found:?}");
    }
}

/// Medians of coarse vertices ignore a few outliers; means would be affected by each.
#[test]
fn coarse_data_are_medians() {
    let mesh = bumpy(24);
    let mut rng = rng(43);
    let values = mesh.vertices.iter().map(|_| match rng.random_range(0..30) {
        0 => f64::NAN,
        1 => 1e6,
        _ => 0.25,
    });
    let data = Data::new(1, values.collect()).unwrap();
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |v| data.is_known(v));
    let restricted = L1::new(&data).restricted(&level, &weights, &coarse);
    let far = restricted.middle(0).iter().filter(|&&x| x != 0.25).count();
    let means = PiecewiseConstant::new(&data).restricted(&level, &weights, &coarse);
    let costs = means.costs::<1>(&[Mean { mean: vec![0.25] }]);
    let moved = costs.iter().filter(|s| s.0[0] > 1e-9).count();
    assert!(far < coarse.len() / 20 && moved > 2 * far, "{far} {moved} of {}", coarse.len());
}

/// On two successive levels the costs are close to the restricted ones, up to a constant per vertex, even for pure
/// noise. The costs of the medians alone are not.
#[test]
fn coarse_costs_are_close_to_the_restricted_ones() {
    let mesh = shape("torus:60x40");
    let data = random_data(mesh.vertices.len(), 2, 131);
    let mu = medians([&[0.2, 0.9], &[0.5, 0.1], &[0.7, 0.6]]);
    let costs = |model: &L1, weights: &[f64]| -> Vec<Row<3>> {
        model.costs::<3>(&mu).iter().zip(weights).map(|(&s, &w)| s * w).collect()
    };
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f64>();
    let (mut model, mut weights) = (L1::new(&data), Mass::Barycentric.weights(&mesh));
    let (mut mesh, mut exact) = (mesh, costs(&model, &weights));
    for _ in 0..2 {
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |_| true);
        model = model.restricted(&level, &weights, &coarse);
        exact = crate::transfer::restrict(&level, &exact);
        (mesh, weights) = (level.mesh, coarse);
        let differences = |f: &Row<3>| [f.0[1] - f.0[0], f.0[2] - f.0[0], f.0[2] - f.0[1]];
        let off = |f: &[Row<3>]| -> f64 {
            let pairs = f.iter().zip(&exact).map(|(f, exact)| (differences(f), exact));
            pairs.map(|(f, exact)| distance(f, differences(exact))).sum()
        };
        let size = off(&vec![Row::ZERO; exact.len()]);
        let values = [0, 1].map(|i| model.middle(i));
        let values = (0..exact.len()).flat_map(|k| [values[0][k], values[1][k]]).collect();
        let middle = Data::new(2, values).unwrap();
        let off = [&model, &L1::new(&middle)].map(|model| off(&costs(model, &weights)));
        assert!(off[0] < 0.2 * size && off[1] > 0.5 * size, "{off:?} of {size}");
    }
}

/// On a coarse mesh, too, the fit is the minimizer.
#[test]
fn the_fit_of_coarse_data_is_the_minimizer() {
    let mesh = shape("torus:30x20");
    let data = random_data(mesh.vertices.len(), 2, 131);
    let weights = Mass::Barycentric.weights(&mesh);
    let level = mesh.coarsened();
    let coarse = level.restricted(&weights, |_| true);
    let model = L1::new(&data).restricted(&level, &weights, &coarse);
    let u = random_labels::<3>(coarse.len(), 3, &mut rng(134));
    let weights: Vec<Row<3>> = u.iter().zip(&coarse).map(|(&u, &w)| u * w).collect();
    let energy = |mu: &[Median]| -> f64 {
        model.costs::<3>(mu).iter().zip(&weights).map(|(&s, w)| w.dot(s)).sum()
    };
    let mut mu = medians([&[0.1, 0.9], &[0.5, 0.5], &[2.0, -1.0]]);
    let before = energy(&mu);
    model.fit(Weights::of(&weights), &mut mu).unwrap();
    let least = energy(&mu);
    assert!(least < before && model.fit(Weights::of(&weights), &mut mu).unwrap() == 0.0);
    for (p, i, d) in (0..3).flat_map(|p| [(p, 0, 0.01), (p, 1, -0.01), (p, 0, -0.3), (p, 1, 0.3)]) {
        let mut moved = mu.clone();
        moved[p].median[i] += d;
        assert!(energy(&moved) >= least - 1e-13 * before);
    }
}
