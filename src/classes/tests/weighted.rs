//! lambda that varies over the surface.

use ndarray::Array2;

use super::{go, random_costs, request};
use crate::classes::{Cleaning, Labeling, label};
use crate::domain::{Domain, Element};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::operator::{Operator, Stencil};
use crate::problem::Problem;
use crate::relaxation::Relaxation;
use crate::rounding::cut_energy;
use crate::samples::{assert_within, rng, shape, shuffled, zoo};
use crate::seeds::Seeds;
use crate::solve::{Solution, solve_weighted};
use crate::start::Start;
use rand::RngExt;
use strum::IntoEnumIterator;

fn labeled(
    mesh: &Mesh,
    s: &Array2<f64>,
    on: Element,
    contrast: Option<&Contrast>,
    lambda: f64,
) -> Solution {
    let seeds = &Seeds::default();
    let labeling = Labeling { on, contrast, seeds, cleaning: Cleaning::default() };
    label(mesh, s, &labeling, &request(lambda, 1e-7), &mut go).unwrap().solution
}

/// The same weight everywhere is a factor of lambda.
#[test]
fn equal_weights_are_a_factor_of_lambda() {
    let mesh = shape("torus:16x12");
    for on in [Element::Vertices, Element::Faces] {
        let s = random_costs(on.count(&mesh), 3, 1401);
        let three = Contrast::Faces(vec![3.0; mesh.faces.len()]);
        let one = labeled(&mesh, &s, on, Some(&three), 0.01).summary;
        let other = labeled(&mesh, &s, on, None, 0.03).summary;
        assert_within(one.energy, other.energy, 1e-6, other.energy);
        assert_within(one.rounded_energy, other.rounded_energy, 1e-9, other.energy);
    }
}

/// The energy of labels is that of the operator, and weights belong to their faces whatever the numbering.
#[test]
fn weights_belong_to_their_faces() {
    let mut rng = rng(1402);
    for (name, mesh) in zoo() {
        let mesh = mesh.without_degenerate_faces().0.into_owned();
        if mesh.faces.is_empty() {
            continue;
        }
        let w: Vec<f64> = mesh.faces.iter().map(|_| rng.random_range(0.1..3.0)).collect();
        let domain = Domain::Weighted(&mesh, &w);
        let labels: Vec<u8> = mesh.vertices.iter().map(|_| rng.random_range(0..3)).collect();
        let u: Vec<Row<3>> = labels.iter().map(|&p| Row::one_hot(p.into())).collect();
        let (k, plain) = (domain.stencil(), Stencil::new(&mesh));
        for (j, w) in w.iter().enumerate() {
            let norm = k.at(&u, j).norm();
            assert_within(norm, w * plain.at(&u, j).norm(), 1e-12, norm);
            assert_eq!(k.area(j), plain.area(j));
        }
        for relaxation in Relaxation::iter() {
            let f = vec![Row::ZERO; mesh.vertices.len()];
            let problem = Problem::<_, 3>::new(domain.stencil(), f, 0.7).in_relaxation(relaxation);
            let energy = problem.energy(&u);
            assert_within(cut_energy(domain, relaxation, 0.7, &labels), energy, 1e-11, energy);
            assert!(energy.is_finite(), "{name}");
        }
    }
    let mesh = shape("torus:50x40");
    let s = random_costs(mesh.vertices.len(), 2, 1403);
    let w: Vec<f64> = mesh.faces.iter().map(|_| rng.random_range(0.1..3.0)).collect();
    let solved = |mesh: &Mesh, w: &[f64], s: &Array2<f64>| {
        let seeds = &Seeds::default();
        let request = &request(0.02, 1e-7);
        solve_weighted(mesh, Some(w), s, seeds, &Start::Argmin, request, &mut go).unwrap().summary
    };
    let tidy = solved(&mesh, &w, &s);
    let (moved, before) = shuffled(&mesh, &mut rng);
    let rows: Vec<usize> = before.iter().map(|&k| k as usize).collect();
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let index: std::collections::HashMap<[u32; 3], usize> =
        mesh.faces.iter().enumerate().map(|(j, &face)| (sorted(face), j)).collect();
    let w: Vec<f64> = moved
        .faces
        .iter()
        .map(|face| w[index[&sorted(face.map(|v| before[v as usize]))]])
        .collect();
    let other = solved(&moved, &w, &s.select(ndarray::Axis(0), &rows));
    assert_within(other.rounded_energy, tidy.rounded_energy, 1e-11, tidy.rounded_energy);
}

/// Two classes without any evidence between two seeds: the cut goes where it is cheap.
#[test]
fn cuts_go_where_they_are_cheap() {
    let mesh = shape("grid:20x6");
    let middle = |j: usize| mesh.corners(j).iter().map(|x| x.x).sum::<f64>() / 3.0;
    let cheap = |j: usize| (0.2..0.3).contains(&middle(j));
    let w: Vec<f64> = (0..mesh.faces.len()).map(|j| if cheap(j) { 0.1 } else { 1.0 }).collect();
    let contrast = Contrast::Faces(w);
    for on in [Element::Vertices, Element::Faces] {
        let n = on.count(&mesh);
        let x = |k: usize| match on {
            Element::Vertices => mesh.vertices[k].x,
            Element::Faces => middle(k),
        };
        let s = Array2::from_shape_fn((n, 2), |(k, p)| {
            let known = x(k) < 0.1 || x(k) > 0.9;
            if !known {
                f64::NAN
            } else if (x(k) < 0.5) == (p == 0) {
                0.0
            } else {
                100.0
            }
        });
        let found = labeled(&mesh, &s, on, Some(&contrast), 0.01);
        for k in 0..n {
            if !(0.15..0.35).contains(&x(k)) {
                assert_eq!(found.labels[k], i32::from(x(k) > 0.25), "{on:?} {k}");
            }
        }
    }
}

#[test]
fn weights_out_of_range_are_refused() {
    let mesh = shape("grid:3x3");
    let s = random_costs(mesh.vertices.len(), 2, 1404);
    for (w, part) in [
        (vec![1.0; 3], "3 weights, but the mesh has 18 faces"),
        (vec![0.0; 18], "the weight of face 0 is 0.0"),
        (vec![f64::NAN; 18], "positive and finite"),
    ] {
        let seeds = &Seeds::default();
        let found = solve_weighted(
            &mesh,
            Some(&w),
            &s,
            seeds,
            &Start::Argmin,
            &request(0.1, 1e-3),
            &mut go,
        );
        assert!(found.err().unwrap().to_string().contains(part));
    }
}
