//! The total variation of smooth functions converges with order 2 to integrals known in closed form.

use std::f64::consts::PI;

use super::column;
use crate::mesh::{Mesh, Shape};
use crate::operator::{Operator, Stencil};
use crate::relaxation::{DualSet, Envelope, Frobenius, LabelMetric, Separate};
use crate::samples::{observed_order, random_rows, rng, shape};
use nalgebra::Point3;

fn variation(mesh: &Mesh, value: impl Fn(&Point3<f64>) -> f64) -> f64 {
    let k = Stencil::new(mesh);
    let u = column(mesh.vertices.iter().map(value));
    (0..k.faces()).map(|j| k.at(&u, j).norm()).sum()
}

#[track_caller]
fn assert_order_2(steps: &[f64], errors: &[f64]) {
    let order = observed_order(steps, errors);
    assert!((order - 2.0).abs() < 0.05, "observed order {order} of {errors:?}");
}

/// The norms are bitwise equal lane by lane or face by face, in blocks of any size.
fn assert_same_norms<const M: usize>(set: impl DualSet, mesh: &Mesh) {
    let k = Stencil::new(mesh);
    let u = random_rows::<M>(k.vertices(), &mut rng(M as u64));
    let single: Vec<f64> = (0..k.faces()).map(|j| set.support(k.at(&u, j))).collect();
    for block in [1, 3, 8, 13, k.faces()] {
        let mut norms = vec![0.0; k.faces()];
        for (i, norms) in norms.chunks_mut(block).enumerate() {
            k.norms(set, &u, i * block, norms);
        }
        assert_eq!(norms, single, "{M} regions, blocks of {block}");
    }
}

#[test]
fn norms_come_in_blocks_of_any_size() {
    for mesh in [shape("torus:13x7"), shape("sphere:2").scaled(1e-4)] {
        assert_same_norms::<3>(Frobenius, &mesh);
        assert_same_norms::<4>(Frobenius, &mesh);
        assert_same_norms::<16>(Frobenius, &mesh);
        assert_same_norms::<3>(Separate, &mesh);
        assert_same_norms::<4>(Separate, &mesh);
        assert_same_norms::<16>(Separate, &mesh);
        assert_same_norms::<4>(Envelope(LabelMetric::POTTS), &mesh);
    }
}

/// On the unit sphere |grad z| = sin(polar angle t), and its integral is
/// 2 pi int_0^pi sin^2 t dt = pi^2.
#[test]
fn height_on_the_sphere() {
    let levels = [3, 4, 5];
    let steps = levels.map(|level| 0.5_f64.powi(level));
    let errors = levels.map(|level| {
        let mesh = Shape::Sphere { level: level as u32 }.mesh();
        (variation(&mesh, |x| x.z) - PI * PI).abs()
    });
    assert_order_2(&steps, &errors);
}

/// |grad exp(z)| = exp(cos t) sin t; 2 pi int exp(cos t) sin^2 t dt = 2 pi^2 I_1(1), a Bessel function.
#[test]
fn exponential_of_the_height_on_the_sphere() {
    const BESSEL_I1_OF_1: f64 = 0.565_159_103_992_485;
    let levels = [3, 4, 5];
    let steps = levels.map(|level| 0.5_f64.powi(level));
    let errors = levels.map(|level| {
        let mesh = Shape::Sphere { level: level as u32 }.mesh();
        (variation(&mesh, |x| x.z.exp()) - 2.0 * PI * PI * BESSEL_I1_OF_1).abs()
    });
    assert_order_2(&steps, &errors);
}

/// On the torus with radii 1 and r the height z = r sin v has |grad z| = |cos v|, and
/// int |cos v| r (1 + r cos v) dv du = 2 pi r 4 = 8 pi r: the cosine changes sign with v -> pi - v.
/// The shape is scaled to area 1, which its first vertex at radius 1 + r undoes.
#[test]
fn height_on_the_torus() {
    const MINOR: f64 = 0.4;
    let sizes = [24, 48, 96];
    let steps = sizes.map(|n| 1.0 / f64::from(n));
    let errors = sizes.map(|n| {
        let mesh = Shape::Torus { nu: 2 * n, nv: n }.mesh();
        let mesh = mesh.clone().scaled((1.0 + MINOR) / mesh.vertices[0].x);
        (variation(&mesh, |x| x.z) - 8.0 * PI * MINOR).abs()
    });
    assert_order_2(&steps, &errors);
}
