//! What is believed of foreign iterates: only what certifies itself.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use ndarray::Array2;

use super::*;
use crate::mesh::Mesh;
use crate::operator::{Mass, Stencil};
use crate::problem::{Problem, Smoothing, SmoothingMode};
use crate::regions;
use crate::run::{Certificate, Status, Stop};
use crate::samples::{random_rows, rng, shape};
use crate::solve::{Request, Solution};
use crate::solver::Options;
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

/// One iterate, scored, by a solver that ended so.
fn scored(problem: &Exchanged, iterate: Iterate, status: Status, gap: f64) -> Solution {
    let request = Request {
        lambda: LAMBDA,
        mass: Mass::Barycentric,
        solver: "foreign".into(),
        options: Options::default(),
        stop: Stop { relative_gap: Some(gap), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
    };
    let iterates = Iterates { all: vec![iterate], broken: None };
    let end = End { status, warnings: Vec::new() };
    certify(problem, &iterates, 10, &request, end, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A field or a smoothing that is no number is as good as none, and the next best certificate takes its place.
#[test]
fn what_is_no_number_certifies_nothing() {
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
fn a_failure_is_no_convergence() {
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

/// The energy is that of the integrated costs which were given out.
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

/// An eps is that of the paper, unless another mode is named.
#[test]
fn an_epsilon_is_as_the_paper_has_it() {
    let folder = tempfile::tempdir().unwrap();
    for n in 0..3 {
        array(folder.path(), &format!("u_{n}.npy"), &Array2::zeros((2, 2)));
    }
    let trace = "iteration,seconds,epsilon,epsilon_mode\n0,0,0.25,\n1,1,0.25,intrinsic\n2,2,,\n";
    fs::write(folder.path().join("trace.csv"), trace).unwrap();
    let iterates = Iterates::of(folder.path());
    assert!(iterates.broken.is_none(), "{:?}", iterates.broken);
    let found: Vec<_> = iterates.all.iter().map(|iterate| iterate.smoothing).collect();
    let of = |mode| Some(Smoothing { mode, epsilon: 0.25 });
    assert_eq!(found, [of(SmoothingMode::Paper), of(SmoothingMode::Intrinsic), None]);
}
