//! Iterates of external solvers: only certified values count.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use ndarray::Array2;
use rand::RngExt;
use strum::IntoEnumIterator;

use super::*;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::mesh::dual::Dual;
use crate::names::Named;
use crate::operator::{Mass, Matrix, Stencil};
use crate::problem::{Problem, Smoothing, SmoothingMode};
use crate::regions;
use crate::relaxation::{LabelMetric, Relaxation};
use crate::run::{Certificate, Status, Stop};
use crate::samples::{random_rows, rng, shape};
use crate::seeds::Seeds;
use crate::solve::{Request, Solution, solve_on_faces};
use crate::solver::Method;
use crate::start::Start;

const LAMBDA: f64 = 0.02;

fn exchanged(mesh: &Mesh) -> Exchanged {
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(881)), 3);
    Exchanged::new(mesh, &s, LAMBDA, Mass::Barycentric, &Start::Argmin).unwrap()
}

fn array(folder: &Path, name: &str, array: &Array2<f64>) -> PathBuf {
    let path = folder.join(name);
    crate::npy::write(&path, array).unwrap();
    path
}

fn request(gap: f64) -> Request {
    Request {
        lambda: LAMBDA,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        stop: Stop { relative_gap: Some(gap), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    }
}

fn ended(status: Status) -> End {
    let (solver, options) = ("foreign".to_owned(), BTreeMap::new());
    End { solver, options, status, warnings: Vec::new() }
}

/// One certified iterate of a solver that ended with the status.
fn scored(problem: &Exchanged, iterate: Iterate, status: Status, gap: f64) -> Solution {
    let iterates = Iterates { all: vec![iterate], broken: None };
    let mut go = |_: Option<&_>| ControlFlow::Continue(());
    certify(problem, &iterates, 10, &request(gap), ended(status), &mut go).unwrap()
}

fn iterate(iteration: u64, u: &Path) -> Iterate {
    Iterate { iteration, seconds: 0.0, smoothing: None, u: u.to_owned(), q: None }
}

/// A field or a smoothing that is not finite is ignored, and the next best certificate takes its place.
#[test]
fn values_that_are_not_finite_certify_nothing() {
    let mesh = shape("torus:12x8");
    let problem = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let (n, faces) = (mesh.vertices.len(), mesh.faces.len());
    let u = array(folder.path(), "u.npy", &Array2::from_elem((n, 3), 1.0 / 3.0));
    let mut q = Array2::zeros((2 * faces, 3));
    q[[5, 1]] = f64::NAN;
    let q = array(folder.path(), "q.npy", &q);
    let smoothing = |epsilon| Smoothing::new(SmoothingMode::Paper, epsilon).unwrap();
    // The square root of the second, halved and squared, is zero, and U is constant.
    for (smoothing, certificate) in [
        (Some(smoothing(1e-3)), Certificate::Smoothed),
        (Some(smoothing(5e-324)), Certificate::Steps),
        (None, Certificate::Steps),
    ] {
        let (u, q) = (u.clone(), Some(q.clone()));
        let iterate = Iterate { iteration: 0, seconds: 0.0, smoothing, u, q };
        let solution = scored(&problem, iterate, Status::Ended, 1e-9);
        let sample = solution.trace[0];
        assert_eq!(sample.certificate, Some(certificate));
        assert!(solution.summary.dual_bound <= solution.summary.energy);
        assert_eq!(sample.smoothed_energy.is_some(), smoothing.is_some());
        if let (Some(smoothed), Some(smoothing)) = (sample.smoothed_energy, smoothing) {
            // A constant U attains the bias, lambda F sqrt(eps) / 2.
            let bias = LAMBDA * faces as f64 * smoothing.epsilon.sqrt() / 2.0;
            let excess = smoothed - solution.summary.energy;
            assert!((excess - bias).abs() <= 1e-12, "{excess} {bias}");
        }
    }
}

/// A solver that failed has not converged, whatever it reached before.
#[test]
fn a_failed_solver_has_not_converged() {
    let mesh = shape("torus:12x8");
    let problem = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let u = array(folder.path(), "u.npy", &Array2::from_elem((mesh.vertices.len(), 3), 1.0 / 3.0));
    for (end, status) in [
        (Status::Ended, Status::Converged),
        (Status::TimeLimit, Status::Converged),
        (Status::Failed, Status::Failed),
    ] {
        let iterate =
            Iterate { iteration: 0, seconds: 0.0, smoothing: None, u: u.clone(), q: None };
        assert_eq!(scored(&problem, iterate, end, 1e9).summary.status, status);
    }
}

/// The energy is that of the exported integrated costs.
#[test]
fn the_energy_is_that_of_the_problem() {
    let mesh = shape("torus:12x8");
    let exchanged = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let u = random_rows::<3>(mesh.vertices.len(), &mut rng(882));
    let u: Vec<_> = u.into_iter().map(crate::prox::project_simplex).collect();
    let path = array(folder.path(), "u.npy", &regions::array(&u, 3));
    let iterate = Iterate { iteration: 0, seconds: 0.0, smoothing: None, u: path, q: None };
    let summary = scored(&exchanged, iterate, Status::Ended, 1e-9).summary;
    let f = regions::rows::<3>(exchanged.f.view());
    let problem = Problem::new(Stencil::new(&exchanged.mesh), f, LAMBDA);
    let energy = problem.baseline + problem.energy(&u);
    assert!((summary.energy - energy).abs() <= 1e-12, "{} {energy}", summary.energy);
}

/// The mode of an eps is that of the paper unless another one is named.
#[test]
fn the_default_mode_of_epsilon_is_that_of_the_paper() {
    let folder = tempfile::tempdir().unwrap();
    for n in 0..4 {
        array(folder.path(), &format!("u_{n}.npy"), &Array2::zeros((2, 2)));
    }
    // Tables of floats contain NaN for missing values.
    let trace =
        "iteration,seconds,epsilon,epsilon_mode\n0,0,0.25,\n1,1,0.25,intrinsic\n2,2,,\n3,3,nan,\n";
    fs::write(folder.path().join("trace.csv"), trace).unwrap();
    let iterates = Iterates::of(folder.path());
    assert!(iterates.broken.is_none(), "{:?}", iterates.broken);
    let found: Vec<_> = iterates.all.iter().map(|iterate| iterate.smoothing).collect();
    let of = |mode| Some(Smoothing { mode, epsilon: 0.25 });
    assert_eq!(found, [of(SmoothingMode::Paper), of(SmoothingMode::Intrinsic), None, None]);
}

/// Powers of two far from 1 change the exponents of what is certified, and no bit else; a dual field is that of the
/// problem.
#[test]
fn problems_of_any_size_have_the_same_certificates() {
    let mesh = shape("torus:12x8");
    let problem = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let mut rng = rng(885);
    let u = random_rows::<3>(mesh.vertices.len(), &mut rng);
    let u: Vec<_> = u.into_iter().map(crate::prox::project_simplex).collect();
    let q = Array2::from_shape_fn((2 * mesh.faces.len(), 3), |_| rng.random_range(-1.0..1.0));
    let u = array(folder.path(), "u.npy", &regions::array(&u, 3));
    let certified = |factor: f64| {
        let scaled = Exchanged {
            f: problem.f.mapv(|f| factor * f),
            lambda: factor * problem.lambda,
            ..problem.clone()
        };
        let field = q.mapv(|q| 3.0 * factor * problem.lambda * q);
        let field = array(folder.path(), "q.npy", &field);
        let of = |iteration, q| Iterate { q, ..iterate(iteration, &u) };
        let iterates = Iterates { all: vec![of(0, None), of(1, Some(field))], broken: None };
        let mut go = |_: Option<&_>| ControlFlow::Continue(());
        certify(&scaled, &iterates, 10, &request(1e-9), ended(Status::Ended), &mut go).unwrap()
    };
    let expected = certified(1.0);
    assert!(expected.trace[1].dual_bound > expected.summary.baseline);
    for exponent in [-990, -540, 540, 900] {
        let factor = f64::from(exponent).exp2();
        let found = certified(factor);
        assert_eq!(found.u, expected.u);
        for (a, b) in found.trace.iter().zip(&expected.trace) {
            assert_eq!((a.energy, a.dual_bound), (factor * b.energy, factor * b.dual_bound));
        }
        let (a, b) = (found.summary, &expected.summary);
        assert_eq!((a.energy, a.lambda), (factor * b.energy, factor * b.lambda));
        assert_eq!((a.relative_gap, a.status), (b.relative_gap, b.status));
    }
}

/// A warning reports how far the worst iterate was off the simplex; there is none for rounding errors.
#[test]
fn a_warning_reports_the_row_farthest_from_the_simplex() {
    let mesh = shape("torus:12x8");
    let problem = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let warnings = |offs: [f64; 2]| {
        let iterates = (0..).zip(offs).map(|(n, off)| {
            let mut u = Array2::from_elem((mesh.vertices.len(), 3), 1.0 / 3.0);
            u[[40, 0]] += off;
            iterate(n, &array(folder.path(), &format!("u_{n}.npy"), &u))
        });
        let iterates = Iterates { all: iterates.collect(), broken: None };
        let mut go = |_: Option<&_>| ControlFlow::Continue(());
        let (request, end) = (request(1e-9), ended(Status::Ended));
        certify(&problem, &iterates, 10, &request, end, &mut go).unwrap().summary.warnings
    };
    // The excess of the row is subtracted equally from all three entries.
    let expected = ["rows of U were up to 1.0e-1 off the simplex and were projected onto it"];
    assert_eq!(warnings([0.3, 0.0]), expected);
    assert_eq!(warnings([0.0, 0.3]), expected);
    assert!(warnings([1e-7, 1e-9]).is_empty());
}

/// A solver without a start, or without any iterate, gets the start of the problem with a bound by steps of the default
/// solver; a break ends the certification.
#[test]
fn a_missing_start_is_replaced_by_that_of_the_problem() {
    let mesh = shape("torus:12x8");
    let problem = exchanged(&mesh);
    let folder = tempfile::tempdir().unwrap();
    let u = array(folder.path(), "u.npy", &Array2::from_elem((mesh.vertices.len(), 3), 1.0 / 3.0));
    let missing = folder.path().join("none.npy");
    let score = |all: Vec<Iterate>, flow: ControlFlow<()>| {
        let iterates = Iterates { all, broken: None };
        let (request, end) = (request(1e-9), ended(Status::Ended));
        // Steps for a bound are not part of the run, which a break would end.
        let mut observe = |sample: Option<&_>| match sample {
            Some(_) => flow,
            None => ControlFlow::Continue(()),
        };
        certify(&problem, &iterates, 10, &request, end, &mut observe).unwrap()
    };
    let go = ControlFlow::Continue(());
    let start = score(Vec::new(), go);
    assert_eq!((start.trace.len(), start.summary.status), (1, Status::Ended));
    let first = start.trace[0];
    assert!(first.dual_bound > start.summary.baseline + 0.1 * first.gap);
    let brought = |all: Vec<Iterate>, flow| {
        let Solution { trace, summary, .. } = score(all, flow);
        let iterations: Vec<u64> = trace.iter().map(|sample| sample.iteration).collect();
        (iterations, trace[0].energy, trace[0].dual_bound, summary.status)
    };
    let (energy, bound) = (first.energy, first.dual_bound);
    let all = || vec![iterate(3, &u), iterate(5, &u)];
    assert_eq!(brought(all(), go), (vec![0, 3, 5], energy, bound, Status::Ended));
    assert_eq!(
        brought(all(), ControlFlow::Break(())),
        (vec![0, 3], energy, bound, Status::Interrupted)
    );
    let unread = vec![iterate(0, &missing), iterate(5, &u)];
    assert_eq!(brought(unread, go), (vec![0], energy, bound, Status::Failed));
    let (iterations, own, _, _) = brought(vec![iterate(0, &u), iterate(5, &u)], go);
    assert!(iterations == [0, 5] && own != energy);
}

/// The archive has the relaxation, whose energies are certified; without it the relaxation is that of the paper, and an unknown
/// one is refused.
#[test]
fn the_relaxation_is_exchanged() {
    let mesh = shape("torus:12x8");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("problem.npz");
    let u = random_rows::<3>(mesh.vertices.len(), &mut rng(884));
    let u: Vec<_> = u.into_iter().map(crate::prox::project_simplex).collect();
    let rows = array(folder.path(), "u.npy", &regions::array(&u, 3));
    let metric = ndarray::arr2(&[[0.0, 1.0, 2.0], [1.0, 0.0, 1.5], [2.0, 1.5, 0.0]]);
    let metric = Relaxation::Metric(LabelMetric::new(&metric).unwrap());
    for relaxation in [metric].into_iter().chain(Relaxation::iter()) {
        exchanged(&mesh).in_relaxation(relaxation).write(&path).unwrap();
        let read = Exchanged::read(&path).unwrap();
        assert_eq!(read.relaxation, relaxation);
        let iterate =
            Iterate { iteration: 0, seconds: 0.0, smoothing: None, u: rows.clone(), q: None };
        let summary = scored(&read, iterate, Status::Ended, 1e-9).summary;
        let f = regions::rows::<3>(read.f.view());
        let problem = Problem::new(Stencil::new(&mesh), f, LAMBDA).in_relaxation(relaxation);
        let energy = problem.baseline + problem.energy(&u);
        assert!((summary.energy - energy).abs() <= 1e-12, "{} {energy}", summary.energy);
        assert_eq!(summary.relaxation.as_deref(), Some(relaxation.name()));
        assert!(summary.dual_bound <= summary.energy);
    }
    // Archives of earlier versions lack the entry.
    type Change<'a> = &'a dyn Fn(&str, Vec<u8>) -> Option<Vec<u8>>;
    let rewritten = |change: Change<'_>| {
        let mut zip = zip::ZipArchive::new(fs::File::open(&path).unwrap()).unwrap();
        let other = folder.path().join("other.npz");
        let mut out = zip::ZipWriter::new(fs::File::create(&other).unwrap());
        for i in 0..zip.len() {
            let mut entry = zip.by_index(i).unwrap();
            let name = entry.name().to_owned();
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            if let Some(bytes) = change(&name, bytes) {
                out.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
                out.write_all(&bytes).unwrap();
            }
        }
        out.finish().unwrap();
        Exchanged::read(&other)
    };
    let old = rewritten(&|name, bytes| (name != "relaxation.npy").then_some(bytes));
    assert_eq!(old.unwrap().relaxation, Relaxation::Frobenius);
    let unknown = rewritten(&|name, mut bytes| {
        if name == "relaxation.npy" {
            let first = bytes.len() - 9;
            bytes[first] = b'x';
        }
        Some(bytes)
    });
    let message = unknown.unwrap_err().to_string();
    assert!(message.contains("must be one of frobenius, separate, envelope"), "{message}");
}

