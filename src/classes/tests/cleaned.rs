//! Small parts are absorbed, holes are filled, and the energy that is reported is that of the labels.

use ndarray::Array2;

use super::{go, random_costs, request};
use crate::classes::{Cleaning, Labeling, label};
use crate::domain::{Domain, Element};
use crate::mesh::Mesh;
use crate::mesh::dual::Dual;
use crate::relaxation::Relaxation;
use crate::rounding::cut_energy;
use crate::samples::{assert_within, disjoint, shape};
use crate::seeds::Seeds;

/// The areas of the parts of labels, by another search than that of the code: labels spread until nothing changes.
fn parts(domain: Domain<'_>, labels: &[u8]) -> Vec<f64> {
    let mut root: Vec<usize> = (0..labels.len()).collect();
    loop {
        let mut changed = false;
        for j in 0..domain.terms() {
            let corners = domain.corners(j).map(|v| v as usize);
            for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, k)| (corners[i], corners[k])) {
                if labels[a] == labels[b] && root[a] != root[b] {
                    let least = root[a].min(root[b]);
                    (root[a], root[b]) = (least, least);
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    let areas = domain.cell_areas();
    let mut sums = vec![0.0; labels.len()];
    root.iter().zip(areas).for_each(|(&root, area)| sums[root] += area);
    sums.into_iter().filter(|area| *area > 0.0).collect()
}

fn cleaned(
    mesh: &Mesh,
    s: &Array2<f64>,
    on: Element,
    lambda: f64,
    cleaning: Cleaning,
) -> (Vec<u8>, crate::classes::ClassLabels) {
    let seeds = &Seeds::default();
    let labeling = Labeling { on, contrast: None, seeds, cleaning };
    let found = label(mesh, s, &labeling, &request(lambda, 1e-5), &mut go).unwrap();
    (found.solution.labels.iter().map(|&p| p as u8).collect(), found)
}

#[test]
fn no_part_is_smaller_than_asked_and_the_energy_is_that_of_the_labels() {
    let mesh = shape("torus:30x20");
    let dual = Dual::new(&mesh);
    for on in [Element::Vertices, Element::Faces] {
        let domain = match on {
            Element::Vertices => Domain::Vertices(&mesh),
            Element::Faces => Domain::Faces(&dual),
        };
        let s = random_costs(on.count(&mesh), 3, 1501);
        let lambda = 0.005;
        let min_area = 0.02 * mesh.area();
        let (plain, before) = cleaned(&mesh, &s, on, lambda, Cleaning::default());
        assert!(before.cleaned.is_none());
        assert!(parts(domain, &plain).iter().any(|area| *area < min_area));
        let cleaning = Cleaning { min_area: Some(min_area), ..Cleaning::default() };
        let (labels, found) = cleaned(&mesh, &s, on, lambda, cleaning);
        assert!(parts(domain, &labels).iter().all(|area| *area >= min_area), "{on:?}");
        let areas = domain.cell_areas();
        let data: f64 =
            labels.iter().enumerate().map(|(k, &p)| areas[k] * s[[k, usize::from(p)]]).sum();
        let energy = data + cut_energy(domain, Relaxation::Separate, lambda, &labels);
        let (summary, record) = (&found.solution.summary, found.cleaned.unwrap());
        assert_within(summary.rounded_energy, energy, 1e-11, energy);
        assert_eq!(record.energy_after, summary.rounded_energy);
        assert_eq!(record.energy_before, before.solution.summary.rounded_energy);
        // Minimal labels cannot become better than the bound for labels.
        let bound = summary.rounding.as_ref().unwrap().label_bound;
        assert!(record.energy_after >= bound && summary.rounded_relative_gap >= 0.0);
        let changed = labels.iter().zip(&plain).filter(|(a, b)| a != b).count();
        assert!(record.parts > 0 && record.parts <= changed && record.area > 0.0);
    }
}

/// A hole within one label is filled; a part between two labels stays.
#[test]
fn only_holes_are_filled() {
    let mesh = shape("grid:30x10");
    let middle = |j: usize| {
        let [a, b, c] = mesh.corners(j);
        (a.coords + b.coords + c.coords) / 3.0
    };
    // Two halves, a hole in the left one, and a part on the line between them.
    let class = |j: usize| {
        let x = middle(j);
        let near = |cx: f64| (x.x - cx).abs() < 0.07 && (x.y - 0.17).abs() < 0.07;
        if near(0.2) || near(0.5) { 2 } else { usize::from(x.x > 0.5) }
    };
    let s =
        Array2::from_shape_fn((mesh.faces.len(), 3), |(j, p)| f64::from(u8::from(p != class(j))));
    let hole = |j: usize| (middle(j).x - 0.2).abs() < 0.04 && (middle(j).y - 0.17).abs() < 0.04;
    let between = |j: usize| (middle(j).x - 0.5).abs() < 0.04 && (middle(j).y - 0.17).abs() < 0.04;
    let inside = |labels: &[u8], set: &dyn Fn(usize) -> bool| -> Vec<u8> {
        (0..labels.len()).filter(|&j| set(j)).map(|j| labels[j]).collect()
    };
    let filling = Cleaning { fill_holes: Some(0.1 * mesh.area()), ..Cleaning::default() };
    let (labels, _) = cleaned(&mesh, &s, Element::Faces, 1e-4, filling);
    assert!(inside(&labels, &hole).iter().all(|&p| p == 0) && !inside(&labels, &hole).is_empty());
    assert!(inside(&labels, &between).iter().all(|&p| p == 2));
    let absorbing = Cleaning { min_area: Some(0.1 * mesh.area()), ..Cleaning::default() };
    let (labels, _) = cleaned(&mesh, &s, Element::Faces, 1e-4, absorbing);
    assert!(labels.iter().all(|&p| p < 2));
}

/// A component takes the label of its seeds; with several of them it stays as it is.
#[test]
fn components_take_the_labels_of_their_seeds() {
    let mesh = disjoint([shape("sphere:2"), shape("grid:5x4")]);
    let s = random_costs(mesh.faces.len(), 3, 1503);
    let first = shape("sphere:2").faces.len();
    let mut regions = vec![None; mesh.faces.len()];
    (regions[5], regions[first], regions[first + 30]) = (Some(2), Some(0), Some(1));
    let seeds = &Seeds::new(regions);
    let cleaning = Cleaning { one_per_component: true, ..Cleaning::default() };
    let labeling = Labeling { on: Element::Faces, contrast: None, seeds, cleaning };
    let found = label(&mesh, &s, &labeling, &request(1e-3, 1e-5), &mut go).unwrap();
    assert!(found.faces.iter().take(first).all(|&p| p == 2));
    assert_eq!((found.faces[first], found.faces[first + 30]), (0, 1));
}

/// One label per component is the best constant one.
#[test]
fn components_get_one_label() {
    let mesh = disjoint([shape("sphere:2"), shape("torus:9x7"), shape("grid:5x4")]);
    let s = random_costs(mesh.faces.len(), 4, 1502);
    let cleaning = Cleaning { one_per_component: true, ..Cleaning::default() };
    let (labels, found) = cleaned(&mesh, &s, Element::Faces, 1e-3, cleaning);
    let (first, second) = (shape("sphere:2").faces.len(), shape("torus:9x7").faces.len());
    for range in [0..first, first..first + second, first + second..mesh.faces.len()] {
        let total =
            |p: usize| -> f64 { range.clone().map(|j| mesh.face_area(j) * s[[j, p]]).sum() };
        let best = (1..4).fold(0, |best, p| if total(p) < total(best) { p } else { best });
        assert!(range.clone().all(|j| usize::from(labels[j]) == best));
    }
    assert!(found.cleaned.unwrap().energy_after >= found.solution.summary.dual_bound);
}
