//! Labels of faces: energies by another formula, optima by enumeration, certificates of every solver.

use std::f64::consts::SQRT_2;

use ndarray::Array2;
use rand::RngExt;
use strum::IntoEnumIterator;

use super::{go, random_costs, request};
use crate::domain::Domain;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::dual::Dual;
use crate::operator::{Adjoint, Operator, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::relaxation::{LabelMetric, Relaxation};
use crate::request::Request;
use crate::rounding::{Rounding, round};
use crate::run::{Status, Stop};
use crate::samples::{
    assert_within, bumpy, non_manifold, random_rows, random_tangents, rng, shape, shuffled, zoo,
};
use crate::seeds::Seeds;
use crate::solve::{Solution, solve_on_faces};
use crate::solver::{Method, Options};
use crate::start::Start;
use crate::sweep::with_threads;

fn solved(mesh: &Mesh, s: &Array2<f64>, request: &Request) -> Solution {
    solve_on_faces(mesh, None, s, &Seeds::default(), &Start::Argmin, request, &mut go).unwrap()
}

/// sum_j A_j s_j,label + sqrt(2) lambda times the length of the edges between faces with different labels.
fn potts(mesh: &Mesh, s: &Array2<f64>, lambda: f64, labels: &[usize]) -> f64 {
    let data: f64 = (0..mesh.faces.len()).map(|j| mesh.face_area(j) * s[[j, labels[j]]]).sum();
    let dual = Dual::new(mesh);
    let differ = |&(&[j, k], _): &(&[u32; 2], &f64)| labels[j as usize] != labels[k as usize];
    let cut: f64 = dual.pairs.iter().zip(&dual.weights).filter(differ).map(|(_, w)| w).sum();
    data + SQRT_2 * lambda * cut
}

/// The smallest energy of all labelings.
fn least(mesh: &Mesh, s: &Array2<f64>, lambda: f64) -> f64 {
    let (n, m) = s.dim();
    let labeling =
        |code: usize| -> Vec<usize> { (0..n as u32).map(|j| code / m.pow(j) % m).collect() };
    (0..m.pow(n as u32))
        .map(|code| potts(mesh, s, lambda, &labeling(code)))
        .fold(f64::INFINITY, f64::min)
}

/// <K u, q> = <u, K^T q>, and K vanishes on constants.
#[test]
fn jumps_have_an_adjoint() {
    for (name, mesh) in zoo() {
        let k = Stencil::across_edges(&Dual::new(&mesh));
        let mut rng = rng(901);
        let u = random_rows::<3>(k.vertices(), &mut rng);
        let q = random_tangents::<3>(k.faces(), &mut rng);
        let product = |a: &Tangent<3>, b: &Tangent<3>| a.0[0].dot(b.0[0]) + a.0[1].dot(b.0[1]);
        let left: f64 = (0..k.faces()).map(|e| product(&k.at(&u, e), &q[e])).sum();
        let kt = k.adjoint();
        let right: f64 = (0..k.vertices()).map(|j| u[j].dot(kt.at(&q, j))).sum();
        assert_within(left, right, 1e-12, mesh.area().sqrt().max(left.abs()));
        let constant = vec![Row([0.2, 0.3, 0.5]); k.vertices()];
        assert!((0..k.faces()).all(|e| k.at(&constant, e) == Tangent::ZERO), "{name}");
    }
}

/// The energy of one-hot rows is that of the Potts model, in every relaxation.
#[test]
fn energies_are_lengths_of_edges() {
    for (name, mesh) in zoo() {
        let s = random_costs(mesh.faces.len(), 3, 902);
        let mut rng = rng(903);
        let labels: Vec<usize> = s.outer_iter().map(|_| rng.random_range(0..3)).collect();
        let expected = potts(&mesh, &s, 0.3, &labels);
        let dual = Dual::new(&mesh);
        let f: Vec<Row<3>> = (0..mesh.faces.len())
            .map(|j| Row::from_fn(|p| mesh.face_area(j) * s[[j, p]]))
            .collect();
        for relaxation in Relaxation::iter() {
            let problem = Problem::<_, 3>::new(Stencil::across_edges(&dual), f.clone(), 0.3)
                .in_relaxation(relaxation);
            let u: Vec<Row<3>> = labels.iter().map(|&p| Row::one_hot(p)).collect();
            let energy = problem.baseline + problem.energy(&u);
            assert_within(energy, expected, 1e-9, expected);
            assert!(energy.is_finite(), "{name}");
        }
    }
}

/// Two classes: the relaxation is tight, and labels are the best of all.
#[test]
fn two_classes_have_no_gap() {
    for (mesh, seed) in [(bumpy(2), 1), (shape("sphere:0"), 2), (non_manifold(), 3)] {
        for lambda in [0.0, 0.03, 0.3] {
            let s = random_costs(mesh.faces.len(), 2, 910 + seed);
            let best = least(&mesh, &s, lambda);
            let solution = solved(&mesh, &s, &request(lambda, 1e-9));
            let summary = &solution.summary;
            assert_within(summary.energy, best, 1e-8, best);
            assert_within(summary.rounded_energy, best, 1e-12, best);
            let labels: Vec<usize> = solution.labels.iter().map(|&p| p as usize).collect();
            assert_within(potts(&mesh, &s, lambda, &labels), best, 1e-12, best);
        }
    }
}

/// Three classes: no bound is above the best labeling, and labels with a certified gap of 0 are the best.
#[test]
fn bounds_are_below_the_best_labeling() {
    for (mesh, seed) in [(bumpy(2), 1), (non_manifold(), 2)] {
        for lambda in [0.05, 0.2] {
            let s = random_costs(mesh.faces.len(), 3, 920 + seed);
            let best = least(&mesh, &s, lambda);
            for relaxation in Relaxation::iter() {
                let request =
                    Request { relaxation, label_gap: Some(1e-9), ..request(lambda, 1e-7) };
                let summary = solved(&mesh, &s, &request).summary;
                let bound = summary.rounding.as_ref().unwrap().label_bound;
                assert!(summary.dual_bound <= best + 1e-12 && bound <= best + 1e-12);
                assert!(summary.rounded_energy >= best - 1e-12);
                if summary.rounded_relative_gap <= 1e-9 {
                    assert_within(summary.rounded_energy, best, 1e-8, best);
                }
            }
        }
    }
}

/// The same for a metric on the labels, in which cuts weigh differently; where labels are on a line, there is no gap.
#[test]
fn bounds_of_metrics_are_below_the_best_labeling() {
    const UNEVEN: [[f64; 3]; 3] = [[0.0, 0.4, 1.5], [0.4, 0.0, 1.2], [1.5, 1.2, 0.0]];
    const LINE: [[f64; 3]; 3] = [[0.0, 0.4, 1.5], [0.4, 0.0, 1.1], [1.5, 1.1, 0.0]];
    let of = |d: [[f64; 3]; 3]| {
        LabelMetric::new(&Array2::from_shape_fn((3, 3), |(a, b)| d[a][b])).unwrap()
    };
    let metric = of(UNEVEN);
    for (mesh, seed, d) in [
        (bumpy(2), 1, UNEVEN),
        (non_manifold(), 2, UNEVEN),
        (bumpy(2), 3, LINE),
        (non_manifold(), 4, LINE),
    ] {
        let dual = Dual::new(&mesh);
        for lambda in [0.0, 0.05, 0.2] {
            let (n, s) = (mesh.faces.len(), random_costs(mesh.faces.len(), 3, 920 + seed));
            let energy = |labels: &[usize]| -> f64 {
                let data: f64 = (0..n).map(|j| mesh.face_area(j) * s[[j, labels[j]]]).sum();
                let pairs = dual.pairs.iter().zip(&dual.weights);
                let cut = pairs.map(|([j, k], w)| w * d[labels[*j as usize]][labels[*k as usize]]);
                data + SQRT_2 * lambda * cut.sum::<f64>()
            };
            let labeling = |code: usize| -> Vec<usize> {
                (0..n as u32).map(|j| code / 3_usize.pow(j) % 3).collect()
            };
            let all = (0..3_usize.pow(n as u32)).map(|code| energy(&labeling(code)));
            let best = all.fold(f64::INFINITY, f64::min);
            let request =
                Request { relaxation: Relaxation::Metric(of(d)), ..request(lambda, 1e-8) };
            for method in Method::all() {
                let stop = Stop { iterations: Some(400), ..request.stop };
                let solution =
                    solved(&mesh, &s, &Request { method: method.clone(), stop, ..request.clone() });
                let summary = &solution.summary;
                assert!(summary.dual_bound <= best + 1e-12, "{}", method.name());
                assert!(summary.rounded_energy >= best - 1e-12, "{}", method.name());
                let labels: Vec<usize> = solution.labels.iter().map(|&p| p as usize).collect();
                assert_within(energy(&labels), summary.rounded_energy, 1e-12, best);
                assert_ne!(summary.status, Status::Contradicted, "{}", method.name());
            }
            let summary = solved(&mesh, &s, &request).summary;
            assert_eq!(summary.status, Status::Converged);
            if summary.rounded_relative_gap <= 1e-7 {
                assert_within(summary.rounded_energy, best, 1e-9, best);
            }
            if d == LINE {
                assert_within(summary.energy, best, 1e-7, best);
            }
            assert_eq!(summary.label_metric.unwrap()[2], d[2]);
        }
    }
    let s = random_costs(bumpy(2).faces.len(), 4, 1);
    let request = Request { relaxation: Relaxation::Metric(metric), ..request(0.1, 1e-3) };
    let refused = |s: &Array2<f64>, request: &Request| {
        let (seeds, mesh) = (Seeds::default(), bumpy(2));
        let found = solve_on_faces(&mesh, None, s, &seeds, &Start::Argmin, request, &mut go);
        found.err().unwrap().to_string()
    };
    assert!(refused(&s, &request).contains("3 labels, but there are 4"));
    let with_gap = Request { label_gap: Some(1e-3), ..request };
    assert!(refused(&s, &with_gap).contains("leave the label gap out"));
}

/// Every method has energies above, and bounds below, those of the default one, and those that converge reach its gap.
#[test]
fn all_methods_solve_on_faces() {
    let mesh = shape("torus:14x10");
    let s = random_costs(mesh.faces.len(), 4, 930);
    let lambda = 0.02;
    let reference = solved(&mesh, &s, &request(lambda, 1e-6)).summary;
    for method in Method::all() {
        for relaxation in [Relaxation::Frobenius, Relaxation::Separate] {
            let exact = solved(&mesh, &s, &Request { relaxation, ..request(lambda, 1e-6) }).summary;
            let request = Request {
                method: method.clone(),
                relaxation,
                stop: Stop { iterations: Some(300), relative_gap: Some(1e-4), ..Stop::default() },
                ..request(lambda, 1e-4)
            };
            let found = solved(&mesh, &s, &request).summary;
            let name = method.name();
            assert!(found.energy >= exact.dual_bound - 1e-12, "{name}");
            assert!(found.dual_bound <= exact.energy + 1e-12, "{name}");
            assert!(found.rounded_energy >= reference.dual_bound - 1e-12, "{name}");
            assert_ne!(found.status, Status::Contradicted, "{name}");
            assert_ne!(found.status, Status::Diverged, "{name}");
        }
    }
}

/// Both engines make the same steps on faces.
#[test]
fn the_engines_agree_on_faces() {
    let mesh = shape("torus:40x30");
    let s = random_costs(mesh.faces.len(), 4, 940);
    for relaxation in [Relaxation::Frobenius, Relaxation::Separate] {
        let with = |engine: &str| {
            let options = Options::parse(&[format!("engine={engine}")]).unwrap();
            let method = Method::parse("chambolle-pock", &options).unwrap();
            let stop = Stop { iterations: Some(60), ..Stop::default() };
            let request = Request { method, relaxation, stop, ..request(0.02, 0.0) };
            solved(&mesh, &s, &request)
        };
        let (fused, rows) = (with("fused"), with("rows"));
        let difference = (&fused.u - &rows.u).mapv(f64::abs);
        assert!(difference.iter().all(|&x| x <= 1e-9));
        assert_within(fused.summary.dual_bound, rows.summary.dual_bound, 1e-9, rows.summary.energy);
    }
}

/// The numbering does not matter, nor does the number of threads.
#[test]
fn a_shuffled_mesh_has_the_same_labels_of_faces() {
    let mesh = shape("torus:50x40");
    let s = random_costs(mesh.faces.len(), 2, 950);
    let tidy = solved(&mesh, &s, &request(0.01, 1e-6));
    let (moved, before) = shuffled(&mesh, &mut rng(951));
    // The face of the tidy mesh that each face is.
    let sorted = |face: [u32; 3]| {
        let mut face = face;
        face.sort_unstable();
        face
    };
    let index: std::collections::HashMap<[u32; 3], usize> =
        mesh.faces.iter().enumerate().map(|(j, &face)| (sorted(face), j)).collect();
    let of: Vec<usize> =
        moved.faces.iter().map(|face| index[&sorted(face.map(|v| before[v as usize]))]).collect();
    let costs = s.select(ndarray::Axis(0), &of);
    let runs = [1, 3].map(|threads| {
        with_threads(Some(threads), || solved(&moved, &costs, &request(0.01, 1e-6))).unwrap()
    });
    assert_eq!(runs[0].u, runs[1].u);
    assert_eq!(runs[0].labels, runs[1].labels);
    let energy = tidy.summary.rounded_energy;
    assert_within(runs[0].summary.rounded_energy, energy, 1e-12, energy);
    for (j, &tidy_index) in of.iter().enumerate() {
        assert_eq!(runs[0].labels[j], tidy.labels[tidy_index]);
    }
}

/// Every kind of mesh: feasible U, a bound below the energy, labels of all faces.
#[test]
fn every_mesh_has_labels_of_its_faces() {
    for (name, mesh) in zoo() {
        if mesh.area() < 1e-200 {
            continue;
        }
        let s = random_costs(mesh.faces.len(), 3, 960);
        let lambda = 0.1 * mesh.area().sqrt();
        let solution = solved(&mesh, &s, &request(lambda, 1e-3));
        let summary = &solution.summary;
        assert_eq!(solution.labels.len(), mesh.faces.len(), "{name}");
        assert_eq!(solution.u.dim(), (mesh.faces.len(), 3), "{name}");
        assert_eq!((summary.vertices, summary.faces), (mesh.vertices.len(), mesh.faces.len()));
        assert!(summary.dual_bound <= summary.energy && summary.gap >= 0.0, "{name}");
        assert_ne!(summary.status, Status::Contradicted, "{name}");
        assert!(summary.rounded_energy >= summary.dual_bound, "{name}");
    }
}

/// Seeds hold, and unknown faces take the labels of their neighbors.
#[test]
fn seeds_and_unknown_faces() {
    let mesh = shape("grid:8x8");
    let n = mesh.faces.len();
    let mut s = Array2::from_elem((n, 2), f64::NAN);
    s.row_mut(0).assign(&ndarray::array![0.0, 1.0]);
    let mut seeds = vec![None; n];
    seeds[n - 1] = Some(1);
    let seeds = Seeds::new(seeds);
    let request = request(1e-4, 1e-6);
    let solution =
        solve_on_faces(&mesh, None, &s, &seeds, &Start::Argmin, &request, &mut go).unwrap();
    assert_eq!((solution.labels[0], solution.labels[n - 1]), (0, 1));
    assert!(solution.summary.warnings.iter().any(|line| line.contains("unknown")));
    // Every labeling with a shortest cut around one corner is optimal; the cut is two edges or fewer.
    assert!(solution.summary.rounded_energy <= SQRT_2 * 1e-4 * 2.0 * SQRT_2 / 8.0 + 1e-12);
    let alone = solved(&mesh, &s, &request);
    assert!(alone.labels.iter().all(|&p| p == 0));
}

#[test]
fn what_faces_do_not_have_is_refused() {
    let mesh = shape("grid:4x4");
    let s = random_costs(mesh.faces.len(), 2, 970);
    let message = |s: &Array2<f64>, request: &Request| {
        let found =
            solve_on_faces(&mesh, None, s, &Seeds::default(), &Start::Argmin, request, &mut go);
        found.err().unwrap().to_string()
    };
    let coarse = Request { coarse_to_fine: true, ..request(0.1, 1e-3) };
    assert!(message(&s, &coarse).contains("coarse to fine"));
    let dual = Request { keep_dual: true, ..request(0.1, 1e-3) };
    assert!(message(&s, &dual).contains("dual field"));
    let few = random_costs(3, 2, 971);
    assert!(message(&few, &request(0.1, 1e-3)).contains("3 rows, but the mesh has 32 faces"));
}

/// Rounding with padding regions on faces never uses them.
#[test]
fn rounding_lowers_the_energy_on_faces() {
    let mesh = shape("torus:12x9");
    let dual = Dual::new(&mesh);
    let mut rng = rng(980);
    let f = (0..mesh.faces.len())
        .map(|_| Row::from_fn(|p| if p < 3 { rng.random_range(0.0..1.0) } else { FORBIDDEN_COST }))
        .collect();
    let problem = Problem::<_, 4>::new(Stencil::across_edges(&dual), f, 0.5)
        .in_relaxation(Relaxation::Separate);
    let u: Vec<Row<4>> = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
    for rounding in Rounding::iter() {
        let found = round(Domain::Faces(&dual), &problem, 3, &u, rounding, &mut || true);
        let rows: Vec<Row<4>> = found.labels.iter().map(|&p| Row::one_hot(p.into())).collect();
        assert_within(found.energy, problem.energy(&rows), 1e-12, found.energy);
        assert!(found.energy <= found.argmax_energy && found.labels.iter().all(|&p| p < 3));
        assert_eq!(found.energy < found.argmax_energy, rounding != Rounding::Argmax);
    }
}