#[test]
fn a_problem_out_of_range_is_refused() {
    let mut problem = exchanged(&shape("torus:12x8"));
    problem.f[[7, 1]] = 1e295;
    let mut go = |_: Option<&_>| ControlFlow::Continue(());
    let (iterates, end) = (Iterates::default(), ended(Status::Ended));
    let refused = certify(&problem, &iterates, 10, &request(1e-9), end, &mut go);
    let Err(error) = refused else { panic!("it passes") };
    assert!(error.to_string().contains("range of double precision"), "{error}");
}

/// Lines count up to the first invalid one, which has more or fewer fields than the header or an iteration out of
/// order; times may be equal. An incomplete line at the end is not an error, nor is a header alone.
#[test]
fn a_trace_counts_up_to_its_first_invalid_line() {
    let folder = tempfile::tempdir().unwrap();
    for n in 0..3 {
        array(folder.path(), &format!("u_{n}.npy"), &Array2::zeros((2, 2)));
    }
    let read = |trace: &str| {
        fs::write(folder.path().join("trace.csv"), trace).unwrap();
        let Iterates { all, broken } = Iterates::of(folder.path());
        let iterations: Vec<u64> = all.iter().map(|iterate| iterate.iteration).collect();
        (iterations, broken.map(|error| error.to_string()).unwrap_or_default())
    };
    let header = "iteration,seconds";
    let right = |iterations: &[u64]| (iterations.to_vec(), String::new());
    assert_eq!(read(&format!("{header}\n0,0\n1,1\n2,1\n")), right(&[0, 1, 2]));
    assert_eq!(read(&format!("{header}\n0,0\n1")), right(&[0]));
    assert_eq!([read("itera"), read(header)], [right(&[]), right(&[])]);
    for (line, why) in [
        ("1,1,1", "3 fields, but the header has 2"),
        ("1", "1 fields, but the header has 2"),
        ("0,1", "iterations must increase"),
        ("1,-1", "not a time in seconds"),
    ] {
        let (iterations, broken) = read(&format!("{header}\n0,0\n{line}\n2,2\n"));
        assert_eq!(iterations, [0]);
        assert!(broken.contains(why) && broken.contains("line 3"), "{broken}");
    }
}

