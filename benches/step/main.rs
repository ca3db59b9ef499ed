//! One over-relaxed Chambolle-Pock step on torus:400x250 with 4 regions, in double precision: the readable
//! text on `Stencil`, the same text on `Matrix` (compressed sparse rows), and the loops fused by hand.
//!
//! The yardstick computes the same iterates, which is checked before anything is timed. With one thread:
//! `Stencil` is to cost at most 1.15 times the hand-fused loops, compressed rows at least 1.8 times `Stencil`.

mod hand_fused;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use meshseg::field::Row;
use meshseg::mesh::{Mesh, Shape};
use meshseg::operator::{Mass, Matrix, Operator, Stencil};
use meshseg::problem::Problem;
use meshseg::solver::{Options, Setup, Solver, build};
use meshseg::sweep::with_threads;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use hand_fused::HandFused;

const M: usize = 4;
const LAMBDA: f64 = 0.005;

fn costs(vertices: usize) -> Vec<Row<M>> {
    let mut rng = Pcg64::seed_from_u64(0);
    (0..vertices).map(|_| Row::from_fn(|_| rng.random::<f64>())).collect()
}

fn problem<K: Operator>(mesh: &Mesh, k: K) -> Problem<K, M> {
    Problem::new(k, Mass::Barycentric.on(mesh).integrate(&costs(mesh.vertices.len())), LAMBDA)
}

fn solver<'a, K: Operator + 'a>(
    mesh: &Mesh,
    problem: &Problem<K, M>,
) -> Box<dyn Solver<K, M> + 'a> {
    let start = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
    let setup = Setup { mesh, problem, start, dual_start: None, options: &Options::default() };
    build("chambolle-pock", setup).expect("default options are valid")
}

fn steps(criterion: &mut Criterion) {
    let mesh = Shape::Torus { nu: 400, nv: 250 }.mesh();
    let stencil = problem(&mesh, Stencil::new(&mesh));
    let matrix = problem(&mesh, Matrix::new(&mesh));
    agree(&mesh, &stencil);

    let mut group = criterion.benchmark_group("chambolle-pock step, 200k faces, m = 4, f64");
    group.sample_size(30);
    let mut fused = HandFused::new(&mesh, &stencil);
    group.bench_function("hand-fused, 1 thread", |b| b.iter(|| black_box(&mut fused).step()));
    for threads in [1, 2] {
        group.bench_function(format!("stencil, {threads} thread(s)"), |b| {
            b.iter_custom(|steps| time(&mesh, &stencil, steps, threads));
        });
        group.bench_function(format!("compressed rows, {threads} thread(s)"), |b| {
            b.iter_custom(|steps| time(&mesh, &matrix, steps, threads));
        });
    }
    group.finish();
}

/// The time of so many steps after a few to warm up.
fn time<K: Operator + Send + Sync>(
    mesh: &Mesh,
    problem: &Problem<K, M>,
    steps: u64,
    threads: usize,
) -> Duration {
    let run = || {
        let mut solver = solver(mesh, problem);
        for _ in 0..4 {
            solver.step(problem, false);
        }
        let begin = Instant::now();
        for _ in 0..steps {
            solver.step(problem, false);
        }
        begin.elapsed()
    };
    with_threads(Some(threads), run).expect("the threads start")
}

/// The yardstick is worth nothing if it computes something else.
fn agree(mesh: &Mesh, problem: &Problem<Stencil, M>) {
    let mut fused = HandFused::new(mesh, problem);
    let mut readable = solver(mesh, problem);
    for _ in 0..20 {
        fused.step();
        readable.step(problem, false);
    }
    let readable = readable.iterate().u;
    for (fused, readable) in fused.u().iter().zip(readable) {
        assert!((Row(*fused) - *readable).max_abs() < 1e-11);
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
