//! Surfaces that evolve, from photographs of surfaces that are known.

use std::ops::ControlFlow;

use nalgebra::Point3;

use crate::data::views::synthetic::{Light, Paint, Photograph, Studio};
use crate::data::views::{Ball, Picture, View, around};
use crate::evolve::images::{Background, Shot};
use crate::evolve::start::sphere;
use crate::evolve::{self, End, Event, Plan, Reconstruction, Step, reconstruct};
use crate::mesh::Mesh;
use crate::samples::shape;
use crate::sweep::with_threads;

const BACKGROUND: [f64; 3] = [0.9; 3];
const COLORS: [[f64; 3]; 3] = [[0.55, 0.25, 0.25], [0.25, 0.5, 0.3], [0.3, 0.3, 0.6]];

/// Width and height of the images in pixels.
const SIZE: [usize; 2] = [120, 90];

/// A fine ellipsoid.
fn ellipsoid() -> Mesh {
    let mut mesh = shape("sphere:5");
    mesh.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x, 0.8 * x.y, 0.65 * x.z));
    mesh
}

/// Three regions in waves.
fn labels(mesh: &Mesh) -> Vec<usize> {
    let label = |x: &Point3<f64>| {
        let waves = [
            (3.0 * x.x + (2.0 * x.y).sin()).sin(),
            (2.7 * x.y + (2.0 * x.z).cos()).sin(),
            (3.0 * x.z + (2.0 * x.x).sin()).sin(),
        ];
        (1..3).fold(0, |best, p| if waves[p] > waves[best] { p } else { best })
    };
    mesh.vertices.iter().map(label).collect()
}

/// Photographs of a labeled surface in a ball of radius 1 by n cameras, in front of a bright background.
fn shots(mesh: &Mesh, labels: &[usize], n: usize, noise: f64) -> Vec<Shot> {
    lit_shots(mesh, labels, n, noise, Light::default())
}

fn lit_shots(mesh: &Mesh, labels: &[usize], n: usize, noise: f64, light: Light) -> Vec<Shot> {
    let ball = Ball { center: Point3::origin(), radius: 1.0 };
    let views = around(&ball, n, 4.0, SIZE.map(|n| n as u32)).unwrap();
    let paint = Paint::Regions { labels, colors: &COLORS };
    let studio = Studio { mesh, paint, light, background: BACKGROUND, samples: 3, noise, seed: 1 };
    let photographs = studio.photographs(&views).unwrap();
    let shot = |(view, photograph): (View, Photograph)| Shot {
        view,
        picture: Picture::of_bytes(SIZE[0], SIZE[1], photograph.bytes()),
        background: Background::Color(BACKGROUND),
    };
    views.into_iter().zip(photographs).map(shot).collect()
}

fn evolved(
    shots: &[Shot],
    start: &Mesh,
    truth: &Mesh,
    plan: &Plan,
    mut watch: impl FnMut(&Step) -> ControlFlow<()>,
) -> Reconstruction {
    reconstruct(shots, start, Some(truth), plan, &mut |event| {
        Ok(match event {
            Event::Step(step, _) => watch(step),
            _ => ControlFlow::Continue(()),
        })
    })
    .unwrap()
}

fn go_on(_: &Step) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn share_of_right_labels(found: &Reconstruction) -> f64 {
    let mesh = &found.surface.mesh;
    let truth = labels(mesh);
    let solution = found.solution.as_ref().unwrap();
    // The regions have the order of their clusters.
    let nearest = |p: usize| {
        let distance = |q: &usize| -> f64 {
            (0..3).map(|i| (found.surface.coloring.mu[p][i] - COLORS[*q][i]).powi(2)).sum()
        };
        (0..3).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let right = solution.labels.iter().zip(&truth).filter(|(p, q)| nearest(**p as usize) == **q);
    right.count() as f64 / truth.len() as f64
}

/// From a sphere, with noise; the labels are certified, and the colors are found.
#[test]
fn a_sphere_becomes_an_ellipsoid() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 16, 0.1);
    let plan = Plan { regions: 3, levels: 2, steps: 40, ..Plan::default() };
    let start = sphere(Point3::origin(), 1.2, 3);
    let found = evolved(&shots, &start, &truth, &plan, go_on);
    let distances = found.distances.unwrap();
    assert!(distances.mean < 1e-3 && distances.back < 1e-3, "{distances:?}");
    assert!(found.quality.silhouette_iou > 0.99, "{:?}", found.quality);
    let folds = found.quality.folds;
    assert_eq!((folds.folded_edges, folds.intersecting_pairs), (0, 0));
    assert!(share_of_right_labels(&found) > 0.96, "{}", share_of_right_labels(&found));
    assert!(found.solution.unwrap().summary.relative_gap <= 1e-4);
}

