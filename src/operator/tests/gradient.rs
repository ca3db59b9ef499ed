//! K is A times the gradient: adjointness, constants, linear functions, four formulas, both operators.

use nalgebra::{Matrix3x2, Vector3};

use super::{OnAny, column};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Adjoint, Matrix, Operator, Stencil};
use crate::samples::{
    assert_within, bumpy, flipped, needles, random_rotation, random_rows, random_tangents,
    random_vector, rng, shape, zoo,
};

/// <K u, q> = c <u, K^T q> with c = 1, where c is fitted over many pairs to detect a wrong scale; the residual of each
/// pair is small relative to the sum of the absolute terms.
struct Adjointness;

impl OnAny for Adjointness {
    fn check<K: Operator>(&self, name: &str, k: &K) {
        let mut rng = rng(1);
        let (mut cross, mut square) = (0.0, 0.0);
        for _ in 0..8 {
            let u = random_rows::<3>(k.vertices(), &mut rng);
            let q = random_tangents::<3>(k.faces(), &mut rng);
            let left: Vec<f64> = (0..k.faces()).map(|j| k.at(&u, j).dot(q[j])).collect();
            let right: Vec<f64> =
                (0..k.vertices()).map(|v| k.adjoint().at(&q, v).dot(u[v])).collect();
            let size: f64 = left.iter().chain(&right).map(|x| x.abs()).sum();
            let (left, right) = (left.iter().sum::<f64>(), right.iter().sum::<f64>());
            assert!((left - right).abs() <= 1e-13 * size, "{name}: {left:e} {right:e}");
            cross += left * right;
            square += right * right;
        }
        assert!(square > 0.0, "{name}");
        assert!((cross / square - 1.0).abs() <= 1e-11, "{name}: scale {}", cross / square);
    }
}

#[test]
fn the_adjoint_is_the_adjoint() {
    zoo().iter().for_each(|(name, mesh)| Adjointness.on_both(name, mesh));
}

/// K 1 = 0, up to the rounding error of the largest column.
struct Constants;

impl OnAny for Constants {
    fn check<K: Operator>(&self, name: &str, k: &K) {
        let ones = vec![Row([1.0, -2.5, 1e3]); k.vertices()];
        for j in 0..k.faces() {
            let column = k.face(j).columns.map(|[a, b]| a.hypot(b)).into_iter().fold(0.0, f64::max);
            assert!(k.at(&ones, j).norm() <= 1e-12 * column, "{name}, face {j}");
        }
    }
}

#[test]
fn constants_have_no_gradient() {
    zoo().iter().for_each(|(name, mesh)| Constants.on_both(name, mesh));
}

/// A linear function of space: |(K u)_j| = A_j |tangential part of its gradient|, and K u is linear in the
/// gradient with the inner products of the tangential parts.
#[test]
fn linear_functions_are_exact() {
    let mut rng = rng(2);
    let mut plane = shape("grid:7x5");
    let turn = random_rotation(&mut rng);
    plane.vertices.iter_mut().for_each(|x| *x = turn * *x + Vector3::new(3.0, -1.0, 2.0));
    for (name, mesh) in [("plane", plane.clone()), ("flipped", flipped(plane)), ("bumpy", bumpy(7))]
    {
        let (g, h) = (random_vector(&mut rng), random_vector(&mut rng));
        let linear =
            |g: &Vector3<f64>| column(mesh.vertices.iter().map(|x| g.dot(&x.coords) + 0.7));
        let k = Stencil::new(&mesh);
        let (u, w) = (linear(&g), linear(&h));
        for j in 0..mesh.faces.len() {
            let area = mesh.face_area(j);
            let normal = mesh.area_vector(j) / area;
            let tangential = |g: &Vector3<f64>| g - normal * normal.dot(g);
            let size = area * g.norm();
            assert_within(k.at(&u, j).norm(), area * tangential(&g).norm(), 1e-12, size);
            let product = area * area * tangential(&g).dot(&tangential(&h));
            assert_within(k.at(&u, j).dot(k.at(&w, j)), product, 1e-12, size * area * h.norm());
            assert_within(k.area(j), area, 1e-13, area);
            assert!(size > 0.0, "{name}");
        }
    }
}

