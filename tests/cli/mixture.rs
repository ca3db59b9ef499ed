//! The Gaussian model at lambda = 0 is classification EM, which scikit-learn computes as well: the densities, the
//! parameters for one-hot responsibilities, and the fixed point of both steps.

use meshseg::Mesh;
use meshseg::data::gaussian::{FLOOR, Moments};
use meshseg::data::{Data, DataModel, Gaussian, Initial, Weights};
use meshseg::operator::Mass;
use ndarray::{Array1, Array2};
use ndarray_npy::write_npy;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::reference::{reference, succeeded};
use crate::support::Folder;

const M: usize = 3;

/// Two regions with the same mean and different spreads, and an oblique one beside them.
fn clusters(n: usize, d: usize, rng: &mut Pcg64) -> Array2<f64> {
    let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    Array2::from_shape_vec(
        (n, d),
        (0..n)
            .flat_map(|k| {
                let common = normal();
                let x: Vec<f64> = (0..d).map(|_| normal()).collect();
                x.into_iter().enumerate().map(move |(i, x)| match k % M {
                    0 => 3.0 + 0.1 * x,
                    1 => 3.0 + 0.8 * x,
                    _ => 5.0 + 0.9 * common + (0.2 + 0.1 * i as f64) * x,
                })
            })
            .collect(),
    )
    .unwrap()
}

/// A torus whose vertices have different weights.
fn uneven() -> Mesh {
    let mut mesh = "torus:40x25".parse::<meshseg::mesh::Shape>().unwrap().mesh();
    mesh.vertices.iter_mut().for_each(|x| x.x *= 1.0 + 0.5 * x.y.signum());
    mesh
}

/// Classification EM from `mu` on: the parameters and the labels at its end.
fn classified(model: &Gaussian, weights: &[f64], mut mu: Vec<Moments>) -> (Vec<Moments>, Vec<i64>) {
    let label = |mu: &[Moments]| -> Vec<i64> {
        let costs = model.costs::<M>(mu);
        let least = |s: &[f64; M]| (0..M).min_by(|&p, &q| s[p].total_cmp(&s[q])).unwrap();
        costs.iter().map(|s| least(&s.0) as i64).collect()
    };
    let mut labels = label(&mu);
    loop {
        let masses = labels.iter().zip(weights).flat_map(|(&label, &weight)| {
            (0..M as i64).map(move |p| if p == label { weight } else { 0.0 })
        });
        model.fit(Weights::new(&masses.collect::<Vec<_>>(), M), &mut mu).unwrap();
        let before = std::mem::replace(&mut labels, label(&mu));
        if before == labels {
            return (mu, labels);
        }
    }
}

/// Compares with scikit-learn, which starts at `start`.
fn assert_same(
    data: &Array2<f64>,
    weights: &[f64],
    start: &[Moments],
    (end, labels): (&[Moments], &[i64]),
) {
    let folder = Folder::new();
    let flat = Data::new(data.ncols(), data.iter().copied().collect()).unwrap();
    let costs = Gaussian::new(&flat).unwrap().costs::<M>(start);
    folder.array("data.npy", data);
    folder.array("costs.npy", &Array2::from_shape_fn((costs.len(), M), |(k, p)| costs[k].0[p]));
    write_npy(folder.path("weights.npy"), &Array1::from(weights.to_vec())).unwrap();
    write_npy(folder.path("labels.npy"), &Array1::from(labels.to_vec())).unwrap();
    for (name, mu) in [("start.json", start), ("end.json", end)] {
        folder.write(name, serde_json::to_string(mu).unwrap());
    }
    // scikit-learn has no floor, which therefore must not matter.
    for (p, mu) in end.iter().enumerate() {
        let thinnest = (0..data.ncols()).map(|i| mu.covariance[i][i]).fold(f64::INFINITY, f64::min);
        assert!(thinnest > 10.0 * FLOOR, "region {p}: {mu:?}");
        assert!(labels.contains(&(p as i64)), "region {p} is empty");
    }
    let printed = succeeded(reference(&["mixture", &folder.path("").display().to_string()]));
    let found: Value = serde_json::from_str(&printed).unwrap();
    for (name, most) in [("costs", 1e-12), ("means", 1e-12), ("covariances", 1e-12)] {
        assert!(found[name].as_f64().unwrap() <= most, "{name}: {printed}");
    }
    assert_eq!(found["labels"], 0, "{printed}");
}

#[test]
fn gaussian_regions_are_those_of_scikit_learn() {
    let mesh = uneven();
    let weights = Mass::Barycentric.weights(&mesh);
    let mut rng = Pcg64::seed_from_u64(97);
    for (d, initial) in [(1, Initial::KMeans), (2, Initial::Random), (5, Initial::KMeans)] {
        let data = clusters(weights.len(), d, &mut rng);
        let flat = Data::new(d, data.iter().copied().collect()).unwrap();
        let model = Gaussian::new(&flat).unwrap();
        let start = model.start(initial, M, &weights, &mut rng).unwrap();
        let (end, labels) = classified(&model, &weights, start.clone());
        assert_ne!(start, end);
        assert_same(&data, &weights, &start, (&end, &labels));
    }
}

/// `segment --lambda 0` ends at a fixed point: scikit-learn, started there, stays there.
#[test]
fn segment_without_cuts_ends_where_scikit_learn_stays() {
    let (folder, mesh) = (Folder::new(), uneven());
    meshseg::mesh::io::write(&folder.path("mesh.ply"), &mesh).unwrap();
    let mesh = meshseg::mesh::source(folder.path("mesh.ply")).unwrap();
    let data = clusters(mesh.vertices.len(), 2, &mut Pcg64::seed_from_u64(98));
    folder.array("data.npy", &data);
    folder.done(
        "segment mesh.ply --data data.npy --model gaussian --regions 3 --lambda 0 --no-preview --out run",
    );
    let answer = folder.answer("run");
    assert_eq!(answer.status(), "converged");
    assert!(answer.u.iter().all(|&u| u == 0.0 || u == 1.0), "labels are one-hot");
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    let mu: Vec<Moments> = regions
        .iter()
        .map(|region| Moments {
            mean: serde_json::from_value(region["mean"].clone()).unwrap(),
            covariance: serde_json::from_value(region["covariance"].clone()).unwrap(),
        })
        .collect();
    let labels: Vec<i64> = answer.labels.iter().map(|&label| label.into()).collect();
    assert_same(&data, &Mass::Barycentric.weights(&mesh), &mu, (&mu, &labels));
}
