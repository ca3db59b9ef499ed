//! Labels of faces are those of the exact Potts model, whatever solves for them; costs and labels are carried exactly.

mod carried;
mod chosen;
mod cleaned;
mod faces;
mod weighted;

use std::ops::ControlFlow;

use ndarray::Array2;
use rand::RngExt;

use crate::operator::Mass;
use crate::relaxation::Relaxation;
use crate::request::Request;
use crate::run::{Sample, Stop};
use crate::samples::rng;
use crate::solver::Method;

fn request(lambda: f64, gap: f64) -> Request {
    Request {
        lambda,
        relaxation: Relaxation::Separate,
        mass: Mass::Barycentric,
        method: Method::default(),
        stop: Stop { relative_gap: Some(gap), iterations: Some(100_000), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: crate::rounding::Rounding::Expansion,
        label_gap: None,
    }
}

fn go(_: Option<&Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn random_costs(rows: usize, m: usize, seed: u64) -> Array2<f64> {
    let mut rng = rng(seed);
    Array2::from_shape_fn((rows, m), |_| rng.random_range(0.0..1.0))
}
