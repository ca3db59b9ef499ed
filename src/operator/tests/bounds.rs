//! The closed-form bounds are compared with dense eigenvalues.

use nalgebra::{Matrix2, SymmetricEigen};
use rand::RngExt;

use crate::operator::bounds::{column_bound, diagonal_above, of_faces, row_bound, squared};
use crate::operator::{Matrix, Operator, Stencil};
use crate::samples::{assert_within, largest_curvature, needles, rng, shape, zoo};
use crate::sweep::with_threads;

/// The largest eigenvalue of sum_k weight_k g_k g_k^T, by nalgebra.
fn largest(columns: [[f64; 2]; 3], weight: impl Fn([f64; 2]) -> f64) -> f64 {
    let sum: Matrix2<f64> = columns
        .into_iter()
        .map(|column| {
            let g = nalgebra::Vector2::from(column);
            g * g.transpose() * weight(column)
        })
        .sum();
    SymmetricEigen::new(sum).eigenvalues.max()
}

#[test]
fn face_bounds_are_the_eigenvalues() {
    for (_, mesh) in zoo() {
        let k = Stencil::new(&mesh);
        let (l, b) = (of_faces(&k, row_bound), of_faces(&k, column_bound));
        for j in 0..k.faces() {
            let columns = k.face(j).columns;
            let row = largest(columns, |_| 1.0);
            assert_within(l[j], row, 1e-13, row);
            let column = largest(columns, |g| 1.0 / squared(g));
            assert_within(b[j], column, 1e-13, column);
            assert!((1.5 - 1e-13..=3.0 + 1e-13).contains(&b[j]));
        }
    }
}

/// Numbers of faces that are not multiples of the block size.
#[test]
fn bounds_are_at_the_indices_of_their_faces() {
    let k = Stencil::new(&shape("torus:41x33"));
    let one_by_one: Vec<f64> = (0..k.faces()).map(|j| row_bound(k.face(j).columns)).collect();
    for threads in [1, 3] {
        assert_eq!(with_threads(Some(threads), || of_faces(&k, row_bound)).unwrap(), one_by_one);
    }
}

#[test]
fn the_diagonal_is_an_upper_bound() {
    let mut rng = rng(21);
    for (name, mesh) in zoo() {
        let n = mesh.faces.len();
        let ones = vec![1.0; n];
        let wild: Vec<f64> = (0..n).map(|_| 10_f64.powf(rng.random_range(-3.0..3.0))).collect();
        let lengths: Vec<f64> = {
            let k = Stencil::new(&mesh);
            (0..n).map(|j| 1.0 / row_bound(k.face(j).columns).sqrt()).collect()
        };
        for w in [ones, wild, lengths] {
            for above in [
                diagonal_above(&Stencil::new(&mesh), |j| w[j]),
                diagonal_above(&Matrix::new(&mesh), |j| w[j]),
            ] {
                let largest = largest_curvature(&Stencil::new(&mesh), |j| w[j], |v| above[v]);
                assert!(largest <= 1.0 + 1e-10, "{name}: {largest}");
                // The bound is not too large: at most 3 times the value, since b_j <= 3.
                assert!(largest >= 1.0 / 3.0, "{name}: {largest}");
            }
        }
    }
}

/// On right-angled isosceles faces the checkerboard function +-1 attains the bound, except at the border.
#[test]
fn the_diagonal_bound_is_attained_on_a_grid() {
    let ratio = |cells: u32| {
        let mesh = shape(&format!("grid:{cells}x{cells}"));
        let k = Stencil::new(&mesh);
        let above = diagonal_above(&k, |_| 1.0);
        let sign = |v: u32| f64::from(v % (cells + 1) + v / (cells + 1)) % 2.0 * 2.0 - 1.0;
        let u = super::column((0..k.vertices() as u32).map(sign));
        let energy: f64 = (0..k.faces()).map(|j| k.at(&u, j).norm_squared()).sum();
        energy / above.iter().sum::<f64>()
    };
    assert!((ratio(6) - 1.0).abs() < 1e-12, "{}", ratio(6));
    assert!((ratio(11) - 1.0).abs() < 1e-12, "{}", ratio(11));
}

/// The steps of local preconditioning: || Sigma^1/2 K T^1/2 || <= 1 on needles of any aspect.
#[test]
fn the_diagonal_is_an_upper_bound_on_needles() {
    for aspect in [1e-1, 1e-3, 1e-6, 1e-9] {
        let mesh = needles(3, aspect);
        let k = Stencil::new(&mesh);
        let w: Vec<f64> =
            (0..k.faces()).map(|j| 1.0 / row_bound(k.face(j).columns).sqrt()).collect();
        let above = diagonal_above(&k, |j| w[j]);
        let largest = largest_curvature(&k, |j| w[j], |v| above[v]);
        assert!(largest <= 1.0 + 1e-10, "{aspect}: {largest}");
    }
}
