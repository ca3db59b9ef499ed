//! Theorems on curvature of every kind.

use std::f64::consts::{FRAC_2_PI, TAU};

use nalgebra::{Point3, Vector3};
use rand::RngExt;

use super::*;
use crate::mesh::Statistics;
use crate::mesh::geometry::mixed_voronoi_areas;
use crate::names::Named;
use crate::samples::{
    bumpy, disjoint, observed_order, random_rotation, random_vector, rng, shape, shuffled,
    with_isolated_vertices, zoo,
};
use crate::sweep::with_threads;

fn kinds() -> Vec<CurvatureKind> {
    CurvatureKind::names().iter().map(|name| CurvatureKind::named(name).unwrap()).collect()
}

/// The curvature of exact coordinates.
fn values(mesh: &Mesh, kind: CurvatureKind) -> Vec<f64> {
    at_vertices(mesh, kind, 0.0).values
}

/// The curvature with principal curvatures k1 >= k2.
fn of(kind: CurvatureKind, [k1, k2]: [f64; 2]) -> f64 {
    match kind {
        CurvatureKind::Mean | CurvatureKind::MeanQuadric => 0.5 * (k1 + k2),
        CurvatureKind::Gaussian => k1 * k2,
        CurvatureKind::ShapeIndex => FRAC_2_PI * ((k1 + k2) / (k1 - k2)).atan(),
    }
}

fn largest(differences: impl Iterator<Item = f64>) -> f64 {
    differences.fold(0.0, |largest, x| if x > largest || x.is_nan() { x } else { largest })
}

/// A closed surface without symmetry, whose fits are far from degenerate.
fn potato() -> Mesh {
    let mut mesh = shape("sphere:3");
    for x in &mut mesh.vertices {
        let [a, b, c] = [x.x, x.y, x.z];
        *x *= 1.0 + 0.2 * (2.0 * a + b).sin() + 0.1 * (3.0 * c - a).cos();
        x.y *= 1.3;
    }
    mesh
}

/// Errors in units of the curvature of the tube.
fn torus_error(kind: CurvatureKind, n: u32) -> f64 {
    let mesh = shape(&format!("torus:{}x{n}", 3 * n));
    let big = mesh.vertices[0].x / 1.4;
    let small = 0.4 * big;
    let differences = values(&mesh, kind).into_iter().zip(&mesh.vertices).map(|(value, x)| {
        let cos = (x.x.hypot(x.y) - big) / small;
        let exact = of(kind, [1.0 / small, cos / (big + small * cos)]);
        (value - exact).abs() * small.powi(kind.inverse_lengths())
    });
    largest(differences)
}

#[test]
fn on_a_torus_every_curvature_converges_with_order_two() {
    for kind in kinds() {
        let errors = [24, 48, 96].map(|n| torus_error(kind, n));
        let order = observed_order(&[4.0, 2.0, 1.0], &errors);
        assert!(errors[2] < 5e-3 && order > 1.9, "{kind:?} {errors:?} {order}");
    }
}

#[test]
fn a_sphere_of_radius_r_has_curvatures_1_over_r() {
    for kind in kinds() {
        for r in [1e-4, 1.0, 1e4] {
            let exact = match kind {
                CurvatureKind::ShapeIndex => 1.0,
                _ => of(kind, [1.0 / r; 2]),
            };
            let errors = [3, 4, 5].map(|level| {
                let found = values(&shape(&format!("sphere:{level}")).scaled(r), kind);
                largest(found.into_iter().map(|value| (value / exact - 1.0).abs()))
            });
            let order = observed_order(&[4.0, 2.0, 1.0], &errors);
            assert!(errors[2] < 5e-3 && order > 0.9, "{kind:?} {errors:?} {order}");
        }
    }
}

/// A grid over [-1/2, 1/2]^2, with a vertex at the origin, and that vertex.
fn graph(cells: u32, z: impl Fn(f64, f64) -> f64) -> (Mesh, usize) {
    let mut mesh = shape(&format!("grid:{cells}x{cells}"));
    for x in &mut mesh.vertices {
        *x = Point3::new(x.x - 0.5, x.y - 0.5, z(x.x - 0.5, x.y - 0.5));
    }
    (mesh, (cells / 2 * (cells + 1) + cells / 2) as usize)
}

