//! The memory limit: a <- b + 3 c on the bytes that a step moves, with the same number of threads.

use criterion::{Criterion, Throughput};
use meshseg::sweep::{sweep, with_threads};
use std::hint::black_box;
use std::time::Instant;

use super::instance::{bytes_per_step, mesh};

pub fn triads(criterion: &mut Criterion) {
    let mesh = mesh();
    let mut group = criterion.benchmark_group("triad");
    group.sample_size(20);
    for m in [2, 4, 8, 16] {
        for real in [8, 4] {
            let bytes = bytes_per_step(&mesh, m, real);
            group.throughput(Throughput::Bytes(bytes));
            let n = bytes as usize / 24;
            let (mut a, b, c) = (vec![0.0; n], vec![1.0; n], vec![2.0; n]);
            for threads in [1, 2] {
                group.bench_function(
                    format!("m = {m}, f{}, {threads} thread(s)", 8 * real),
                    |bencher| {
                        bencher.iter_custom(|passes| {
                            let run = || {
                                let begin = Instant::now();
                                for _ in 0..passes {
                                    sweep(
                                        (&mut a[..], &b[..], &c[..]),
                                        #[inline(always)]
                                        |_, (a, &b, &c)| *a = b + 3.0 * c,
                                    );
                                    black_box(&mut a);
                                }
                                begin.elapsed()
                            };
                            with_threads(Some(threads), run).expect("the threads start")
                        });
                    },
                );
            }
        }
    }
    group.finish();
}
