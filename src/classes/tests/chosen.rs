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
        let given = (s, Element::Faces);
        lambda::of_costs(mesh, given, Element::Faces, &request(0.0, 1e-4), &mut go)
            .unwrap()
            .unwrap()
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

/// Labels on faces and on vertices, with the lambda that is chosen, recover four parts of a torus from costs of which
/// the cheapest is wrong on a large part.
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
    for on in [Element::Faces, Element::Vertices] {
        let given = (&costs.s, costs.of);
        let lambda = lambda::of_costs(&mesh, given, on, &request(0.0, 1e-4), &mut go);
        let lambda = lambda.unwrap().unwrap();
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

/// One vote per face, of which a fifth is wrong, and a region of a thirtieth of the surface: few faces stay wrong.
#[test]
fn a_small_region_in_noisy_labels_is_found() {
    let mesh = shape("torus:100x60");
    let middle = |j: usize| mesh.corners(j).iter().map(|x| x.x).sum::<f64>() / 3.0;
    let mut sorted: Vec<f64> = (0..mesh.faces.len()).map(middle).collect();
    sorted.sort_by(f64::total_cmp);
    let from = sorted[sorted.len() * 97 / 100];
    let mut rng = rng(1103);
    let truth: Vec<bool> = (0..mesh.faces.len()).map(|j| middle(j) > from).collect();
    let vote: Vec<bool> = truth.iter().map(|&p| p != (rng.random::<f64>() < 0.2)).collect();
    let s = Array2::from_shape_fn(
        (truth.len(), 2),
        |(j, p)| if vote[j] == (p == 1) { 0.1 } else { 2.3 },
    );
    for on in [Element::Faces, Element::Vertices] {
        let request = request(0.0, 1e-4);
        let given = (&s, Element::Faces);
        let lambda = lambda::of_costs(&mesh, given, on, &request, &mut go).unwrap().unwrap();
        let costs = ClassCosts { s: s.clone(), of: Element::Faces }.on(on, &mesh);
        let seeds = &Seeds::default();
        let labeling = Labeling { on, contrast: None, seeds, cleaning: Cleaning::default() };
        let request = crate::request::Request { lambda, ..request };
        let found = label(&mesh, &costs, &labeling, &request, &mut go).unwrap();
        let wrong = found.faces.iter().zip(&truth).filter(|&(&p, &q)| (p == 1) != q).count();
        assert!(wrong < mesh.faces.len() / 100, "{on:?}: {wrong} with {lambda}");
    }
}
