//! The default lambda: it follows the units of costs and lengths, and loses no class that matters.

use ndarray::Array2;
use rand::RngExt;
use rand_distr::StandardNormal;

use super::{go, request};
use crate::classes::{ClassCosts, Cleaning, Labeling, label, lambda};
use crate::domain::Element;
use crate::mesh::Mesh;
use crate::samples::{assert_within, rng, shape};
use crate::seeds::Seeds;

/// The true class of each face of a torus, four of them.
fn truth(mesh: &Mesh) -> Vec<usize> {
    let side = |j: usize| {
        let [a, b, c] = mesh.corners(j);
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        2 * usize::from(middle.x > 0.0) + usize::from(middle.y > 0.0)
    };
    (0..mesh.faces.len()).map(side).collect()
}

fn noisy(truth: &[usize], m: usize, noise: f64, seed: u64) -> Array2<f64> {
    let mut rng = rng(seed);
    Array2::from_shape_fn((truth.len(), m), |(j, p)| {
        let clean = if truth[j] == p { 0.0 } else { 1.0 };
        clean + noise * rng.sample::<f64, _>(StandardNormal)
    })
}

#[test]
fn lambda_has_the_units_of_cost_times_length() {
    let mesh = shape("torus:60x40");
    let s = noisy(&truth(&mesh), 4, 1.5, 1101);
    let chosen = |mesh: &Mesh, s: &Array2<f64>| {
        lambda::of_costs(mesh, (s, Element::Faces), &request(0.0, 1e-4), &mut go).unwrap()
    };
    let one = chosen(&mesh, &s);
    assert!(one > 0.0);
    assert_within(chosen(&mesh.clone().scaled(7.0), &s), 7.0 * one, 1e-9, one);
    assert_within(chosen(&mesh, &(&s * 3.0)), 3.0 * one, 1e-9, one);
    assert_within(chosen(&mesh, &(&s + 5.0)), one, 1e-9, one);
    // One class is cheapest everywhere: nothing to cut.
    let flat = Array2::from_shape_fn((mesh.faces.len(), 2), |(_, p)| p as f64);
    assert_eq!(chosen(&mesh, &flat), 0.0);
}

/// Labels on faces and on vertices, with the lambda that is chosen, recover four parts of a torus from costs of which the
/// cheapest is wrong on a large part.
#[test]
fn noisy_classes_are_recovered() {
    let mesh = shape("torus:60x40");
    let truth = truth(&mesh);
    let s = noisy(&truth, 4, 1.5, 1102);
    let right = |labels: &mut dyn Iterator<Item = usize>| {
        let right = labels.zip(&truth).filter(|(p, q)| p == *q).count();
        right as f64 / truth.len() as f64
    };
    let cheapest =
        |j: usize| (1..4).fold(0, |best, p| if s[[j, p]] < s[[j, best]] { p } else { best });
    assert!(right(&mut (0..truth.len()).map(cheapest)) < 0.6);
    let costs = ClassCosts { s: s.clone(), of: Element::Faces };
    let lambda =
        lambda::of_costs(&mesh, (&s, Element::Faces), &request(0.0, 1e-4), &mut go).unwrap();
    for on in [Element::Faces, Element::Vertices] {
        let s = costs.on(on, &mesh);
        let seeds = &Seeds::default();
        let labeling = Labeling { on, contrast: None, seeds, cleaning: Cleaning::default() };
        let found = label(&mesh, &s, &labeling, &request(lambda, 1e-4), &mut go).unwrap();
        assert_eq!(found.vertices.len(), mesh.vertices.len());
        let share = right(&mut found.faces.iter().map(|&p| p as usize));
        // Cuts of labels of vertices run through faces, of which one in thirty is at a border here.
        let least = if on == Element::Faces { 0.97 } else { 0.95 };
        assert!(share > least, "{on:?}: {share}");
    }
}
