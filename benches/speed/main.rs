//! Speed, compared with the limits of the machine: `cargo bench`; `make bench-report` writes a page.
//!
//! One instance throughout: torus:400x250 (200,000 faces), noisy colors of four or more regions, lambda = 0.005.
//! All implementations that are compared compute the same, which is checked before anything is timed. The bytes of a
//! step are those that every implementation must move: each array of the state once.

mod csr;
mod hand_fused;
mod instance;
mod parts;
mod solves;
mod steps;
mod triad;

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use mimalloc::MiMalloc;

/// As in the program.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

// All benchmarks take less than ten minutes.
criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(700))
        .measurement_time(Duration::from_millis(1500));
    targets = triad::triads, steps::steps, parts::parts, solves::solves
}
criterion_main!(benches);
