//! Contours against the exact areas of polygons: the image of a convex surface is the convex hull of its vertices.

use nalgebra::{Point3, Vector3};

use super::scenes::{Case, cameras, close_cameras, dot, fields, moved};
use crate::evolve::coloring::Coloring;
use crate::evolve::energy::Sampling;
use crate::evolve::images::{Image, Pixel};
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::samples::{disjoint, random_rotation, rng, shape};

/// Twice the signed area and the points of the convex hull of points in the plane (Andrew's monotone chain).
fn hull_area(mesh: &Mesh, range: std::ops::Range<usize>, camera: &Pinhole) -> f64 {
    let mut points: Vec<[f64; 2]> = mesh.vertices[range]
        .iter()
        .map(|&x| {
            let at = camera.project(x);
            [at.x, at.y]
        })
        .collect();
    points.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for c in points {
            while let [.., a, b] = chain[..] {
                if cross(a, b, c) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(c);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    let next = |i: usize| hull[(i + 1) % hull.len()];
    (0..hull.len()).map(|i| hull[i][0] * next(i)[1] - hull[i][1] * next(i)[0]).sum::<f64>() / 2.0
}

/// Images of one color in front of one background.
fn plain(cameras: Vec<Pinhole>, size: usize, color: [f64; 3], background: [f64; 3]) -> Vec<Image> {
    let pixels = vec![Pixel::new(color, background); size * size];
    let image =
        |camera| Image { camera, width: size, height: size, omega: 1.0, pixels: pixels.clone() };
    cameras.into_iter().map(image).collect()
}

fn squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Asserts that the gradient of a case along all fields is the central difference of an exact energy.
fn assert_exact(case: &Case, exact: impl Fn(&Mesh) -> f64, tolerance: f64) {
    let gradient = case.slope().gradient;
    for (name, field) in fields(&case.mesh, &mut rng(9)) {
        let h = 1e-5;
        let [ahead, back] = [h, -h].map(|h| exact(&moved(&case.mesh, &field, h)));
        let difference = (ahead - back) / (2.0 * h);
        let found = dot(&gradient, &field);
        let size: f64 = gradient.iter().zip(&field).map(|(g, v)| g.dot(v).abs()).sum();
        assert!((found - difference).abs() <= tolerance * size, "{name}: {found} {difference}");
    }
}

const SAMPLING: Sampling = Sampling { samples: 4, contour: 64.0 };

/// A convex surface of one color: the energy is an area, and the gradient is that of its contour alone.
#[test]
fn the_contour_of_a_convex_surface_moves_an_area() {
    let mut rng = rng(6);
    let mut mesh = shape("sphere:1").scaled(0.8);
    let rotation = random_rotation(&mut rng);
    mesh.vertices.iter_mut().for_each(|x| *x = rotation * *x);
    let (color, background, mu) = ([0.7, 0.2, 0.4], [0.1, 0.5, 0.6], [0.6, 0.3, 0.1]);
    let cameras = cameras(3, 40);
    let images = plain(cameras.clone(), 40, color, background);
    let coloring = Coloring { u: vec![1.0; mesh.vertices.len()], mu: vec![mu] };
    let mut case =
        Case { images, coloring, sampling: SAMPLING, ..Case::new(mesh, vec![], 1, &mut rng) };
    let exact = |mesh: &Mesh, jump: f64| {
        cameras.iter().map(|camera| jump * hull_area(mesh, 0..mesh.vertices.len(), camera)).sum()
    };
    let jump = squared(color, mu) - squared(color, background);
    assert_exact(&case, |mesh| exact(mesh, jump), 1e-5);
    // Without the background every pixel of the surface costs, and the surface shrinks.
    case.images = case.images.into_iter().map(Image::without_background).collect();
    assert_exact(&case, |mesh| exact(mesh, squared(color, mu)), 1e-5);
    // The visible contours are as long as the hulls.
    let length = case.slope().contour_pixels;
    let radius = 0.9 * 20.0 * (0.8_f64 / 4.0).asin().tan() / (1.0_f64 / 4.0).asin().tan();
    assert!((length / (3.0 * std::f64::consts::TAU * radius) - 1.0).abs() < 0.05, "{length}");
}

/// Where the surface fills all images nothing is a contour, so that contours alone do not move it; the energy is the same.
#[test]
fn contours_alone_do_not_move_a_surface_that_fills_its_images() {
    let mut rng = rng(11);
    let case = Case::new(super::scenes::ellipsoid(), close_cameras(2, 16), 16, &mut rng);
    let case = case.with_samples(4);
    let [whole, contours] = [case.slope(), case.slope_of_contours()];
    // Summed in another order.
    let energy = whole.terms.sum();
    assert!((energy - contours.terms.sum()).abs() <= 1e-13 * energy);
    assert!(whole.gradient.iter().any(|g| g.norm() > 0.0));
    assert!(contours.gradient.iter().all(|g| *g == Vector3::zeros()));
    // Elsewhere they are all there is of a surface of one color.
    let Case { mesh, coloring, .. } = Case::new(shape("sphere:2"), vec![], 1, &mut rng);
    let coloring = Coloring { u: vec![1.0; mesh.vertices.len()], mu: coloring.mu[..1].to_vec() };
    let plain = Case::new(mesh, cameras(2, 24), 24, &mut rng).with_samples(4);
    let plain = Case { coloring, ..plain };
    assert_eq!(plain.slope().gradient, plain.slope_of_contours().gradient);
}

/// In front of another surface, what comes into view is that surface, not the background.
#[test]
fn behind_a_contour_is_the_next_surface() {
    let mut rng = rng(7);
    let cameras = cameras(1, 40);
    let towards = cameras[0].center().coords.normalize();
    let large = shape("sphere:1").scaled(0.8);
    let n = large.vertices.len();
    for (shift, in_front) in [(1.3, true), (-1.3, false)] {
        let mut small = shape("sphere:1").scaled(0.3);
        let turn = random_rotation(&mut rng);
        small.vertices.iter_mut().for_each(|x| *x = turn * *x + shift * towards);
        let mesh = disjoint([large.clone(), small]);
        let (color, background) = ([0.7, 0.2, 0.4], [0.1, 0.5, 0.6]);
        let mu = [[0.6, 0.3, 0.1], [0.2, 0.9, 0.3]];
        let u = (0..mesh.vertices.len()).flat_map(|k| if k < n { [1.0, 0.0] } else { [0.0, 1.0] });
        let coloring = Coloring { u: u.collect(), mu: mu.to_vec() };
        let images = plain(cameras.clone(), 40, color, background);
        let case =
            Case { images, coloring, sampling: SAMPLING, ..Case::new(mesh, vec![], 1, &mut rng) };
        let [b, large, small] = [background, mu[0], mu[1]].map(|mu| squared(color, mu));
        let exact = |mesh: &Mesh| {
            let area = |range| hull_area(mesh, range, &cameras[0]);
            let seen = if in_front { small - large } else { 0.0 };
            (large - b) * area(0..n) + seen * area(n..mesh.vertices.len())
        };
        assert_exact(&case, exact, 1e-5);
    }
}

/// The image of a mirrored camera is the mirrored image, with the same energy and the same gradient.
#[test]
fn a_mirrored_camera_sees_the_same() {
    let mut rng = rng(8);
    let plain = Case::new(super::scenes::torus(), cameras(2, 24), 24, &mut rng).with_samples(4);
    let mirror = |image: &Image| {
        let pixels = image.pixels.chunks(image.width).flat_map(|row| row.iter().rev().copied());
        let camera = image.camera.mirrored(image.width);
        Image { camera, pixels: pixels.collect(), ..image.clone() }
    };
    let images = plain.images.iter().map(mirror).collect();
    let Case { mesh, coloring, light, weights, sampling, .. } = &plain;
    let mirrored = Case {
        mesh: mesh.clone(),
        images,
        coloring: coloring.clone(),
        light: *light,
        weights: *weights,
        sampling: *sampling,
    };
    let [a, b] = [&plain, &mirrored].map(Case::slope);
    assert!((a.terms.sum() - b.terms.sum()).abs() <= 1e-9 * a.terms.sum());
    let size: f64 = a.gradient.iter().map(Vector3::norm).sum();
    let difference: f64 = a.gradient.iter().zip(&b.gradient).map(|(a, b)| (a - b).norm()).sum();
    assert!(difference <= 1e-9 * size, "{difference} of {size}");
}

/// A surface that no camera sees: the energy is that of the empty images, and nothing pulls.
#[test]
fn an_empty_image_pulls_nothing() {
    let mut rng = rng(10);
    let case = Case::new(shape("sphere:1"), cameras(2, 16), 16, &mut rng).with_samples(2);
    let empty: f64 = case.images.iter().map(Image::empty).sum();
    let place = |x: Point3<f64>| x + Vector3::new(0.0, 50.0, 0.0);
    let mut away = case.mesh.clone();
    away.vertices.iter_mut().for_each(|x| *x = place(*x));
    let slope = Case { mesh: away, ..case }.slope();
    assert_eq!((slope.terms.sum(), slope.contour_pixels), (empty, 0.0));
    assert!(slope.gradient.iter().all(|g| *g == Vector3::zeros()));
}