#[test]
fn saddles_have_shape_index_zero_and_the_monkey_saddle_has_none() {
    let (saddle, center) = graph(20, |x, y| x * y);
    let found = values(&saddle, CurvatureKind::ShapeIndex)[center];
    assert!(found.abs() < 1e-13, "{found}");
    assert!(values(&saddle, CurvatureKind::MeanQuadric)[center].abs() < 1e-13);
    let gaussian = |n: u32| {
        let (saddle, center) = graph(n, |x, y| x * y);
        (values(&saddle, CurvatureKind::Gaussian)[center] + 1.0).abs()
    };
    let order = observed_order(&[4.0, 2.0, 1.0], &[10, 20, 40].map(gaussian));
    assert!(order > 1.9, "{order}");

    let (monkey, center) = graph(20, |x, y| x * x * x - 3.0 * x * y * y);
    let delta = f64::EPSILON;
    let found = at_vertices(&monkey, CurvatureKind::ShapeIndex, delta);
    assert!(found.values[center].is_nan() && found.flat == 1, "{}", found.flat);
    let inside = |x: &Point3<f64>| x.coords.amax() < 0.45;
    let around = monkey.vertices.iter().zip(&found.values).enumerate();
    for (_, (x, s)) in around.filter(|&(v, (x, _))| v != center && inside(x)) {
        let [x, y] = [x.x, x.y];
        // H (1 + p^2 + q^2)^(3/2) = ((1 + q^2) r - 2 p q s + (1 + p^2) t) / 2, K (1 + p^2 + q^2)^2 = r t - s^2.
        let (p, q, r, t) = (3.0 * (x * x - y * y), -6.0 * x * y, 6.0 * x, -6.0 * y);
        let w = 1.0 + p * p + q * q;
        let mean = -0.5 * ((1.0 + q * q) * r - 2.0 * p * q * t - (1.0 + p * p) * r) / w.powf(1.5);
        let half = (mean * mean + (r * r + t * t) / (w * w)).sqrt();
        let exact = FRAC_2_PI * (mean / half).atan();
        assert!((s - exact).abs() < 0.05, "{x} {y}: {s} is not {exact}");
    }
}

#[test]
fn prisms_inscribed_in_a_cylinder_have_gaussian_curvature_zero() {
    let mut tube = shape("grid:40x30");
    tube.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x.cos(), x.x.sin(), x.y));
    let found = at_vertices(&tube, CurvatureKind::Gaussian, f64::EPSILON);
    for (k, noise) in found.values.iter().zip(&found.noise).filter(|(k, _)| !k.is_nan()) {
        assert!(k.abs() <= 6.0 * noise && *noise < 1e-9, "{k} {noise}");
    }
    for (kind, bound) in [(CurvatureKind::MeanQuadric, 3e-4), (CurvatureKind::ShapeIndex, 2e-5)] {
        let errors = [12, 24, 48].map(|n| {
            let mut tube = shape(&format!("grid:{n}x{n}"));
            tube.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x.cos(), x.x.sin(), x.y));
            let center = (n / 2 * (n + 1) + n / 2) as usize;
            (values(&tube, kind)[center] - 0.5).abs()
        });
        let order = observed_order(&[4.0, 2.0, 1.0], &errors);
        assert!(errors[2] < bound && order > 1.9, "{kind:?} {errors:?} {order}");
    }
}

#[test]
fn angle_defects_of_closed_surfaces_sum_to_two_pi_chi() {
    let mut torus = shape("torus:30x20");
    let mut rng = rng(1);
    torus.vertices.iter_mut().for_each(|x| *x += 0.01 * random_vector(&mut rng));
    for mesh in [shape("sphere:0"), potato(), torus.clone(), disjoint([potato(), torus, potato()])]
    {
        let area = mixed_voronoi_areas(&mesh);
        let total: f64 =
            values(&mesh, CurvatureKind::Gaussian).iter().zip(&area).map(|(k, a)| k * a).sum();
        let expected = TAU * Statistics::of(&mesh).euler_characteristic as f64;
        assert!((total - expected).abs() < 1e-11, "{total} is not {expected}");
    }
}

/// Rigid motions change nothing, nor do the numbers of vertices and faces; the reverse side changes the sign, except of
/// the Gaussian curvature; scaling by a power of two, even a tiny one, scales exactly.
#[test]
fn curvature_is_that_of_the_surface() {
    for mesh in [potato(), bumpy(12)] {
        for kind in kinds() {
            let exact = values(&mesh, kind);
            let scale = largest(exact.iter().filter(|x| !x.is_nan()).map(|x| x.abs()));
            let same = |found: f64, exact: f64| {
                found.is_nan() && exact.is_nan() || (found - exact).abs() <= 1e-9 * scale
            };

            let mut moved = mesh.clone();
            let turn = random_rotation(&mut rng(8));
            moved.vertices.iter_mut().for_each(|x| *x = turn * *x + Vector3::new(1.0, -2.0, 0.5));
            assert!(values(&moved, kind).iter().zip(&exact).all(|(&a, &b)| same(a, b)), "{kind:?}");

            let (renumbered, previous) = shuffled(&mesh, &mut rng(9));
            let found = values(&renumbered, kind);
            assert!(
                found.iter().zip(previous).all(|(&a, v)| same(a, exact[v as usize])),
                "{kind:?}"
            );

            let mut reversed = mesh.clone();
            reversed.faces.iter_mut().for_each(|face| face.swap(1, 2));
            let sign = if kind.sign().is_some() { -1.0 } else { 1.0 };
            let found = values(&reversed, kind);
            assert!(found.iter().zip(&exact).all(|(&a, &b)| same(a, sign * b)), "{kind:?}");

            for exponent in [-200, -10, 10, 100] {
                let c = 2.0_f64.powi(exponent);
                let found = values(&mesh.clone().scaled(c), kind);
                let factor = c.powi(kind.inverse_lengths());
                let equal = |(a, b): (&f64, &f64)| a.is_nan() && b.is_nan() || a * factor == *b;
                assert!(found.iter().zip(&exact).all(equal), "{kind:?} {exponent}");
            }
        }
    }
}

