//! Energies and bounds bracket the known optimum at every sample, and exact methods reach the requested gap.

use super::{EXPANSIONS, all_variants, exact, run, solver, uniform, variants_of};
use crate::mesh::Mesh;
use crate::relaxation::Relaxation;
use crate::run::Status;
use crate::samples::{
    Known, bumpy, disjoint, flipped, known_optimum, known_optimum_in, needles, non_manifold, shape,
};
use crate::solver::{Method, Options, Setup};
use strum::IntoEnumIterator;

fn meshes() -> Vec<(&'static str, Mesh)> {
    let sphere = shape("sphere:2");
    vec![
        ("torus", shape("torus:12x8")),
        ("bumpy", bumpy(8)),
        ("components", disjoint([shape("sphere:1"), shape("grid:4x4").scaled(0.1)])),
        ("flipped", flipped(sphere)),
        ("non-manifold", non_manifold()),
        ("needles", needles(4, 1e-4)),
    ]
}

/// D <= E* <= E at every sample of every solver, whether it converges or not.
fn assert_bracketed<const M: usize>(mesh: &Mesh, name: &str, m: usize, cost: f64, iterations: u64) {
    let lambda = 0.1 * cost * mesh.area().sqrt();
    assert_known_bracketed(
        mesh,
        name,
        m,
        known_optimum::<M>(mesh, m, lambda, cost, 61),
        iterations,
    );
}

fn assert_known_bracketed<const M: usize>(
    mesh: &Mesh,
    name: &str,
    m: usize,
    known: Known<M>,
    iterations: u64,
) {
    let slack = 1e-12 * known.problem.spread();
    let optimum = known.problem.baseline + known.energy;
    for variant in all_variants() {
        let start = uniform(mesh.vertices.len(), m);
        let mut solver = solver(variant, mesh, &known.problem, start);
        let (run, status) = run(&mut *solver, &known.problem, 0.0, iterations);
        assert_ne!(status, Status::Diverged, "{name}, {variant:?}");
        for sample in &run.trace {
            assert!(sample.dual_bound <= optimum + slack, "{name}, {variant:?}: {sample:?}");
            assert!(sample.energy >= optimum - slack, "{name}, {variant:?}: {sample:?}");
            let empty = run.best_u().iter().all(|row| row.0[m..].iter().all(|&u| u == 0.0));
            assert!(empty, "{name}, {variant:?}");
        }
        let (first, last) = (run.trace[0], run.trace[run.trace.len() - 1]);
        // Expansions may find no better labels than those of the start.
        assert!(
            last.gap < first.gap || EXPANSIONS.contains(&variant),
            "{name}, {variant:?}: {first:?} {last:?}"
        );
    }
}

#[test]
fn every_solver_brackets_the_optimum() {
    for (name, mesh) in meshes() {
        assert_bracketed::<2>(&mesh, name, 2, 1.0, 200);
        assert_bracketed::<3>(&mesh, name, 3, 1.0, 200);
        assert_bracketed::<7>(&mesh, name, 7, 1.0, 100);
        assert_bracketed::<12>(&mesh, name, 9, 1.0, 100);
    }
}

#[test]
fn every_solver_brackets_the_optimum_at_any_scale() {
    for (length, cost) in [(1e-4, 1.0), (1e4, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e4, 1e4)] {
        assert_bracketed::<5>(&bumpy(7).scaled(length), "scaled", 5, cost, 150);
        assert_bracketed::<12>(&shape("sphere:1").scaled(length), "scaled", 10, cost, 150);
    }
}

/// The exact methods reach E* with a certified gap of 1e-6, in each of their variants.
#[test]
fn exact_methods_reach_the_optimum() {
    for (name, mesh) in meshes() {
        for scale in [1.0, 1e-4, 1e4] {
            let mesh = mesh.clone().scaled(scale);
            assert_reached::<2>(&mesh, name, 2);
            assert_reached::<3>(&mesh, name, 3);
            assert_reached::<5>(&mesh, name, 5);
            assert_reached::<7>(&mesh, name, 7);
            assert_reached::<12>(&mesh, name, 9);
        }
    }
}

/// Both in all relaxations, whose optima are known as well.
#[test]
fn every_relaxation_has_its_optimum() {
    for (name, mesh) in meshes() {
        for relaxation in Relaxation::iter() {
            let size = mesh.area().sqrt();
            let known = |lambda: f64, seed| {
                known_optimum_in::<7>(relaxation, &mesh, 6, lambda * size, 1.0, seed)
            };
            assert_known_bracketed(&mesh, name, 6, known(0.1, 63), 60);
            assert_known_reached(&mesh, name, 6, known(0.05, 64));
        }
    }
}

/// The fused engine has no relaxation `envelope`, and says what to do; other settings compute it by rows.
#[test]
fn the_fused_engine_refuses_the_envelope() {
    let mesh = shape("torus:12x8");
    let known = known_optimum_in::<3>(Relaxation::Envelope, &mesh, 3, 0.02, 1.0, 65);
    for (options, advice) in [
        (&["engine=fused"] as &[&str], "engine=auto"),
        (&["engine=fused", "precision=f32"], "engine=auto"),
        (&["precision=f32"], "precision=f64"),
    ] {
        let method = Method::parse("chambolle-pock", &Options::parse(options).unwrap()).unwrap();
        let setup = Setup {
            domain: (&mesh).into(),
            problem: &known.problem,
            start: known.u.clone(),
            dual_start: None,
        };
        let Err(error) = method.build(setup) else { panic!("{options:?} is built") };
        let message = error.to_string();
        assert!(message.contains("envelope") && message.contains(advice), "{message}");
    }
}

fn assert_reached<const M: usize>(mesh: &Mesh, name: &str, m: usize) {
    let known = known_optimum::<M>(mesh, m, 0.05 * mesh.area().sqrt(), 1.0, 62);
    assert_known_reached(mesh, name, m, known);
}

fn assert_known_reached<const M: usize>(mesh: &Mesh, name: &str, m: usize, known: Known<M>) {
    for variant in exact() {
        let start = uniform(mesh.vertices.len(), m);
        let mut solver = solver(variant, mesh, &known.problem, start);
        let (run, status) = run(&mut *solver, &known.problem, 1e-6, 100_000);
        assert_eq!(
            status,
            Status::Converged,
            "{name}, {variant:?}, m = {m}: {:?}",
            run.trace.last()
        );
        let error = run.energy() - known.energy;
        assert!(error <= 1.1e-6 * known.energy.abs(), "{name}, {variant:?}: {error}");
    }
}

/// The accelerated smoothed method ends at E_eps*, whose energy exceeds E* by at most the bias of the smoothing.
#[test]
fn smoothed_methods_end_within_their_bias() {
    let mesh = bumpy(8);
    let known = known_optimum::<3>(&mesh, 3, 0.05, 1.0, 63);
    for variant in variants_of("fista") {
        let mut solver = solver(variant, &mesh, &known.problem, uniform(mesh.vertices.len(), 3));
        let (run, _) = run(&mut *solver, &known.problem, 0.0, 20_000);
        let smoothing = solver.smoothing().unwrap();
        let bias: f64 = (0..mesh.faces.len())
            .map(|j| known.problem.lambda * smoothing.radius(mesh.face_area(j)))
            .sum();
        let error = run.energy() - known.energy;
        assert!(error <= 1.01 * bias, "{variant:?}: {error} {bias}");
        assert!(known.energy - run.bound() <= 1.01 * bias, "{variant:?}");
    }
}
