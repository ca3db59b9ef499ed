//! The numbers of figures and tables, computed by hand for runs with round numbers.
//!
//! B = 10 and, of all runs, E* = 12 and D* = 11.9, so that E* - B = 2.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::super::super::figures::{Clock, Target};
use super::super::super::numbers::Numbers;
use super::super::super::plan::run_toml;
use super::super::super::results::{Done, Point};
use super::super::super::spec::Spec;
use super::super::cell_value::{CellValue, value_of};
use super::super::pool::Pool;
use super::super::table::{TableEntry, table};

const FILE: &str = r#"# What do the numbers say?
repetitions = 3
stop = { gap = 1e-3 }

[[instance]]
mesh = "torus:20x12"
data = "waves"
regions = 2
lambda = 0.01

[[solver]]
name = "chambolle-pock"

[[solver]]
name = "fista"
options = { epsilon = [1e-4, 1e-2] }

[[table]]
name = "optimum"
kind = "time-to-gap"
gaps = [0.31, 1e-3]
to = "optimum"
"#;

fn spec() -> Spec {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("numbers.toml");
    std::fs::write(&path, FILE).unwrap();
    Spec::open(&path).unwrap()
}

fn manifest(repetition: u64, host: &str, start: &str) -> Value {
    json!({
        "id": start, "experiment": "numbers", "instance": "i", "instance_id": "i", "solver": "s",
        "repetition": repetition,
        "program": {"version": "", "commit": "", "dirty": false, "lock": "", "rustc": "", "target": "",
            "target_features": ""},
        "machine": {"cpu": "", "cores": 1, "memory_gib": 1.0, "host": host, "vectors": ""},
        "threads": 1, "load_average": 0.0, "others": 0.0, "loaded": false, "seed": 0, "generator": "",
        "start": start, "end": start, "mislabeled": 0.125, "wall_seconds": 1.0, "exit": ""
    })
}

/// A run whose samples are (iteration, energy, bound), with further results of the last one.
fn done(
    spec: &Spec,
    solver: usize,
    repetition: u64,
    (host, start): (&str, &str),
    samples: &[(u64, f64, f64)],
    (smoothed, rounded, labels): (Option<f64>, f64, Option<Vec<u8>>),
) -> Done {
    let toml = run_toml(spec, &spec.instances[0], &spec.solvers[solver]);
    let point = |&(iteration, energy, dual_bound): &(u64, f64, f64)| Point {
        iteration,
        seconds: 0.01 * (iteration * (repetition + 1)) as f64,
        energy,
        relative_gap: Some((energy - dual_bound) / (energy - 10.0)),
        smoothed_energy: smoothed,
        distance: None,
        mislabeled: None,
        silhouette_iou: None,
    };
    let trace: Vec<Point> = samples.iter().map(point).collect();
    let last = trace[trace.len() - 1];
    let (_, energy, dual_bound) = samples[samples.len() - 1];
    let summary = json!({
        "solver": "s", "solver_options": {}, "status": "converged", "status_sentence": "", "iterations": last.iteration, "seconds": last.seconds,
        "energy": last.energy, "dual_bound": dual_bound, "baseline": 10.0,
        "gap": energy - dual_bound, "relative_gap": last.relative_gap, "rounded_energy": rounded, "rounded_relative_gap": 0.5,
        "vertices": 240, "faces": 480, "regions": 2, "empty_regions": [1], "lambda": 0.0125,
        "mass": "barycentric", "area": 1.0, "coarse_to_fine": null, "warnings": []
    });
    Done {
        folder: PathBuf::new(),
        spec: toml.parse().unwrap(),
        manifest: serde_json::from_value(manifest(repetition, host, start)).unwrap(),
        summary: Numbers::Labels(serde_json::from_value(summary).unwrap()),
        trace,
        labels,
        certainty: None,
        frames: Vec::new(),
    }
}