/// A problem on faces is read as it was written, with a K whose jumps have the energy of the edges, and with the bound of
/// the solver for labels of faces. Pairs and weights that join nothing are refused.
#[test]
fn labels_of_faces_are_exchanged() {
    let mesh = shape("torus:12x8");
    let s = regions::array(&random_rows::<3>(mesh.faces.len(), &mut rng(885)), 3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("problem.npz");
    let contrast = Contrast::Faces((0..mesh.faces.len()).map(|j| 1.0 + (j % 3) as f64).collect());
    let mut go = |_: Option<&_>| ControlFlow::Continue(());
    for contrast in [None, Some(&contrast)] {
        let written = Exchanged::on_faces(&mesh, contrast, &s, LAMBDA, &Start::Argmin).unwrap();
        written.write(&path).unwrap();
        let read = Exchanged::read(&path).unwrap();
        let (dual, expected) = (read.dual.as_ref().unwrap(), written.dual.as_ref().unwrap());
        assert_eq!((&dual.pairs, &dual.weights), (&expected.pairs, &expected.weights));
        assert_eq!((&read.f, &read.u0, &dual.areas), (&written.f, &written.u0, &expected.areas));
        assert_eq!(read.relaxation, Relaxation::Separate);

        let request = Request { relaxation: Relaxation::Separate, ..request(1e-9) };
        let (start, seeds) = (Start::Argmin, Seeds::default());
        let ours = solve_on_faces(&mesh, contrast, &s, &seeds, &start, &request, &mut go).unwrap();
        let u = array(folder.path(), "u.npy", &ours.u);
        let iterates = Iterates { all: vec![iterate(0, &u)], broken: None };
        let end = ended(Status::Ended);
        let scored = certify(&read, &iterates, 1000, &request, end, &mut go).unwrap().summary;
        let (energy, size) = (ours.summary.energy, ours.summary.energy.abs());
        assert!((scored.energy - energy).abs() <= 1e-12 * size, "{} {energy}", scored.energy);
        let bound = scored.dual_bound;
        assert!(bound <= energy && bound >= energy - 1e-4 * size, "{bound} {energy}");

        // E by the matrix: rows 2e are the jumps, and rows 2e + 1 are empty.
        let k = Matrix::across_edges(dual);
        let jumps = k.csr() * &ours.u;
        assert!(jumps.outer_iter().skip(1).step_by(2).all(|row| row.iter().all(|&x| x == 0.0)));
        let length: f64 = jumps.iter().map(|x| x.abs()).sum();
        let data: f64 = (&read.f * &ours.u).sum();
        let by_hand = data + LAMBDA * std::f64::consts::FRAC_1_SQRT_2 * length;
        assert!((by_hand - energy).abs() <= 1e-12 * size, "{by_hand} {energy}");
    }
    let refused = |change: &dyn Fn(&mut Dual)| {
        let mut problem = Exchanged::on_faces(&mesh, None, &s, LAMBDA, &Start::Argmin).unwrap();
        change(problem.dual.as_mut().unwrap());
        problem.write(&path).unwrap();
        Exchanged::read(&path).unwrap_err().to_string()
    };
    assert!(refused(&|dual| dual.weights[3] = 0.0).contains("positive and finite"));
    assert!(refused(&|dual| dual.weights[3] = f64::NAN).contains("positive and finite"));
    assert!(refused(&|dual| dual.pairs[3] = [5, 5]).contains("two different indices"));
    let short = refused(&|dual| {
        dual.weights.pop();
    });
    assert!(short.contains("a row for each of the weights"), "{short}");
}
