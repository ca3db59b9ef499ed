//! Time to a certified gap: the time in the steps, as `seconds` in a summary, with evaluation off the clock.

use std::ops::ControlFlow;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion};
use meshseg::operator::{Mass, Stencil};
use meshseg::run::{Run, Status, Stop};
use meshseg::solve::{Request, solve};
use meshseg::solver::chambolle_pock::{self, Precision};
use meshseg::start::Start;
use meshseg::sweep::with_threads;
use ndarray::Array2;

use super::instance::{costs_as_numbered, mesh, problem, torus};
use super::steps::solver;

/// With this lambda, plain methods need hundreds of iterations.
const LARGE_LAMBDA: f64 = 0.02;

const VARIANTS: [(&str, &str); 4] = [
    ("chambolle-pock", "precision=f32"),
    ("chambolle-pock", "precision=f64"),
    ("chambolle-pock", "engine=rows"),
    ("douglas-rachford", ""),
];

pub fn solves(criterion: &mut Criterion) {
    let mesh = mesh();
    for lambda in [0.005, LARGE_LAMBDA] {
        let problem = problem::<_, 4>(&mesh, Stencil::new(&mesh), lambda);
        let mut group = criterion.benchmark_group(format!("solve, lambda = {lambda}"));
        group.sample_size(10).measurement_time(Duration::from_secs(2));
        for (name, option) in VARIANTS {
            for gap in [1e-3, 1e-4] {
                let once = || {
                    let mut solver = solver(name, option, &mesh, &problem);
                    let mut run = Run::new(solver.iterate().u);
                    let go = &mut |_: Option<&_>| ControlFlow::Continue(());
                    let status = run.advance(&mut *solver, &problem, &stop(gap), go);
                    assert_eq!(status, Status::Converged);
                    run.seconds()
                };
                timed(&mut group, format!("{name} {option} to {gap:e}, 2 threads"), once);
            }
        }
        if lambda == LARGE_LAMBDA {
            from_coarser(&mut group, lambda);
        }
        group.finish();
    }
}

/// Stops at a gap, with the evaluations at the program's default iterations.
fn stop(gap: f64) -> Stop {
    Stop { relative_gap: Some(gap), ..Stop::default() }
}

/// From the solution on a coarser mesh; the time includes that solution and the coarse meshes.
fn from_coarser(group: &mut BenchmarkGroup<'_, WallTime>, lambda: f64) {
    let torus = torus();
    let rows = costs_as_numbered::<4>();
    let s = Array2::from_shape_fn((rows.len(), 4), |(v, p)| rows[v].0[p]);
    for (name, precision) in
        [("precision=f32", Precision::Single), ("precision=f64", Precision::Double)]
    {
        for gap in [1e-3, 1e-4] {
            let request = Request {
                lambda,
                relaxation: Default::default(),
                mass: Mass::Barycentric,
                method: chambolle_pock::Settings { precision, ..Default::default() }.into(),
                stop: stop(gap),
                coarse_to_fine: true,
                keep_dual: false,
                rounding: Default::default(),
                label_gap: None,
            };
            let once = || {
                let go = &mut |_: Option<&_>| ControlFlow::Continue(());
                let solution =
                    solve(&torus, &s, &Start::Argmin, &request, go).expect("the costs fit");
                assert_eq!(solution.summary.status, Status::Converged);
                solution.summary.seconds
            };
            let id = format!("chambolle-pock {name} from coarser meshes to {gap:e}, 2 threads");
            timed(group, id, once);
        }
    }
}

/// Records the seconds that `once` returns.
fn timed(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: String,
    once: impl Fn() -> f64 + Sync + Send,
) {
    group.bench_function(id, |b| {
        b.iter_custom(|n| {
            with_threads(Some(2), || (0..n).map(|_| Duration::from_secs_f64(once())).sum())
                .expect("the threads start")
        });
    });
}
