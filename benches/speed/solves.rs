//! To a certified gap: the time in the steps, as `seconds` in a summary, evaluation off the clock.

use std::ops::ControlFlow;
use std::time::Duration;

use criterion::Criterion;
use meshseg::operator::Stencil;
use meshseg::run::{Run, Status, Stop};
use meshseg::sweep::with_threads;

use super::instance::{mesh, problem};
use super::steps::solver;

const VARIANTS: [(&str, &str); 4] = [
    ("chambolle-pock", "precision=f32"),
    ("chambolle-pock", "precision=f64"),
    ("chambolle-pock", "engine=rows"),
    ("douglas-rachford", ""),
];

pub fn solves(criterion: &mut Criterion) {
    let mesh = mesh();
    // The landing steps of looks slow a method down, the more of them the longer it takes.
    for (lambda, interval) in [(0.005, 4), (0.02, 20)] {
        let problem = problem::<_, 4>(&mesh, Stencil::new(&mesh), lambda);
        let mut group = criterion.benchmark_group(format!("solve, lambda = {lambda}"));
        group.sample_size(10).measurement_time(Duration::from_secs(2));
        for (name, option) in VARIANTS {
            for gap in [1e-3, 1e-4] {
                let once = || {
                    let mut solver = solver(name, option, &mesh, &problem);
                    let mut run = Run::new(solver.iterate().u);
                    let stop = Stop {
                        relative_gap: Some(gap),
                        interval: Some(interval),
                        ..Stop::default()
                    };
                    let go = &mut |_: Option<&_>| ControlFlow::Continue(());
                    let status = run.advance(&mut *solver, &problem, &stop, go);
                    assert_eq!(status, Status::Converged);
                    Duration::from_secs_f64(run.seconds())
                };
                group.bench_function(format!("{name} {option} to {gap:e}, 2 threads"), |b| {
                    b.iter_custom(|n| {
                        with_threads(Some(2), || (0..n).map(|_| once()).sum())
                            .expect("the threads start")
                    });
                });
            }
        }
        group.finish();
    }
}