/// With random displacements, curvatures have the predicted deviation; the one of quadrics is an upper bound.
#[test]
fn noise_is_as_predicted() {
    let mut rng = rng(77);
    let (bent, _) = graph(16, |x, y| 0.3 * (3.0 * x).sin() + 0.2 * (x + 2.0 * y).cos());
    for (name, mesh) in [("plane", shape("grid:16x16")), ("bent", bent), ("potato", potato())] {
        for kind in kinds() {
            let delta = 1e-7;
            let exact = at_vertices(&mesh, kind, delta);
            let (mut squares, mut count) = (0.0, 0.0);
            for _ in 0..20 {
                let mut moved = mesh.clone();
                moved.vertices.iter_mut().for_each(|x| {
                    *x += delta * Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
                });
                let found = values(&moved, kind);
                for (v, value) in found.into_iter().enumerate() {
                    let relative = (value - exact.values[v]) / exact.noise[v];
                    if !relative.is_nan() {
                        squares += relative.powi(2);
                        count += 1.0;
                    }
                }
            }
            let deviation = (squares / count).sqrt();
            println!("{name} {kind:?} {deviation}");
            let expected = match kind {
                CurvatureKind::Mean => 0.7..1.1,
                CurvatureKind::Gaussian => 0.7..1.1,
                _ => 0.4..1.1,
            };
            if name == "plane" && kind == CurvatureKind::ShapeIndex {
                // Two corners have no neighbors inside.
                assert_eq!((count, exact.flat), (0.0, mesh.vertices.len() - 2));
            } else {
                assert!(expected.contains(&deviation), "{name} {kind:?} {deviation}");
            }
        }
    }
}

#[test]
fn boundaries_continue_the_interior_and_lone_faces_have_no_curvature() {
    let mut open = shape("sphere:4");
    open.faces.retain(|face| face.iter().all(|&k| open.vertices[k as usize].z > -0.5));
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let lone = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]);
    for kind in kinds() {
        let curvature = values(&open, kind);
        for &k in open.faces.iter().flatten() {
            assert!(
                (curvature[k as usize] - 1.0).abs() < 0.03,
                "{kind:?} {}",
                curvature[k as usize]
            );
        }
        assert!(values(&lone, kind).iter().all(|h| h.is_nan()));
        assert!(values(&Mesh::default(), kind).is_empty());
    }
}

/// Vertices at edges of three faces continue their neighbors; degenerate faces and vertices without faces do not count.
#[test]
fn defects_of_a_mesh_stay_where_they_are() {
    let sphere = shape("sphere:4");
    let mut fin = with_isolated_vertices(sphere.clone());
    let [a, b, _] = fin.faces[7];
    fin.vertices.push(Point3::new(2.0, 2.0, 2.0));
    let tip = fin.vertices.len() as u32 - 1;
    fin.faces.extend([[a, b, tip], [a, a, b], [tip, tip, tip]]);
    for kind in kinds() {
        let (exact, found) = (values(&sphere, kind), values(&fin, kind));
        assert!(found[0].is_nan() && found[sphere.vertices.len() + 1].is_nan());
        if kind == CurvatureKind::Mean {
            continue;
        }
        for v in 1..=sphere.vertices.len() {
            let error = (found[v] - exact[v - 1]).abs();
            // Quadrics near the fin take its tip for a part of the surface.
            let near = (fin.vertices[v] - fin.vertices[a as usize]).norm() < 0.4;
            assert!(if near { error.is_finite() } else { error < 1e-9 }, "{kind:?} {error}");
        }
    }
}

#[test]
fn any_mesh_has_the_same_bits_with_any_number_of_threads() {
    let meshes = zoo().into_iter().chain([("large", shape("torus:100x60"))]);
    for (name, mesh) in meshes {
        for kind in kinds() {
            let with = |threads| {
                let found = with_threads(Some(threads), || at_vertices(&mesh, kind, 1e-9)).unwrap();
                assert_eq!(found.values.len(), mesh.vertices.len());
                let bits =
                    |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
                (bits(found.values), bits(found.noise), found.flat)
            };
            let one = with(1);
            assert!([2, 3, 7].iter().all(|&threads| with(threads) == one), "{name} {kind:?}");
        }
    }
}
