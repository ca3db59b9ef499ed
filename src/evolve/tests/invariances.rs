//! What changes neither the energy nor its gradient, and the statistics as a second formula of the energy.

use nalgebra::Vector3;
use rand::RngExt;

use super::scenes::{Case, cameras, dot, ellipsoid, moved, torus};
use crate::evolve::coloring::Coloring;
use crate::evolve::images::Image;
use crate::evolve::statistics::statistics;
use crate::optics::zbuffer::ZBuffer;
use crate::samples::rng;
use crate::sweep::with_threads;

/// Seen from one camera, moving the surface along the rays changes nothing: the interior for a common factor, the contours
/// for any factors.
#[test]
fn motion_along_the_rays_of_one_camera_changes_nothing() {
    let mut rng = rng(21);
    for mesh in [ellipsoid(), torus()] {
        let case = Case::new(mesh, cameras(1, 32), 32, &mut rng).with_samples(4);
        let center = case.images[0].camera.center();
        let rays: Vec<Vector3<f64>> = case.mesh.vertices.iter().map(|x| x - center).collect();
        let gradient = case.slope().gradient;
        let size: f64 = gradient.iter().zip(&rays).map(|(g, v)| g.norm() * v.norm()).sum();
        assert!(dot(&gradient, &rays).abs() <= 1e-13 * size);
        // One region has no interior.
        let n = case.mesh.vertices.len();
        let coloring = Coloring { u: vec![1.0; n], mu: vec![[0.3, 0.6, 0.2]] };
        let case = Case { coloring, ..case };
        let gradient = case.slope().gradient;
        let size: f64 = gradient.iter().zip(&rays).map(|(g, v)| g.norm() * v.norm()).sum();
        assert!(size > 0.0);
        for (g, ray) in gradient.iter().zip(&rays) {
            assert!(g.dot(ray).abs() <= 1e-14 * size);
        }
        let scaled: Vec<_> = rays.iter().map(|ray| rng.random_range(-0.1..0.1) * ray).collect();
        let before = case.energy();
        let after = Case { mesh: moved(&case.mesh, &scaled, 0.1), ..case }.energy();
        assert!((before - after).abs() <= 1e-9 * before, "{before} {after}");
    }
}

/// Cameras in another order have the same sums, up to rounding.
#[test]
fn the_order_of_cameras_does_not_matter() {
    let mut rng = rng(22);
    let mut case = Case::new(torus(), cameras(5, 24), 24, &mut rng).with_samples(2).lit(&mut rng);
    let before = case.slope();
    case.images.rotate_left(2);
    let after = case.slope();
    assert!((before.terms.sum() - after.terms.sum()).abs() <= 1e-13 * before.terms.sum());
    for (a, b) in before.gradient.iter().zip(&after.gradient) {
        assert!((a - b).norm() <= 1e-11 * a.norm().max(1.0));
    }
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let mut rng = rng(23);
    let case = Case::new(torus(), cameras(5, 24), 24, &mut rng).with_samples(2).lit(&mut rng);
    let with = |threads| with_threads(Some(threads), || case.slope()).unwrap();
    let one = with(1);
    for threads in [2, 3] {
        let other = with(threads);
        assert_eq!(one.terms, other.terms);
        assert_eq!(one.gradient, other.gradient);
    }
}

/// E of the images is sum_k <u_k, f_k> where the surface is seen, plus the background elsewhere; with shading as well.
#[test]
fn the_statistics_have_the_energy_of_the_images() {
    let mut rng = rng(24);
    for light in [false, true] {
        let mut case = Case::new(torus(), cameras(3, 24), 24, &mut rng).with_samples(3);
        if light {
            case = case.lit(&mut rng);
        }
        let shading = case.light.map(|light| light.shading(&case.mesh));
        let mu = &case.coloring.mu;
        let sums = statistics(&case.images, &case.mesh, shading.as_deref(), 3, mu);
        let costs = case
            .coloring
            .u
            .chunks(3)
            .zip(&sums)
            .map(|(u, sums)| u.iter().zip(mu).map(|(u, &mu)| u * sums.cost(mu)).sum::<f64>());
        let mut outside = 0.0;
        for image in &case.images {
            let zbuffer = ZBuffer::new(&case.mesh, &image.camera, image.size(), 3);
            for sample in 0..zbuffer.width * zbuffer.height {
                let (x, y) = (sample % zbuffer.width / 3, sample / zbuffer.width / 3);
                if zbuffer.face(sample).is_none() {
                    outside += f64::from(image.pixels[y * image.width + x].beyond) / 9.0;
                }
            }
        }
        let energy = case.energy();
        let found = costs.sum::<f64>() + outside;
        assert!((found - energy).abs() <= 1e-12 * energy, "{found} {energy}");
        let pixels: f64 = case.images.iter().map(|image: &Image| image.pixels.len() as f64).sum();
        assert!(sums.iter().map(|sums| sums.w).sum::<f64>() < pixels);
    }
}
