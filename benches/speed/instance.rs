//! The instance: torus:400x250 with noisy palette colors, in the order in which the program solves it.

use std::borrow::Cow;

use meshseg::field::Row;
use meshseg::mesh::order::Order;
use meshseg::mesh::{Mesh, Shape};
use meshseg::operator::{Mass, Operator};
use meshseg::problem::Problem;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

pub const LAMBDA: f64 = 0.005;

pub fn torus() -> Mesh {
    Shape::Torus { nu: 400, nv: 250 }.mesh()
}

pub fn mesh() -> Mesh {
    let torus = torus();
    Order::of(&torus).mesh(Cow::Borrowed(&torus)).into_owned()
}

/// The costs in the order in which the program solves the problem.
pub fn costs<const M: usize>() -> Vec<Row<M>> {
    Order::of(&torus()).applied(costs_as_numbered())
}

/// s_p = |C - palette_p|^2, C = the color of one of four bands + N(0, 0.3^2); further regions have colors in between.
pub fn costs_as_numbered<const M: usize>() -> Vec<Row<M>> {
    let palette = |p: usize| {
        let colors = [[0.85, 0.2, 0.2], [0.2, 0.7, 0.3], [0.2, 0.3, 0.85], [0.9, 0.85, 0.2]];
        let (a, b): ([f64; 3], [f64; 3]) = (colors[p % 4], colors[(p + 1 + p / 4) % 4]);
        let t = (p / 4) as f64 / 8.0;
        [0, 1, 2].map(|i| (1.0 - t) * a[i] + t * b[i])
    };
    let mut rng = Pcg64::seed_from_u64(0);
    let mut normal = || {
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    (0..400 * 250)
        .map(|k| {
            let turn = |i: usize, n: usize| std::f64::consts::TAU * i as f64 / n as f64;
            let (u, v) = (turn(k / 250, 400), turn(k % 250, 250));
            let band = 2 * usize::from((3.0 * u + (2.0 * v).sin()).sin() > 0.0)
                + usize::from((2.0 * v + (3.0 * u).cos()).sin() > 0.0);
            let color = palette(band % M).map(|c| c + 0.3 * normal());
            Row::from_fn(|p| (0..3).map(|i| (color[i] - palette(p)[i]).powi(2)).sum())
        })
        .collect()
}

pub fn problem<K: Operator, const M: usize>(mesh: &Mesh, k: K, lambda: f64) -> Problem<K, M> {
    Problem::new(k, Mass::Barycentric.on(mesh).integrate(&costs()), lambda)
}

/// On the torus in its original numbering, which suits loops that do not reorder better.
pub fn problem_as_numbered<K: Operator, const M: usize>(torus: &Mesh, k: K) -> Problem<K, M> {
    Problem::new(k, Mass::Barycentric.on(torus).integrate(&costs_as_numbered()), LAMBDA)
}

/// The bytes of a step: u and q read and written; f, tau, sigma, c1, c2, c3 and the corners read; `real` bytes per
/// number.
pub fn bytes_per_step(mesh: &Mesh, m: usize, real: usize) -> u64 {
    let vertex = (2 * m + m + 1) * real;
    let face = (2 * 2 * m + 4) * real + 3 * size_of::<u32>();
    (mesh.vertices.len() * vertex + mesh.faces.len() * face) as u64
}