/// The truth is close to a minimum: the surface stays.
#[test]
fn the_truth_stays() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 16, 0.0);
    let mut start = shape("sphere:4");
    start.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x, 0.8 * x.y, 0.65 * x.z));
    let plan = Plan { regions: 3, levels: 1, steps: 20, ..Plan::default() };
    let found = evolved(&shots, &start, &truth, &plan, go_on);
    let distances = found.distances.unwrap();
    assert!(distances.mean < 5e-4 && distances.back < 5e-4, "{distances:?}");
}

/// Without the background the least energy is that of no surface: even the truth shrinks.
#[test]
fn without_the_background_the_truth_shrinks() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 8, 0.1);
    let mut start = shape("sphere:3");
    start.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x, 0.8 * x.y, 0.65 * x.z));
    let area = |background: bool| {
        let plan = Plan { regions: 3, levels: 1, steps: 30, background, ..Plan::default() };
        evolved(&shots, &start, &truth, &plan, go_on).surface.mesh.area() / start.area()
    };
    let [with, without] = [area(true), area(false)];
    assert!((with - 1.0).abs() < 0.03 && without < 0.9, "{with} {without}");
}

/// While the labels stay, each step lowers the energy, with the smoothing.
#[test]
fn the_energy_never_rises_between_new_labels() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 8, 0.05);
    let start = sphere(Point3::origin(), 0.9, 2);
    for smoothing in [0.0, 0.1, 0.9] {
        let plan = Plan { regions: 3, levels: 1, steps: 25, smoothing, ..Plan::default() };
        let found = evolved(&shots, &start, &truth, &plan, go_on);
        let mut falls = 0;
        for pair in found.trace.windows(2) {
            let [(a, _), (b, _)] = pair else { unreachable!() };
            if b.step % 5 != 0 && a.motion > 0.0 {
                assert!(b.energy < a.energy, "{a:?} {b:?}");
                falls += 1;
            }
        }
        assert!(falls >= 15, "{falls}");
    }
}

/// Colors vary more by the light than by the regions: clusters of colors would mix the regions.
#[test]
fn albedos_are_found_on_the_true_surface() {
    let truth = ellipsoid();
    let labels = labels(&truth);
    let direction = [0.6, 0.8, 0.0];
    let light = Light { direction: Some(direction), ambient: 0.3 };
    let shots = lit_shots(&truth, &labels, 12, 0.02, light);
    let mut start = shape("sphere:4");
    start.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x, 0.8 * x.y, 0.65 * x.z));
    let light = evolve::Light { direction: direction.into(), ambient: 0.3 };
    let plan = Plan { regions: 3, levels: 1, steps: 2, light: Some(light), ..Plan::default() };
    for seed in 0..3 {
        let found = evolved(&shots, &start, &truth, &Plan { seed, ..plan.clone() }, go_on);
        assert!(found.solution.as_ref().unwrap().summary.empty_regions.is_empty());
        let right = share_of_right_labels(&found);
        assert!(right > 0.95, "{right}");
    }
}

/// Rows of the trace describe the surface before their step, the first one the start.
#[test]
fn distances_are_those_of_the_surface_before_the_step() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 4, 0.0);
    let plan = Plan { regions: 3, levels: 1, steps: 2, ..Plan::default() };
    let found = evolved(&shots, &truth, &truth, &plan, go_on);
    assert!(found.trace[0].1.unwrap() <= 1e-15, "{:?}", found.trace[0]);
    assert!(found.trace[1].1.unwrap() > 0.0);
}

