//! Tests of the statistics: conservation, invariance, an independent quadrature on faces, and known truths.

mod files;
mod photographs;
mod scene;

use nalgebra::Vector3;

use super::statistics::of_view;
use super::*;
use crate::optics::zbuffer::ZBuffer;
use crate::samples::{disjoint, random_rotation, random_vector, rng, shape};
use rand::RngExt;
use scene::{Camera, cameras, on_faces, rendered};

/// A torus that hides a part of itself, within the images.
fn torus() -> Mesh {
    shape("torus:20x12").scaled(2.5)
}

fn with_samples(samples: usize) -> ViewOptions {
    ViewOptions { samples, ..ViewOptions::default() }
}

/// sum_k f_kp is the sum over the covered samples of |I - mu_p|^2.
#[test]
fn costs_are_conserved() {
    let mesh = torus();
    let mut rng = rng(5);
    let colors: Vec<[f64; 3]> = (0..80 * 60).map(|_| rng.random()).collect();
    let picture = Picture::of(80, 60, |x, y| colors[80 * y + x]);
    let mu: [f64; 3] = rng.random();
    for (camera, s) in cameras(4, 3.0, [80, 60]).into_iter().zip([1, 2, 3, 1]) {
        let Camera { pinhole, size } = camera;
        let ViewStatistics { sums, pixels, .. } =
            of_view(&mesh, &pinhole, &picture, &with_samples(s));
        let zbuffer = ZBuffer::new(&mesh, &pinhole, size, s);
        let mut exact = 0.0;
        let mut covered = 0;
        for sample in 0..zbuffer.width * zbuffer.height {
            if zbuffer.face(sample).is_some() {
                let (x, y) = (sample % zbuffer.width / s, sample / zbuffer.width / s);
                let color = picture.color(80 * y + x);
                let distance: f64 = color.iter().zip(mu).map(|(c, mu)| (c - mu).powi(2)).sum();
                exact += distance / (s * s) as f64;
                covered += 1;
            }
        }
        let norm: f64 = mu.iter().map(|x| x * x).sum();
        let f: f64 = sums
            .iter()
            .map(|[w, q, r, g, b]| q - 2.0 * (mu[0] * r + mu[1] * g + mu[2] * b) + norm * w)
            .sum();
        assert!(covered > 100 && (f - exact).abs() <= 1e-12 * exact, "{f} {exact}");
        let w: f64 = sums.iter().map(|sums| sums[0]).sum();
        assert!((w - f64::from(covered) / (s * s) as f64).abs() <= 1e-12 * w);
        assert!(sums.iter().all(|sums| sums[0] >= 0.0));
        assert!(s > 1 || pixels.used == u64::from(covered as u32));
    }
}

/// x -> c R x + b of the scene and its cameras changes nothing.
#[test]
fn a_similarity_of_scene_and_cameras_changes_nothing() {
    let mesh = torus();
    let mut rng = rng(8);
    let picture = Picture::of(160, 120, |x, y| [x as f64 / 160.0, y as f64 / 120.0, 0.3]);
    for Camera { pinhole, .. } in cameras(3, 3.0, [160, 120]) {
        let plain = of_view(&mesh, &pinhole, &picture, &with_samples(1));
        let (c, turn) = (37.0, random_rotation(&mut rng));
        let b = 100.0 * random_vector(&mut rng);
        let mut moved = mesh.clone();
        moved.vertices.iter_mut().for_each(|x| *x = (c * (turn * x.coords) + b).into());
        let same =
            of_view(&moved, &pinhole.moved(c, *turn.matrix(), b), &picture, &with_samples(1));
        let total: f64 = plain.sums.iter().map(|sums| sums[0]).sum();
        let pairs = plain.sums.iter().flatten().zip(same.sums.iter().flatten());
        let difference: f64 = pairs.map(|(a, b)| (a - b).abs()).sum();
        assert!(difference <= 1e-9 * total, "{difference}");
        assert_eq!(plain.pixels, same.pixels);
    }
}

fn distance(a: &[Sums], b: &[Sums], scale: f64) -> f64 {
    let size: f64 = b.iter().flatten().map(|x| x.abs()).sum();
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (scale * a - b).abs()).sum::<f64>() / size
}

/// The sums over pixels converge to the integrals over the visible faces with the weight -det K (x.n) / z^3; visibility by
/// rays, no z-buffer. Where the integrand is smooth the order is 2, and along contours, as for the area of a region by
/// counting lattice points, at least 4/3.
#[test]
fn pixels_agree_with_a_quadrature_on_faces() {
    let mesh = torus();
    let image = |x: f64, y: f64| {
        [0.5 + 0.4 * (5.0 * x).sin(), 0.5 + 0.4 * (4.0 * y).cos(), 0.5 + 0.3 * (x * y * 3.0).sin()]
    };
    for camera in cameras(3, 3.0, [40, 30]) {
        let exact = on_faces(&mesh, &camera, 24, image);
        let error = |scale: usize| {
            let [w, h] = camera.size.map(|n| n * scale);
            let picture = Picture::of(w, h, |x, y| {
                image((x as f64 + 0.5) / w as f64, (y as f64 + 0.5) / h as f64)
            });
            let pinhole = camera.pinhole.scaled(scale as f64);
            let found = of_view(&mesh, &pinhole, &picture, &with_samples(1)).sums;
            distance(&found, &exact, 1.0 / (scale * scale) as f64)
        };
        let errors = [1, 4, 16].map(error);
        assert!(errors[0] > 16_f64.powf(4.0 / 3.0) * errors[2], "{errors:?}");
        assert!(errors[1] < 2e-2 && errors[2] < 2e-3, "{errors:?}");
        // The quadrature converges as well.
        let coarse = [1, 4].map(|n| distance(&on_faces(&mesh, &camera, n, image), &exact, 1.0));
        assert!(coarse[0] > 3.0 * coarse[1], "{coarse:?}");
    }
}

