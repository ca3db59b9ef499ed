//! Restriction is the adjoint of prolongation, and prolonged U and q are feasible.

use nalgebra::Vector3;
use rand::RngExt;
use strum::IntoEnumIterator;

use super::*;
use crate::mesh::geometry::barycentric_areas;
use crate::operator::{Operator, Stencil};
use crate::samples::{
    assert_within, bumpy, flipped, known_optimum_in, random_dual, random_dual_in, random_labels,
    random_rows, rng, shape, zoo,
};

/// <P u, f> = <u, P^T f>.
#[test]
fn restriction_is_the_adjoint_of_prolongation() {
    for (name, mesh) in zoo() {
        let level = mesh.coarsened();
        let mut rng = rng(31);
        let u = random_rows::<3>(level.mesh.vertices.len(), &mut rng);
        let f = random_rows::<3>(mesh.vertices.len(), &mut rng);
        let dot =
            |a: &[Row<3>], b: &[Row<3>]| -> f64 { a.iter().zip(b).map(|(a, &b)| a.dot(b)).sum() };
        let fine = dot(&prolong(&level.parents, &u), &f);
        assert_within(dot(&u, &restrict(&level, &f)), fine, 1e-13, mesh.vertices.len() as f64);
        let total = |f: &[Row<3>]| f.iter().fold(Row::ZERO, |sum, &f| sum + f);
        let lost = (total(&restrict(&level, &f)) - total(&f)).max_abs();
        assert!(lost <= 1e-13 * f.len() as f64, "{name}: {lost}");
    }
}

/// A label that only some vertices forbid contributes their most expensive allowed cost; one that all of them forbid is
/// forbidden at the coarse vertex.
#[test]
fn restriction_keeps_labels_forbidden() {
    for (name, mesh) in zoo() {
        let level = mesh.coarsened();
        let mut rng = rng(41);
        let f: Vec<Row<3>> = random_rows(mesh.vertices.len(), &mut rng)
            .into_iter()
            .map(|f: Row<3>| {
                Row::from_fn(|p| {
                    if p > 0 && rng.random::<f64>() < 0.7 { FORBIDDEN_COST } else { f.0[p] }
                })
            })
            .collect();
        for (c, coarse) in restrict(&level, &f).into_iter().enumerate() {
            let shares = level.parents.iter().zip(&f).flat_map(|(parents, f)| {
                let own = parents.corners.iter().zip(parents.weights);
                own.filter(|&(&corner, w)| corner as usize == c && w > 0.0)
                    .map(move |(_, w)| (w, f))
            });
            let shares: Vec<(f64, &Row<3>)> = shares.collect();
            for p in 0..3 {
                if shares.iter().all(|(_, f)| f.0[p] == FORBIDDEN_COST) {
                    assert_eq!(coarse.0[p], FORBIDDEN_COST, "{name}");
                    continue;
                }
                let most_expensive = |f: &Row<3>| {
                    f.0.into_iter().filter(|&x| x < FORBIDDEN_COST).fold(-2.0, f64::max)
                };
                let cost =
                    |f: &Row<3>| if f.0[p] == FORBIDDEN_COST { most_expensive(f) } else { f.0[p] };
                let exact: f64 = shares.iter().map(|&(w, f)| w * cost(f)).sum();
                assert!((coarse.0[p] - exact).abs() <= 1e-13 * shares.len() as f64, "{name}");
            }
        }
    }
}

/// Area-weighted means at the vertices keep the integral over the faces: barycentric areas sum to the area of the
/// faces.
#[test]
fn means_at_the_vertices_keep_the_integral() {
    for (name, mesh) in zoo() {
        let q = random_dual::<2>(mesh.faces.len(), 1.0, &mut rng(42));
        let (mut faces, mut vertices) = ([Row::<2>::ZERO; 3], [Row::<2>::ZERO; 3]);
        let areas = barycentric_areas(&mesh);
        for (mean, a) in vertex_means(&mesh, &q).iter().zip(areas) {
            (0..3).for_each(|i| vertices[i] += mean[i] * a);
        }
        for (j, Tangent([q1, q2])) in q.into_iter().enumerate() {
            let ([e1, e2], a) = (frame(&mesh, j), mesh.face_area(j));
            (0..3).for_each(|i| faces[i] += (q1 * e1[i] + q2 * e2[i]) * a);
        }
        for (a, b) in vertices.into_iter().zip(faces) {
            assert!((a - b).max_abs() <= 1e-12 * mesh.area(), "{name}: {a:?} {b:?}");
        }
    }
}

