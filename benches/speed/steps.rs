//! One step of every solver, engine and precision, compared with the loops fused by hand and generic sparse products.

use std::hint::black_box;
use std::time::Instant;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput};
use meshseg::field::Row;
use meshseg::mesh::Mesh;
use meshseg::operator::{Matrix, Stencil};
use meshseg::problem::Problem;
use meshseg::solver::{Engines, Method, Options, Setup, Solver};
use meshseg::sweep::{collect, with_threads};

use super::csr::{Csr, Float};
use super::hand_fused::HandFused;
use super::instance::{LAMBDA, bytes_per_step, mesh, problem, problem_as_numbered, torus};

pub fn steps(criterion: &mut Criterion) {
    let torus = torus();
    let four = problem_as_numbered::<_, 4>(&torus, Stencil::new(&torus));
    check_baselines(&torus, &four);
    let mut group = begin(criterion, 4);
    group.throughput(Throughput::Bytes(bytes_per_step(&torus, 4, 8)));
    group.bench_function("fused by hand f64, 1 thread(s)", |bencher| {
        bencher.iter_custom(|steps| {
            let mut fused = HandFused::new(&torus, &four);
            (0..4).for_each(|_| fused.step());
            let begin = Instant::now();
            (0..steps).for_each(|_| black_box(&mut fused).step());
            begin.elapsed()
        });
    });
    let mesh = mesh();
    let matrix = problem::<_, 4>(&mesh, Matrix::new(&mesh), LAMBDA);
    let as_numbered = problem_as_numbered::<_, 4>(&torus, Matrix::new(&torus));
    for threads in [1, 2] {
        sparse::<f64, 4>(&mut group, &as_numbered, threads);
        step(&mut group, &mesh, &matrix, "chambolle-pock", "engine=rows", "matrix f64", threads);
    }
    group.finish();

    steps_of::<2>(criterion, &mesh, &torus);
    steps_of::<4>(criterion, &mesh, &torus);
    steps_of::<8>(criterion, &mesh, &torus);
    steps_of::<16>(criterion, &mesh, &torus);
}

fn begin(criterion: &mut Criterion, m: usize) -> BenchmarkGroup<'_, WallTime> {
    let mut group = criterion.benchmark_group(format!("step, m = {m}"));
    group.sample_size(20);
    group
}

fn steps_of<const M: usize>(criterion: &mut Criterion, mesh: &Mesh, torus: &Mesh) {
    let stencil = problem::<_, M>(mesh, Stencil::new(mesh), LAMBDA);
    let matrix = problem_as_numbered::<_, M>(torus, Matrix::new(torus));
    let mut group = begin(criterion, M);
    for threads in [1, 2] {
        group.throughput(Throughput::Bytes(bytes_per_step(mesh, M, 4)));
        sparse::<f32, M>(&mut group, &matrix, threads);
        let name = "chambolle-pock";
        step(&mut group, mesh, &stencil, name, "precision=f32", "fused f32", threads);
        group.throughput(Throughput::Bytes(bytes_per_step(mesh, M, 8)));
        step(&mut group, mesh, &stencil, name, "engine=fused", "fused f64", threads);
        step(&mut group, mesh, &stencil, name, "engine=rows", "rows f64", threads);
        // A step of alpha-expansion is a minimum cut, which takes as long as it takes.
        for method in Method::all()[1..].iter().filter(|m| m.name() != "alpha-expansion") {
            step(&mut group, mesh, &stencil, method.name(), "", "f64", threads);
        }
    }
    group.finish();
}

/// Generic sparse products. Every measurement restarts the method; otherwise subnormal numbers would eventually slow
/// it down.
fn sparse<T: Float, const M: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    problem: &Problem<Matrix, M>,
    threads: usize,
) {
    let id = format!("sparse products f{}, {threads} thread(s)", 8 * size_of::<T>());
    group.bench_function(id, |bencher| {
        bencher.iter_custom(|steps| {
            let run = || {
                let mut csr = Csr::<T, M>::new(problem);
                (0..4).for_each(|_| csr.step());
                let begin = Instant::now();
                (0..steps).for_each(|_| csr.step());
                begin.elapsed()
            };
            with_threads(Some(threads), run).expect("the threads start")
        });
    });
}

/// The largest number of steps that the engine makes in one pass, and the number of steps between the program's early
/// evaluations of the gap.
const STEPS_PER_PASS: u64 = 8;

/// One of our solvers; every measurement restarts it, with a few steps of warm-up.
fn step<K: Engines + Send, const M: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    mesh: &Mesh,
    problem: &Problem<K, M>,
    name: &str,
    option: &str,
    variant: &str,
    threads: usize,
) {
    group.bench_function(format!("{name} {variant}, {threads} thread(s)"), |bencher| {
        bencher.iter_custom(|steps| {
            let run = || {
                let mut solver = solver(name, option, mesh, problem);
                let mut make = |steps| solver.advance(problem, steps, &mut || true);
                make(STEPS_PER_PASS);
                let made = steps.next_multiple_of(STEPS_PER_PASS);
                let begin = Instant::now();
                make(made);
                begin.elapsed().mul_f64(steps as f64 / made as f64)
            };
            with_threads(Some(threads), run).expect("the threads start")
        });
    });
}

pub fn solver<'a, K: Engines + 'a, const M: usize>(
    name: &str,
    option: &str,
    mesh: &Mesh,
    problem: &Problem<K, M>,
) -> Box<dyn Solver<K, M> + 'a> {
    let start = collect(problem.f.len(), |v| Row::one_hot(problem.f[v].argmin()));
    let options: Vec<&str> = option.split_whitespace().collect();
    let options = Options::parse(&options).expect("options are key=value");
    let method = Method::parse(name, &options).expect("the options are valid");
    method
        .build(Setup { domain: mesh.into(), problem, start, dual_start: None })
        .expect("the options are compatible")
}

/// Checks that the baselines compute the same iterates as ours.
fn check_baselines(mesh: &Mesh, problem: &Problem<Stencil, 4>) {
    let matrix = Problem::new(Matrix::new(mesh), problem.f.clone(), problem.lambda);
    let mut fused = HandFused::new(mesh, problem);
    let mut sparse = Csr::<f64, 4>::new(&matrix);
    let mut ours = solver("chambolle-pock", "engine=rows", mesh, problem);
    for _ in 0..20 {
        fused.step();
        sparse.step();
    }
    // Their iterates are relaxed, u + rho (x - u); our last iterate is x.
    let rho = 1.9;
    let before: Vec<_> = fused.u().iter().map(|&u| Row(u)).zip(sparse.u().map(Row)).collect();
    fused.step();
    sparse.step();
    ours.advance(problem, 21, &mut || true);
    let rows = ours.iterate().u;
    for (((fused, sparse), before), &row) in fused.u().iter().zip(sparse.u()).zip(before).zip(rows)
    {
        let x = |u: Row<4>, now: Row<4>| u + 1.0 / rho * (now - u);
        assert!((x(before.0, Row(*fused)) - row).max_abs() < 1e-11);
        assert!((x(before.1, Row(sparse)) - row).max_abs() < 1e-11);
    }
}