/// S x S samples of a pixel are those of an image of S times the size whose pixels repeat.
#[test]
fn samples_are_pixels_of_a_larger_image() {
    let mesh = torus();
    let color = |x: usize, y: usize| [x as f64 / 40.0, y as f64 / 30.0, 0.25];
    for (Camera { pinhole, size: [w, h] }, s) in cameras(2, 3.0, [40, 30]).into_iter().zip([2, 3]) {
        let found = of_view(&mesh, &pinhole, &Picture::of(w, h, color), &with_samples(s)).sums;
        let large = Picture::of(s * w, s * h, |x, y| color(x / s, y / s));
        let same = of_view(&mesh, &pinhole.scaled(s as f64), &large, &with_samples(1)).sums;
        assert!(distance(&same, &found, 1.0 / (s * s) as f64) <= 1e-12);
    }
}

/// The back of an open surface is no data, and hides what is behind it.
#[test]
fn backs_hide_but_do_not_count() {
    let sphere = shape("sphere:2");
    let [Camera { pinhole, size: [w, h] }] = cameras(1, 4.0, [80, 60])[..] else { unreachable!() };
    let picture = Picture::of(w, h, |_, _| [0.5; 3]);
    let mut inside_out = sphere.clone();
    inside_out.faces.iter_mut().for_each(|face| face.swap(0, 1));
    let seen = of_view(&sphere, &pinhole, &picture, &with_samples(1));
    let hidden = disjoint([inside_out, sphere.clone().scaled(0.5)]);
    let found = of_view(&hidden, &pinhole, &picture, &with_samples(1));
    assert_eq!((found.pixels.used, found.pixels.back), (0, seen.pixels.used));
    assert!(found.sums.iter().all(|sums| *sums == [0.0; 5]));
    // The nearer of two spheres hides the other; its own back hides nothing.
    let both = of_view(
        &disjoint([sphere.clone().scaled(0.5), sphere]),
        &pinhole,
        &picture,
        &with_samples(1),
    );
    assert_eq!(both.pixels, seen.pixels);
    assert!(both.sums[..both.sums.len() / 2].iter().all(|sums| sums[0] == 0.0));
}

/// Faces behind a camera, or through its plane, are left out and counted.
#[test]
fn faces_behind_the_camera_are_left_out() {
    let sphere = shape("sphere:2");
    let [Camera { pinhole, size: [w, h] }] = cameras(1, 4.0, [80, 60])[..] else { unreachable!() };
    let picture = Picture::of(w, h, |_, _| [0.5; 3]);
    let mut behind = sphere.clone();
    let twice = 2.0 * pinhole.center().coords;
    behind.vertices.iter_mut().for_each(|x| *x += twice);
    let found = of_view(&disjoint([sphere.clone(), behind]), &pinhole, &picture, &with_samples(1));
    assert_eq!(found.behind, sphere.faces.len());
    assert_eq!(found.pixels, of_view(&sphere, &pinhole, &picture, &with_samples(1)).pixels);
}

/// Of an image whose silhouettes mix with the background, pure pixels have the color of the surface, and every test
/// leaves out what it says.
#[test]
fn robust_choices_leave_out_what_they_say() {
    let sphere = shape("sphere:3");
    let gray = |_: Vector3<f64>| [0.8; 3];
    for camera in cameras(3, 4.0, [80, 60]) {
        let Camera { pinhole, size: [w, h] } = &camera;
        let colors = rendered(&sphere, &camera, 4, gray, [0.1; 3]);
        let picture = Picture::of(*w, *h, |x, y| colors.pixels[w * y + x]);
        let with = |options: ViewOptions| of_view(&sphere, pinhole, &picture, &options);
        let largest_error = |statistics: &ViewStatistics| {
            let errors = statistics.sums.iter().filter(|sums| sums[0] > 0.0);
            errors.map(|sums| (sums[2] / sums[0] - 0.8).abs()).fold(0.0, f64::max)
        };
        let all = with(ViewOptions::default());
        let pure = with(ViewOptions { pure: 2, ..ViewOptions::default() });
        assert!(largest_error(&all) > 0.05 && largest_error(&pure) < 1e-4);
        assert_eq!(pure.pixels.used + pure.pixels.mixed, all.pixels.used);
        let steep = with(ViewOptions { grazing: 0.5, ..ViewOptions::default() });
        assert_eq!(steep.pixels.used + steep.pixels.grazing, all.pixels.used);
        // A ray to the unit sphere from the distance d meets it at a cosine of at least c up to the angle arcsin(s / d)
        // from the axis, s^2 = 1 - c^2; the radius in the image is proportional to the tangent.
        let radius = |s: f64| (s / 4.0).asin().tan();
        let share = (radius(0.75_f64.sqrt()) / radius(1.0)).powi(2);
        let found = steep.pixels.used as f64 / all.pixels.used as f64;
        assert!((found - share).abs() < 0.05, "{found} {share}");
        let inner = with(ViewOptions { border: 25, ..ViewOptions::default() });
        assert_eq!(inner.pixels.used, 30 * 10);
    }
}
