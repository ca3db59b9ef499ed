//! The work before the first step, and the projection.

use std::borrow::Cow;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion};
use meshseg::field::Row;
use meshseg::mesh::io;
use meshseg::mesh::order::Order;
use meshseg::operator::{Mass, Matrix, Stencil};
use meshseg::prox::project_simplex;
use meshseg::sweep::with_threads;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::instance::{LAMBDA, costs, mesh, problem, torus};
use super::steps::solver;

pub fn parts(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("simplex projection of 100,000 rows");
    projection::<2>(&mut group);
    projection::<4>(&mut group);
    projection::<8>(&mut group);
    projection::<16>(&mut group);
    projection::<64>(&mut group);
    group.finish();

    let mesh = mesh();
    let mut group = criterion.benchmark_group("set-up");
    group.sample_size(20);
    let torus = torus();
    let s = costs::<4>();
    let stencil = problem::<_, 4>(&mesh, Stencil::new(&mesh), LAMBDA);
    for threads in [1, 2] {
        let id = |what: &str| format!("{what}, {threads} thread(s)");
        timed(&mut group, id("order of vertices and faces"), threads, || {
            Order::of(&torus).mesh(Cow::Borrowed(&torus)).into_owned()
        });
        timed(&mut group, id("gradient as a stencil"), threads, || Stencil::new(&mesh));
        timed(&mut group, id("gradient as a matrix"), threads, || Matrix::new(&mesh));
        timed(&mut group, id("costs integrated"), threads, || {
            Mass::Barycentric.on(&mesh).integrate(&s)
        });
        for precision in ["f64", "f32"] {
            let option = format!("precision={precision}");
            timed(&mut group, id(&format!("steps and packing {precision}")), threads, || {
                solver("chambolle-pock", &option, &mesh, &stencil)
            });
        }
    }
    group.finish();

    let mut group = criterion.benchmark_group("readers, 200,000 faces");
    group.sample_size(20);
    let folder = tempfile::tempdir().expect("a temporary folder");
    for extension in ["ply", "obj", "off", "stl"] {
        let path = folder.path().join("torus").with_extension(extension);
        io::write(&path, &mesh).expect("the mesh is written");
        group.bench_function(extension, |b| b.iter(|| io::read(&path).expect("the mesh is read")));
    }
    group.finish();
}

/// Times `make`; its result is dropped off the clock.
fn timed<T>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    id: String,
    threads: usize,
    make: impl Fn() -> T + Sync,
) {
    let once = || {
        let begin = Instant::now();
        let made = black_box(make());
        let time = begin.elapsed();
        drop(made);
        time
    };
    group.bench_function(id, |b| {
        b.iter_custom(|n| {
            with_threads(Some(threads), || (0..n).map(|_| once()).sum::<Duration>())
                .expect("the threads start")
        });
    });
}

fn projection<const M: usize>(group: &mut BenchmarkGroup<'_, WallTime>) {
    let mut rng = Pcg64::seed_from_u64(1);
    let rows: Vec<Row<M>> =
        (0..100_000).map(|_| Row::from_fn(|_| 2.0 * rng.random::<f64>())).collect();
    group.bench_function(format!("m = {M}"), |b| {
        b.iter(|| rows.iter().map(|&v| project_simplex(v).0[0]).sum::<f64>());
    });
}