/// A |grad| of nodal values on one triangle, by four formulas.
fn routes(mesh: &Mesh, j: usize, values: [f64; 3]) -> [f64; 4] {
    let x = mesh.corners(j);
    let (a, b) = (x[1] - x[0], x[2] - x[0]);
    let (ua, ub) = (values[1] - values[0], values[2] - values[0]);
    let area = mesh.face_area(j);
    // n x e / 2, summed over the corners.
    let normal = mesh.area_vector(j) / area;
    let edges = [x[2] - x[1], x[0] - x[2], x[1] - x[0]];
    let in_space: Vector3<f64> =
        edges.iter().zip(values).map(|(e, u)| normal.cross(e) * (0.5 * u)).sum();
    // (1/2) sqrt(ua^2 G - 2 ua ub F + ub^2 E), equation (7), with E, F, G of the edges a, b.
    let (e, f, g) = (a.norm_squared(), a.dot(&b), b.norm_squared());
    let paper = 0.5 * (ua * ua * g - 2.0 * ua * ub * f + ub * ub * e).sqrt();
    // The shortest vector with <grad, a> = ua, <grad, b> = ub.
    let map = Matrix3x2::from_columns(&[a, b]);
    let gram = map.transpose() * map;
    let gradient = map * gram.try_inverse().unwrap() * nalgebra::Vector2::new(ua, ub);
    // Barycentric: phi_k falls from 1 at corner k to 0 on the line through the other two.
    let barycentric: Vector3<f64> = (0..3)
        .map(|i| {
            let (p, e) = (x[(i + 1) % 3], edges[i]);
            let height = x[i] - p - e * ((x[i] - p).dot(&e) / e.norm_squared());
            height * (values[i] / height.norm_squared())
        })
        .sum();
    [in_space.norm(), paper, area * gradient.norm(), area * barycentric.norm()]
}

#[test]
fn four_formulas_agree_with_both_operators() {
    let mut rng = rng(3);
    for mesh in [
        shape("sphere:2"),
        shape("torus:16x10"),
        bumpy(8),
        bumpy(6).scaled(1e-4),
        bumpy(6).scaled(1e4),
    ] {
        let u = random_rows::<2>(mesh.vertices.len(), &mut rng);
        let (stencil, matrix) = (Stencil::new(&mesh), Matrix::new(&mesh));
        for j in 0..mesh.faces.len() {
            for p in 0..2 {
                let by_region = |t: crate::field::Tangent<2>| t.0[0].0[p].hypot(t.0[1].0[p]);
                let expected = by_region(stencil.at(&u, j));
                let values = mesh.faces[j].map(|v| u[v as usize].0[p]);
                let size = mesh.face_area(j).sqrt();
                for route in routes(&mesh, j, values) {
                    assert_within(expected, route, 1e-11, size);
                }
                assert_within(expected, by_region(matrix.at(&u, j)), 1e-12, size);
            }
        }
    }
}

/// The same rows, columns and adjoint rows, where both frames start along the edge 12. On needles the formulas differ
/// by the rounding error of the normal, which depends on the aspect ratio of the face.
#[test]
fn stencil_and_matrix_agree() {
    let mut random = rng(4);
    let extreme =
        [("aspect 1e-3", needles(4, 1e-3), 1e-11), ("aspect 1e-6", needles(4, 1e-6), 1e-8)];
    let ordinary =
        zoo().into_iter().filter(|(name, _)| *name != "needles").map(|(n, m)| (n, m, 1e-11));
    for (name, mesh, tolerance) in ordinary.chain(extreme) {
        let (stencil, matrix) = (Stencil::new(&mesh), Matrix::new(&mesh));
        assert_eq!((stencil.faces(), stencil.vertices()), (matrix.faces(), matrix.vertices()));
        let u = random_rows::<3>(mesh.vertices.len(), &mut random);
        let q = random_tangents::<3>(mesh.faces.len(), &mut random);
        for j in 0..mesh.faces.len() {
            let (a, b) = (stencil.face(j), matrix.face(j));
            assert_eq!(a.corners, b.corners, "{name}");
            let size = a.columns.map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
            for (a, b) in a.columns.iter().flatten().zip(b.columns.iter().flatten()) {
                assert!(
                    (a - b).abs() <= tolerance * size,
                    "{name}, face {j}: {a:e} {b:e} of {size:e}"
                );
            }
            let difference = stencil.at(&u, j) - matrix.at(&u, j);
            assert!(difference.norm() <= 4.0 * tolerance * size, "{name}, face {j}");
            assert_within(stencil.area(j), matrix.area(j), tolerance, matrix.area(j));
        }
        let size = mesh.area().sqrt() / (mesh.faces.len() as f64).sqrt();
        for v in 0..mesh.vertices.len() {
            let difference = stencil.adjoint().at(&q, v) - matrix.adjoint().at(&q, v);
            assert!(difference.max_abs() <= 100.0 * tolerance * size, "{name}, vertex {v}");
        }
    }
}
