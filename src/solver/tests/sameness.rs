//! Invariance: under the form of the operator, the order of the regions, the number of threads and padding regions.

use super::{CONSISTENT, after, all_variants, solver, uniform, variants};
use crate::field::{Row, Tangent};
use crate::operator::{Matrix, Stencil};
use crate::problem::Problem;
use crate::regions::pad_costs;
use crate::samples::{bumpy, flipped, needles, random_labels, random_problem, rng, shape};
use crate::sweep::with_threads;

/// The same algorithm on two forms of the operator: equal up to rounding for 30 steps.
#[test]
fn stencil_and_matrix_give_the_same_iterates() {
    for (name, mesh) in
        [("torus", shape("torus:12x8")), ("bumpy", bumpy(8)), ("needles", needles(4, 1e-2))]
    {
        let n = mesh.vertices.len();
        let fast: Problem<Stencil, 3> = random_problem(&mesh, 0.03 * mesh.area().sqrt(), 71);
        let slow = Problem::new(Matrix::new(&mesh), fast.f.clone(), fast.lambda);
        let start = random_labels::<3>(n, 3, &mut rng(72));
        for variant in all_variants() {
            let (u, q) = after(&mut *solver(variant, &mesh, &fast, start.clone()), &fast, 30);
            let (w, r) = after(&mut *solver(variant, &mesh, &slow, start.clone()), &slow, 30);
            let difference = u.iter().zip(&w).map(|(&u, &w)| (u - w).max_abs()).fold(0.0, f64::max);
            assert!(difference <= 1e-9, "{name}, {variant:?}: {difference}");
            let difference = q.iter().zip(&r).map(|(&q, &r)| (q - r).norm()).fold(0.0, f64::max);
            assert!(difference <= 1e-8 * fast.lambda, "{name}, {variant:?}: {difference}");
            let moved = u.iter().zip(&start).any(|(&u, &s)| (u - s).max_abs() > 1e-6);
            assert!(moved, "{name}, {variant:?}");
        }
    }
}

fn permuted<const M: usize>(rows: &[Row<M>], order: [usize; M]) -> Vec<Row<M>> {
    rows.iter().map(|row| Row::from_fn(|p| row.0[order[p]])).collect()
}

/// Regions have no order: permuted costs give permuted labels up to rounding, because sums are in another order. Only
/// expansions take one label after the other.
#[test]
fn permuting_regions_permutes_columns() {
    let mesh = flipped(shape("sphere:2"));
    let order = [3, 0, 4, 1, 2];
    let problem = random_problem::<5>(&mesh, 0.05 * mesh.area().sqrt(), 73);
    let other = Problem::new(Stencil::new(&mesh), permuted(&problem.f, order), problem.lambda);
    let start = random_labels::<5>(mesh.vertices.len(), 5, &mut rng(74));
    for variant in variants().chain([CONSISTENT]) {
        let (u, _) = after(&mut *solver(variant, &mesh, &problem, start.clone()), &problem, 30);
        let permuted_start = permuted(&start, order);
        let (w, _) = after(&mut *solver(variant, &mesh, &other, permuted_start), &other, 30);
        for (u, w) in permuted(&u, order).into_iter().zip(w) {
            assert!((u - w).max_abs() <= 1e-10, "{variant:?}: {u:?} {w:?}");
        }
    }
}

/// Bit for bit, on a mesh large enough for several threads.
#[test]
fn the_number_of_threads_does_not_matter() {
    let mesh = shape("torus:90x60");
    let problem = random_problem::<3>(&mesh, 0.02, 75);
    for variant in all_variants() {
        let bits = |threads: usize| -> (Vec<u64>, [u64; 2]) {
            with_threads(Some(threads), || {
                let start = uniform(mesh.vertices.len(), 3);
                let (u, q) = after(&mut *solver(variant, &mesh, &problem, start), &problem, 40);
                let fields = q.iter().flat_map(|Tangent(q)| q).chain(&u);
                let fields = fields.flat_map(|row| row.0.map(f64::to_bits)).collect();
                (fields, [problem.energy(&u).to_bits(), problem.dual_bound(&q).to_bits()])
            })
            .unwrap()
        };
        assert!(bits(1) == bits(3), "{variant:?}");
    }
}

/// Also after steps at which omega is balanced, which takes sums over all faces and vertices.
#[test]
fn with_balancing_neither_threads_nor_operators_matter() {
    let mesh = shape("torus:90x60");
    let fast: Problem<Stencil, 3> = random_problem(&mesh, 0.02, 76);
    let slow = Problem::new(Matrix::new(&mesh), fast.f.clone(), fast.lambda);
    let start = || uniform(mesh.vertices.len(), 3);
    for name in ["chambolle-pock", "douglas-rachford"] {
        let bits = |threads: usize, option: &'static str| -> Vec<u64> {
            with_threads(Some(threads), || {
                let mut solver = solver((name, &[option]), &mesh, &fast, start());
                (0..8).for_each(|_| drop(after(&mut *solver, &fast, 50)));
                solver.iterate().u.iter().flat_map(|row| row.0.map(f64::to_bits)).collect()
            })
            .unwrap()
        };
        assert_eq!(bits(1, "balance=adaptive"), bits(3, "balance=adaptive"), "{name}");
        assert_ne!(bits(1, "balance=adaptive"), bits(1, "balance=fixed"), "{name}");

        let mut by_stencil = solver((name, &[]), &mesh, &fast, start());
        let mut by_matrix = solver((name, &[]), &mesh, &slow, start());
        for _ in 0..8 {
            let (u, _) = after(&mut *by_stencil, &fast, 50);
            let (w, _) = after(&mut *by_matrix, &slow, 50);
            let difference = u.iter().zip(&w).map(|(&u, &w)| (u - w).max_abs()).fold(0.0, f64::max);
            assert!(difference <= 1e-9, "{name}: {difference}");
        }
    }
}

/// Padding regions stay empty and do not affect the other regions.
#[test]
fn padding_regions_do_not_matter() {
    let mesh = bumpy(8);
    let problem = random_problem::<5>(&mesh, 0.05, 77);
    let wide = |rows: &[Row<5>]| -> Vec<Row<7>> {
        rows.iter().map(|row| Row::from_fn(|p| if p < 5 { row.0[p] } else { 0.0 })).collect()
    };
    let mut f = wide(&problem.f);
    pad_costs(5, &mut f);
    let padded = Problem::new(Stencil::new(&mesh), f, problem.lambda);
    let start = random_labels::<5>(mesh.vertices.len(), 5, &mut rng(78));
    for variant in all_variants() {
        let (u, _) = after(&mut *solver(variant, &mesh, &problem, start.clone()), &problem, 30);
        let (w, _) = after(&mut *solver(variant, &mesh, &padded, wide(&start)), &padded, 30);
        for (u, w) in wide(&u).into_iter().zip(w) {
            assert!((u - w).max_abs() <= 1e-10, "{variant:?}: {u:?} {w:?}");
            assert_eq!(w.0[5..], [0.0; 2], "{variant:?}");
        }
    }
}
