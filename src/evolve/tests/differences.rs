//! Gradients against central differences of the energy.

use nalgebra::Vector3;
use rand_pcg::Pcg64;

use super::scenes::{Case, IMAGES_ALONE, cameras, close_cameras, dot, ellipsoid, fields, torus};
use crate::evolve::coloring::Coloring;
use crate::evolve::energy::Weights;
use crate::samples::{non_manifold, rng, shape};

/// The largest |<gradient, field> - difference| over the fields, relative to the moduli of the terms of the product.
fn worst(case: &Case, h: f64, rng: &mut Pcg64) -> f64 {
    let gradient = case.slope().gradient;
    let error = |(_, field): (&str, Vec<Vector3<f64>>)| {
        let (exact, difference) = (dot(&gradient, &field), case.difference(&field, h));
        (exact - difference).abs() / (exact.abs() + size(&gradient, &field))
    };
    fields(&case.mesh, rng).into_iter().map(error).fold(0.0, f64::max)
}

/// The sum of the moduli of the terms of a product.
fn size(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b).abs()).sum()
}

/// Where the surface fills the images, the sampled energy is continuous in X, and its derivative is exact for any number
/// of samples: only the samples that change their face within h differ.
#[test]
fn the_interior_is_the_derivative_of_the_sampled_energy() {
    let mut rng = rng(1);
    for light in [false, true] {
        let mut case =
            Case::new(ellipsoid().scaled(1.4), close_cameras(3, 24), 24, &mut rng).with_samples(3);
        if light {
            case = case.lit(&mut rng);
        }
        let error = worst(&case, 1e-7, &mut rng);
        assert!(error < 1e-5, "light {light}: {error:.1e}");
    }
}

/// One region of one color, lit: the energy depends on X by way of the normals, and where the shading slides.
#[test]
fn the_shading_of_one_albedo_is_differentiated() {
    let mut rng = rng(2);
    let mesh = ellipsoid().scaled(1.4);
    let coloring = Coloring { u: vec![1.0; mesh.vertices.len()], mu: vec![[0.8, 0.5, 0.3]] };
    let case = Case::new(mesh, close_cameras(2, 24), 24, &mut rng).with_samples(2).lit(&mut rng);
    let error = worst(&Case { coloring, ..case }, 1e-7, &mut rng);
    assert!(error < 1e-5, "{error:.1e}");
}

/// The terms of the surface alone, on all kinds of meshes.
#[test]
fn length_area_and_roughness_are_differentiated() {
    let mut rng = rng(3);
    for mesh in [ellipsoid(), shape("grid:5x4"), non_manifold()] {
        for (lambda, kappa, eta) in [(0.7, 0.0, 0.0), (0.0, 1.3, 0.0), (0.0, 0.0, 0.4)] {
            let weights = Weights { sigma: 0.0, lambda, kappa, eta };
            let case = Case::new(mesh.clone(), Vec::new(), 1, &mut rng);
            let error = worst(&Case { weights, ..case }, 1e-5, &mut rng);
            assert!(error < 1e-8, "{weights:?}: {error:.1e}");
        }
    }
}

/// Labels without a cut have no length and no gradient.
#[test]
fn constant_labels_have_no_length() {
    let mesh = ellipsoid();
    let u = vec![[0.25, 0.75]; mesh.vertices.len()].into_flattened();
    let coloring = Coloring { u, mu: vec![[0.1; 3], [0.9; 3]] };
    let weights = Weights { sigma: 0.0, lambda: 1.0, kappa: 0.0, eta: 0.0 };
    let case = Case { coloring, weights, ..Case::new(mesh, Vec::new(), 1, &mut rng(4)) };
    assert_eq!(case.energy(), 0.0);
    assert!(case.slope().gradient.iter().all(|g| *g == Vector3::zeros()));
}

/// The whole gradient, with contours and self-occlusions. A sampled energy is a step function: a vertex moves by several
/// samples, and what is left is the error of that difference.
#[test]
fn the_whole_gradient_agrees_with_differences() {
    let mut rng = rng(5);
    for (name, mesh) in [("ellipsoid", ellipsoid()), ("torus", torus())] {
        for light in [false, true] {
            let mut case = Case::new(mesh.clone(), cameras(2, 32), 32, &mut rng);
            if light {
                case = case.lit(&mut rng);
            }
            let weights = Weights { lambda: 0.3, kappa: 0.2, eta: 0.1, ..IMAGES_ALONE };
            let case = Case { weights, ..case };
            let error = worst(&case, 2e-3, &mut rng);
            assert!(error < 1.5e-2, "{name}, light {light}: {error:.1e}");
        }
    }
}