/// Runs in the order in which they were made. The first one is outdated: the same run was made again.
fn runs(spec: &Spec) -> Vec<Done> {
    let exact =
        |later: u64| [(10 + later, 14.0, 11.0), (20 + later, 12.5, 11.5), (40 + later, 12.0, 11.9)];
    let labels = |labels: [u8; 4]| Some(labels.to_vec());
    vec![
        done(spec, 0, 0, ("a", "2026-01"), &[(1, 11.99, 11.98)], (None, 11.99, None)),
        done(spec, 0, 0, ("a", "2026-02"), &exact(0), (None, 12.1, labels([0, 1, 1, 0]))),
        done(spec, 0, 1, ("a", "2026-03"), &exact(10), (None, 12.1, None)),
        done(spec, 0, 2, ("b", "2026-04"), &exact(20), (None, 12.1, None)),
        done(
            spec,
            1,
            0,
            ("a", "2026-05"),
            &[(9, 12.5, 11.0)],
            (Some(12.6), 12.8, labels([0, 1, 0, 0])),
        ),
        done(spec, 1, 1, ("a", "2026-06"), &[(9, 12.5, 11.0)], (Some(12.8), 12.8, None)),
        done(spec, 2, 0, ("a", "2026-07"), &[(9, 13.0, 10.5)], (Some(13.9), 13.0, None)),
    ]
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12, "{a} {b}");
}

#[test]
fn every_run_is_measured_by_the_best_of_all_solvers() {
    let spec = spec();
    let done = runs(&spec);
    let pool = Pool::of(&spec, &done);
    assert_eq!(pool.runs().count(), 6);
    let peers = pool.peers(&pool.cells[0]);
    near(peers.bound(), 11.9);
    near(peers.energy(), 12.0);
    near(peers.share(0.5), 0.25);
    near(peers.suboptimality(12.5), 0.3);
    assert_eq!(peers.share(0.0), 0.0);
}

/// The first sample at or below a gap; medians over the repetitions, for times only those of one host.
#[test]
fn times_to_a_gap_are_those_of_the_first_sample() {
    let spec = spec();
    let done = runs(&spec);
    let pool = Pool::of(&spec, &done);
    let median =
        |clock, gap, target| pool.time_to(&pool.cells[0], clock, gap, target).unwrap().median;
    // The gaps are 3/4, 2/5 and 1/20; relative to E* - B the excess over D* is 1.05, 0.3 and 0.05.
    near(median(Clock::Iterations, 0.4, Target::Certificate), 30.0);
    near(median(Clock::Iterations, 0.31, Target::Certificate), 50.0);
    near(median(Clock::Iterations, 0.31, Target::Optimum), 30.0);
    near(median(Clock::Seconds, 0.4, Target::Certificate), 0.5 * (0.2 + 0.6));
    assert_eq!(median(Clock::Iterations, 1e-9, Target::Optimum), f64::INFINITY);
    let seconds: Vec<f64> = pool.trace(&pool.cells[0], true).iter().map(|p| p.seconds).collect();
    let expected = [0.5 * (0.1 + 0.4), 0.5 * (0.2 + 0.6), 0.5 * (0.4 + 1.0)];
    seconds.iter().zip(expected).for_each(|(&a, b)| near(a, b));

    let rows = table(&pool, &spec.tables[0]).rows;
    assert_eq!(rows[0][2], TableEntry::Number(30.0));
    assert!(
        matches!(rows[0][4], TableEntry::Number(x) if (x - 0.4).abs() < 1e-12),
        "{:?}",
        rows[0][4]
    );
    // The distance to the optimum, not the certified gap.
    assert_eq!(rows[1][3], TableEntry::Censored("> 9 (3e-1)".into()));
}

/// E_eps is only compared with that of the same eps.
#[test]
fn quantities_agree_with_their_definitions() {
    let spec = spec();
    let done = runs(&spec);
    let pool = Pool::of(&spec, &done);
    let of_cell = |solver: usize, name: &str| {
        value_of(&pool, &pool.cells[solver], &name.parse().unwrap(), None)
    };
    let value = |solver: usize, name: &str| match of_cell(solver, name) {
        CellValue::Number(spread) => spread.median,
        other => panic!("{name}: {other:?}"),
    };
    near(value(0, "excess"), 0.05);
    near(value(1, "excess"), 0.3);
    near(value(1, "gap"), 0.6);
    near(value(1, "rounding-error"), 0.15);
    near(value(1, "bias"), 0.35);
    near(value(2, "bias"), 1.0);
    near(value(1, "optimization-error"), 0.05);
    near(value(2, "optimization-error"), 0.0);
    near(value(0, "optimization-error"), 0.05);
    near(value(1, "labels-changed"), 0.25);
    near(value(1, "rounded-gap"), 0.5);
    near(value(1, "label-excess"), 0.9 / 1.9);
    near(value(1, "regions-used"), 1.0);
    near(value(1, "mislabeled"), 0.125);
    // The lambda that the run used, not the one in its file.
    near(value(1, "lambda"), 0.0125);
    assert_eq!(of_cell(2, "labels-changed"), CellValue::Nothing);
}