/// Prolonged rows stay in the simplex of the active regions, tangents in the ball, and D(q) <= E* <= E(u).
#[test]
fn prolonged_pairs_are_feasible() {
    for (name, mesh) in zoo() {
        let level = mesh.coarsened();
        if level.mesh.faces.is_empty() {
            continue;
        }
        let lambda = 0.1 * mesh.area().sqrt();
        for relaxation in Relaxation::iter() {
            let known = known_optimum_in::<12>(relaxation, &mesh, 9, lambda, 1.0, 32);
            let mut rng = rng(33);
            let u = random_labels::<12>(level.mesh.vertices.len(), 9, &mut rng);
            let faces = level.mesh.faces.len();
            let q = random_dual_in::<12>(relaxation, faces, lambda, &mut rng).into_iter();
            let active = |row: Row<12>| Row::from_fn(|p| if p < 9 { row.0[p] } else { 0.0 });
            let q: Vec<_> = q.map(|q| Tangent(q.0.map(active))).collect();
            let u = prolong(&level.parents, &u);
            let q = prolong_dual(&level, &mesh, &q, (lambda, relaxation));
            for row in &u {
                let sum: f64 = row.0.iter().sum();
                assert!((sum - 1.0).abs() <= 1e-14 && row.min() >= 0.0, "{name}");
                assert!(row.0[9..] == [0.0; 3], "{name}");
            }
            let allowed = lambda * (1.0 + 1e-14);
            with_set!(relaxation, set => assert!(q.iter().all(|&q| set.gauge(q) <= allowed)));
            let slack = 1e-12 * known.problem.spread();
            assert!(known.problem.dual_bound(&q) <= known.energy + slack, "{name}");
            assert!(known.problem.energy(&u) >= known.energy - slack, "{name}");
        }
    }
}

/// If every |q_j| = lambda and neighboring q_j are nearly parallel, prolonged tangents have nearly norm lambda, and
/// none is larger.
#[test]
fn prolonged_dual_fields_keep_their_norm() {
    for mesh in [shape("grid:20x14"), shape("sphere:4"), shape("torus:60x40").scaled(1e3)] {
        let level = mesh.coarsened();
        let lambda = 0.37 * mesh.area().sqrt();
        let q: Vec<Tangent<2>> = (0..level.mesh.faces.len())
            .map(|j| {
                let field = [Vector3::new(0.3, 0.8, -0.5), Vector3::new(-0.2, 0.4, 0.7)];
                let along = frame(&level.mesh, j).map(|e| Row::from_fn(|p| field[p].dot(&e)));
                Tangent(along) * (lambda / Tangent(along).norm())
            })
            .collect();
        let fine = prolong_dual(&level, &mesh, &q, (lambda, Relaxation::Frobenius));
        let norms: Vec<f64> = fine.iter().map(|q| q.norm() / lambda).collect();
        assert!(norms.iter().all(|&norm| norm <= 1.0 + 1e-14));
        let mean = norms.iter().sum::<f64>() / norms.len() as f64;
        assert!(mean > 0.95, "{mean}");
    }
}

/// On a flat mesh, a field of one vector in space per region is prolonged exactly.
#[test]
fn a_constant_field_stays_constant() {
    let mesh = flipped(shape("grid:20x14"));
    let level = mesh.coarsened();
    let field = [Vector3::new(0.3, 0.1, 0.0), Vector3::new(-0.2, 0.4, 0.0)];
    let on = |mesh: &Mesh| -> Vec<Tangent<2>> {
        let tangent = |j| Tangent(frame(mesh, j).map(|e| Row::from_fn(|p| field[p].dot(&e))));
        (0..mesh.faces.len()).map(tangent).collect()
    };
    let fine = prolong_dual(&level, &mesh, &on(&level.mesh), (1.0, Relaxation::Frobenius));
    for (q, exact) in fine.into_iter().zip(on(&mesh)) {
        assert!((q + exact * -1.0).norm() <= 1e-14);
    }
}

/// The frame is that of K: for a linear function u, the rows of K u are the coordinates of A grad u in it.
#[test]
fn the_frame_is_that_of_the_operator() {
    let gradient = Vector3::new(0.3, -0.7, 0.2);
    for (name, mesh) in [("bumpy", bumpy(6)), ("flipped", flipped(shape("sphere:2")))] {
        let k = Stencil::new(&mesh);
        let u: Vec<Row<1>> = mesh.vertices.iter().map(|x| Row([gradient.dot(&x.coords)])).collect();
        for j in 0..mesh.faces.len() {
            let Tangent([a, b]) = k.at(&u, j);
            let [e1, e2] = frame(&mesh, j).map(|e| k.area(j) * gradient.dot(&e));
            let error = f64::max((a.0[0] - e1).abs(), (b.0[0] - e2).abs());
            assert!(error <= 1e-13 * k.area(j).sqrt(), "{name}: {error}");
        }
    }
}
