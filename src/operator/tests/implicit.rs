//! The matrix of implicit steps, D + K^T diag(w) K, its factorization and its Gauss-Seidel sweep.

use rand::RngExt;
use sprs::CsMat;

use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::bounds::{diagonal_above, row_bound};
use crate::operator::{Adjoint, Cholesky, GaussSeidel, Matrix, Operator, Stencil, normal_matrix};
use crate::samples::{assert_within, disjoint, random_rows, rng, shape, zoo};
use crate::sweep::with_threads;

/// The zoo, and meshes that are large enough for the sweep to cut them into parts, one of them randomly numbered.
fn meshes() -> Vec<(&'static str, Mesh)> {
    let mut shuffled = shape("torus:70x40");
    let n = shuffled.vertices.len();
    let index = |v: usize| v * 1013 % n;
    let vertices = shuffled.vertices.clone();
    vertices.iter().enumerate().for_each(|(v, x)| shuffled.vertices[index(v)] = *x);
    for v in shuffled.faces.iter_mut().flatten() {
        *v = index(*v as usize) as u32;
    }
    let parts = disjoint([shape("grid:40x30"), shape("sphere:3").scaled(0.01), shuffled.clone()]);
    zoo().into_iter().chain([("shuffled", shuffled), ("parts", parts)]).collect()
}

/// Random D and w, from 1e-3 to 1e3 times balanced values.
fn wild(k: &impl Operator) -> (Vec<f64>, Vec<f64>) {
    let mut rng = rng(31);
    let mut factor = || 10_f64.powf(rng.random_range(-3.0..3.0));
    let w: Vec<f64> =
        (0..k.faces()).map(|j| factor() / row_bound(k.face(j).columns).sqrt()).collect();
    let above = diagonal_above(k, |j| w[j]);
    let d = above.iter().map(|&x| factor() * if x > 0.0 { x } else { 1.0 }).collect();
    (d, w)
}

fn times<const M: usize>(t: &CsMat<f64>, x: &[Row<M>]) -> Vec<Row<M>> {
    let row = |v: usize| {
        t.outer_view(v).unwrap().iter().fold(Row::ZERO, |sum, (w, &value)| sum + x[w] * value)
    };
    (0..t.rows()).map(row).collect()
}

fn dot<const M: usize>(a: &[Row<M>], b: &[Row<M>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

#[test]
fn the_normal_matrix_matches_its_definition() {
    for (name, mesh) in meshes() {
        let k = Stencil::new(&mesh);
        let (d, w) = wild(&k);
        let t = normal_matrix(&k, &d, &w);
        let other = normal_matrix(&Matrix::new(&mesh), &d, &w);
        let x = random_rows::<3>(mesh.vertices.len(), &mut rng(32));
        let q: Vec<_> = (0..k.faces()).map(|j| k.at(&x, j) * w[j]).collect();
        for (v, tx) in times(&t, &x).into_iter().enumerate() {
            let exact = x[v] * d[v] + k.adjoint().at(&q, v);
            let row = t.outer_view(v).unwrap();
            let size: f64 = row.data().iter().map(|value| value.abs()).sum();
            assert!((tx - exact).max_abs() <= 1e-13 * size, "{name}: {tx:?} {exact:?}");
            assert!(row.indices().is_sorted_by(|a, b| a < b), "{name}");
            for (column, &value) in row.iter() {
                // Symmetric entry by entry, and equal for both operators up to rounding.
                assert_eq!(t.get(column, v), Some(&value), "{name}");
                assert_within(other.get(v, column).copied().unwrap_or(0.0), value, 1e-9, size);
            }
        }
    }
}

#[test]
fn cholesky_solves() {
    for (name, mesh) in meshes() {
        let k = Stencil::new(&mesh);
        let (d, w) = wild(&k);
        let t = normal_matrix(&k, &d, &w);
        let b = random_rows::<5>(mesh.vertices.len(), &mut rng(33));
        let mut x = b.clone();
        Cholesky::new(&t).unwrap().solve(&mut x);
        // The factor has at least a diagonal, and at most a full triangle.
        let n = mesh.vertices.len();
        assert!(Cholesky::within(&t, n - 1).is_none() && Cholesky::within(&t, n * n).is_some());
        let size = |row: &Row<5>| row.max_abs();
        for (v, (tx, b)) in times(&t, &x).into_iter().zip(&b).enumerate() {
            let row = t.outer_view(v).unwrap();
            let scale: f64 = row.iter().map(|(w, value)| value.abs() * size(&x[w])).sum();
            assert!((tx - *b).max_abs() <= 1e-12 * (scale + size(b)), "{name}: {tx:?} {b:?}");
        }
    }
}

/// M is symmetric and M >= T: x^T T x <= x^T M x = x^T r for x = M^-1 r. The r are driven towards the worst
/// by the power method on T M^-1.
#[test]
fn the_sweep_is_an_upper_bound_of_the_matrix() {
    for (name, mesh) in meshes() {
        let k = Stencil::new(&mesh);
        let local: Vec<f64> =
            (0..k.faces()).map(|j| 1.0 / row_bound(k.face(j).columns).sqrt()).collect();
        let above = diagonal_above(&k, |j| local[j]);
        let even = above.iter().map(|&x| if x > 0.0 { x / 9.0 } else { 1.0 }).collect();
        for (d, w) in [wild(&k), (even, local)] {
            let t = normal_matrix(&k, &d, &w);
            let m = GaussSeidel::new(&t);
            let solve = |r: &[Row<2>]| {
                let mut x = vec![Row::ZERO; r.len()];
                m.solve(&mut x, |v| r[v]);
                (0..r.len()).map(|v| m.at(&x, v)).collect::<Vec<_>>()
            };
            let [mut r, s] = [34, 35].map(|seed| random_rows::<2>(d.len(), &mut rng(seed)));
            let (rs, sr) = (dot(&s, &solve(&r)), dot(&r, &solve(&s)));
            assert_within(rs, sr, 1e-10, (dot(&r, &solve(&r)) * dot(&s, &solve(&s))).sqrt());
            let mut ratio = 0.0;
            for _ in 0..100 {
                let x = solve(&r);
                let tx = times(&t, &x);
                ratio = dot(&x, &tx) / dot(&x, &r);
                assert!(ratio > 0.0 && ratio <= 1.0 + 1e-12, "{name}: {ratio}");
                let norm = dot(&tx, &tx).sqrt();
                r = tx.into_iter().map(|row| row * (1.0 / norm)).collect();
            }
            // M is not much larger than T where it matters.
            assert!(ratio >= 0.5, "{name}: {ratio}");
        }
    }
}

#[test]
fn the_sweep_gives_the_same_bits_with_any_number_of_threads() {
    for (name, mesh) in meshes() {
        let k = Stencil::new(&mesh);
        let (d, w) = wild(&k);
        let m = GaussSeidel::new(&normal_matrix(&k, &d, &w));
        let r = random_rows::<3>(d.len(), &mut rng(36));
        let bits = |threads| -> Vec<[u64; 3]> {
            let mut x = vec![Row::ZERO; r.len()];
            with_threads(Some(threads), || m.solve(&mut x, |v| r[v])).unwrap();
            x.iter().map(|row| row.0.map(f64::to_bits)).collect()
        };
        assert!(bits(1) == bits(4), "{name}");
    }
}