/// A dent that no silhouette shows: silhouettes alone leave it closed, regions on it open it.
#[test]
fn silhouettes_alone_do_not_see_a_dent() {
    let depth = |x: &Point3<f64>| {
        let angle = (x.coords.sum() / 3.0_f64.sqrt()).clamp(-1.0, 1.0).acos();
        1.0 - 0.2 * (-(angle / 0.45).powi(2)).exp()
    };
    let sphere_of = |level| shape(&format!("sphere:{level}"));
    let mut truth = sphere_of(5);
    let checks = |x: &Point3<f64>| x.iter().map(|x| (3.0 * x).floor() as i64).sum::<i64>();
    let labels: Vec<usize> =
        truth.vertices.iter().map(|x| checks(x).rem_euclid(2) as usize).collect();
    truth.vertices.iter_mut().for_each(|x| *x *= depth(x));
    let mut shots = shots(&truth, &labels, 16, 0.0);
    let start = sphere_of(3);
    let plan = Plan { regions: 2, levels: 2, steps: 40, ..Plan::default() };
    let seen = evolved(&shots, &start, &truth, &plan, go_on).distances.unwrap();
    // Without colors: the surface is white, and the rest is black.
    for shot in &mut shots {
        let picture = &shot.picture;
        let pixels = (0..picture.width * picture.height).map(|pixel| {
            let color = picture.color(pixel);
            let near = color.iter().zip(BACKGROUND).all(|(c, b)| (c - b).abs() < 0.1);
            [if near { 0 } else { 255 }; 3]
        });
        shot.picture = Picture::of_bytes(SIZE[0], SIZE[1], pixels.collect());
        shot.background = Background::Color([0.0; 3]);
    }
    let plan = Plan { regions: 1, ..plan };
    let blind = evolved(&shots, &start, &truth, &plan, go_on).distances.unwrap();
    assert!(blind.largest > 0.02 && blind.largest > 1.2 * seen.largest, "{blind:?} {seen:?}");
}

/// An interruption ends with the surface reached, and the number of threads changes nothing.
#[test]
fn interrupted_runs_keep_their_surface_and_threads_change_no_bits() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 6, 0.0);
    let plan = Plan { regions: 3, levels: 2, steps: 30, ..Plan::default() };
    let start = sphere(Point3::origin(), 1.1, 2);
    let run = || {
        evolved(&shots, &start, &truth, &plan, |step| match step.step {
            6 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        })
    };
    let one = with_threads(Some(1), run).unwrap();
    let two = with_threads(Some(2), run).unwrap();
    assert_eq!(one.levels.last().unwrap().end, End::Interrupted);
    assert_eq!(one.trace.len(), 7);
    assert_eq!(one.surface.mesh, two.surface.mesh);
    assert_eq!(one.surface.coloring, two.surface.coloring);
    assert_eq!(one.terms, two.terms);
}

#[test]
fn impossible_reconstructions_are_refused() {
    let truth = ellipsoid();
    let shots = shots(&truth, &labels(&truth), 3, 0.0);
    let plan = Plan { regions: 2, steps: 2, ..Plan::default() };
    let start = sphere(Point3::origin(), 1.0, 1);
    let fails = |shots: &[Shot], start: &Mesh, plan: &Plan, clause: &str| {
        let go_on = &mut |_: Event<'_>| Ok(ControlFlow::Continue(()));
        let message = reconstruct(shots, start, None, plan, go_on).err().unwrap().to_string();
        assert!(message.contains(clause) && !message.contains('\n'), "{message}");
    };
    fails(&shots[..1], &start, &plan, "at least two");
    fails(&shots, &sphere(Point3::new(0.0, 90.0, 0.0), 1.0, 1), &plan, "no view sees");
    fails(&shots, &start, &Plan { regions: 65, ..plan.clone() }, "from 1 to 64");
    fails(&shots, &start, &Plan { lambda: f64::NAN, ..plan.clone() }, "lambda");
    fails(&shots, &start, &Plan { beta: -1.0, ..plan.clone() }, "metric");
    fails(&shots, &start, &Plan { beta: 5.1e8, ..plan.clone() }, "metric");
    fails(&shots, &start, &Plan { eta: -1.0, ..plan.clone() }, "roughness");
    let empty = |shot: &Shot| Shot {
        view: shot.view.clone(),
        picture: Picture::of_bytes(SIZE[0], SIZE[1], vec![[230; 3]; SIZE[0] * SIZE[1]]),
        background: Background::Color(BACKGROUND),
    };
    let empty: Vec<Shot> = shots.iter().map(empty).collect();
    fails(&empty, &start, &plan, "color of the background");
}
