//! Synthetic photographs, and what statistics say of them.

use nalgebra::Vector3;

use super::scene::{BALL, Camera, cameras};
use super::{of_view, with_samples};
use crate::data::synthetic::waves;
use crate::data::views::synthetic::{Light, Paint, Photograph, Studio};
use crate::data::views::{Ball, Picture, View, ViewOptions, around, of_photographs, read, to_toml};
use crate::mesh::Mesh;
use crate::optics::zbuffer::ZBuffer;
use crate::samples::{disjoint, flipped, rng, shape};
use crate::sweep::with_threads;
use rand::RngExt;

const PALETTE: [[f64; 3]; 3] = [[0.8, 0.2, 0.2], [0.2, 0.7, 0.3], [0.3, 0.3, 0.9]];

fn studio<'a>(mesh: &'a Mesh, paint: Paint<'a>) -> Studio<'a> {
    let light = Light::default();
    Studio { mesh, paint, light, background: [0.5; 3], samples: 1, noise: 0.0, seed: 0 }
}

fn views(n: usize, size: [u32; 2]) -> Vec<View> {
    around(&BALL, n, 4.0, size).unwrap()
}

fn labels(mesh: &Mesh) -> Vec<usize> {
    waves(mesh, 3, 0.0, 0).labels
}

/// With one sample per pixel, no pixel mixes colors: the mean color of the pixels of a vertex is that of its region, up to
/// the rounding to 8 bits, if no face around it is cut.
#[test]
fn statistics_give_the_palette_back_where_no_face_is_cut() {
    let mesh = shape("sphere:4");
    let labels = labels(&mesh);
    let views = views(8, [160, 120]);
    let paint = Paint::Regions { labels: &labels, colors: &PALETTE };
    let photographs = studio(&mesh, paint).photographs(&views).unwrap();
    let viewed = of_photographs(&views, &photographs, &mesh, &ViewOptions::default()).unwrap();
    let mut cut = vec![false; mesh.vertices.len()];
    for face in &mesh.faces {
        let [a, b, c] = face.map(|k| labels[k as usize]);
        face.iter().for_each(|&k| cut[k as usize] |= a != b || b != c);
    }
    let mut uncut = 0;
    for (k, mean) in viewed.means.values.chunks(3).enumerate().filter(|(k, _)| !cut[*k]) {
        let errors = mean.iter().zip(PALETTE[labels[k]]).map(|(mean, c)| (mean - c).abs());
        let error = errors.fold(0.0, f64::max);
        assert!(error <= 0.5 / 255.0 + 1e-12, "{k}: {error}");
        assert!(viewed.evidence.variance[k].abs() <= 1e-12);
        uncut += 1;
    }
    assert!(uncut > mesh.vertices.len() / 2);
}

/// Inside a face the label is that of the nearest corner: a third of the area of a face with three labels each, seen
/// straight on.
#[test]
fn faces_are_divided_among_their_nearest_corners() {
    let corner = |angle: f64| nalgebra::Point3::new(angle.sin(), angle.cos(), 0.0);
    let turn = std::f64::consts::TAU / 3.0;
    let mesh = Mesh::new([0.0, turn, 2.0 * turn].map(corner).to_vec(), vec![[0, 2, 1]]);
    let primary = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let paint = Paint::Regions { labels: &[0, 1, 2], colors: &primary };
    let studio = Studio { background: [0.0; 3], samples: 4, ..studio(&mesh, paint) };
    // The first of one camera looks along -z, so that the image is not distorted.
    let [photograph] = &studio.photographs(&views(1, [200, 200])).unwrap()[..] else { panic!() };
    let sums = [0, 1, 2].map(|i| photograph.pixels.iter().map(|pixel| pixel[i]).sum::<f64>());
    // An equilateral triangle in a circle of 90 pixels at distance 4, whose rays of contour have the slope 1 / sqrt 15.
    let radius = 90.0 * 15.0_f64.sqrt() / 4.0;
    let third = 0.75 * 3.0_f64.sqrt() * radius * radius / 3.0;
    assert!(sums.iter().all(|sum| (sum / third - 1.0).abs() < 2e-3), "{sums:?} {third}");
    // The lowest row that shows the surface has only the two lower corners.
    assert!(photograph.pixels[200 * 140 + 80..200 * 140 + 120].iter().all(|pixel| pixel[0] == 0.0));
}

/// A linear function of the position, as colors of vertices, is that function on the surface; several samples are the mean
/// of one.
#[test]
fn colors_of_vertices_are_linear_on_faces() {
    let mesh = shape("sphere:2");
    let color = |x: Vector3<f64>| [0.5 + 0.4 * x.x, 0.5 - 0.3 * x.y, 0.4 + 0.2 * (x.z - x.x)];
    let colors: Vec<[f64; 3]> = mesh.vertices.iter().map(|x| color(x.coords)).collect();
    let size = [40, 30];
    for (view, camera) in views(3, size.map(|n: usize| n as u32)).iter().zip(cameras(3, 4.0, size))
    {
        for samples in [1, 3] {
            let studio = Studio { samples, ..studio(&mesh, Paint::Vertices(&colors)) };
            let found = studio.photographs(std::slice::from_ref(view)).unwrap();
            let exact = super::rendered(&mesh, &camera, samples, color, [0.5; 3]);
            assert!(distance(&found[0], &exact) <= 1e-12 && found[0].shows_surface);
            let large = Camera {
                pinhole: camera.pinhole.scaled(samples as f64),
                size: size.map(|n| samples * n),
            };
            let large = super::rendered(&mesh, &large, 1, color, [0.5; 3]).pixels;
            for (i, pixel) in exact.pixels.iter().enumerate() {
                let [x, y] = [i % size[0] * samples, i / size[0] * samples];
                let mean: f64 = (0..samples * samples)
                    .map(|k| large[(y + k / samples) * size[0] * samples + x + k % samples][1])
                    .sum();
                assert!((mean / (samples * samples) as f64 - pixel[1]).abs() <= 1e-12);
            }
        }
    }
}

fn distance(a: &Photograph, b: &Photograph) -> f64 {
    assert_eq!([a.width, a.height], [b.width, b.height]);
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Ambient light of 1 alone changes no bit, and A alone is a factor. On an icosahedron, whose normals are its vertices, the
/// light is A + max(0, x.L) there and linear on faces; the length of L does not matter.
#[test]
fn light_is_ambient_and_directed() {
    let mesh = shape("sphere:0");
    let labels = labels(&mesh);
    let paint = Paint::Regions { labels: &labels, colors: &PALETTE };
    let plain = Studio { background: [0.0; 3], samples: 2, ..studio(&mesh, paint) };
    let views = views(3, [64, 48]);
    let with = |direction: Option<[f64; 3]>, ambient: f64| {
        let light = Light { direction, ambient };
        Studio { light, ..plain }.photographs(&views).unwrap()
    };
    let unlit = plain.photographs(&views).unwrap();
    assert_eq!(with(None, 1.0), unlit);
    for (half, whole) in with(None, 0.5).iter().zip(&unlit) {
        let pairs = half.pixels.iter().flatten().zip(whole.pixels.iter().flatten());
        assert!(pairs.into_iter().all(|(half, whole)| *half == 0.5 * whole));
    }
    let l = Vector3::new(0.48, -0.6, 0.64);
    let lit = with(Some(<[f64; 3]>::from(1e-3 * l)), 0.25);
    let s: Vec<[f64; 3]> =
        mesh.vertices.iter().map(|x| [0.25 + x.coords.dot(&l).max(0.0); 3]).collect();
    let expected = Studio { paint: Paint::Vertices(&s), ..plain }.photographs(&views).unwrap();
    let white = vec![[1.0; 3]; mesh.vertices.len()];
    let light = Light { direction: Some(l.into()), ambient: 0.25 };
    let found = Studio { paint: Paint::Vertices(&white), light, ..plain }.photographs(&views);
    for (found, expected) in found.unwrap().iter().zip(&expected) {
        assert!(distance(found, expected) <= 1e-12, "{}", distance(found, expected));
    }
    // Colors are multiplied.
    let mut pixels = 0;
    for ((lit, unlit), s) in lit.iter().zip(&unlit).zip(&expected) {
        for ((lit, unlit), s) in lit.pixels.iter().zip(&unlit.pixels).zip(&s.pixels) {
            if PALETTE.contains(unlit) {
                assert!((0..3).all(|i| (lit[i] - s[i] * unlit[i]).abs() <= 1e-12));
                pixels += 1;
            }
        }
    }
    assert!(pixels > 1000);
}

/// The mean and the standard deviation of n independent errors of deviation d are within 5 standard errors, d / sqrt n and d /
/// sqrt(2 n); channels, pixels and views are independent.
#[test]
fn noise_has_the_standard_deviation() {
    let mesh = shape("sphere:2");
    let labels = vec![1; mesh.vertices.len()];
    let plain = studio(&mesh, Paint::Regions { labels: &labels, colors: &PALETTE });
    let views = views(2, [160, 120]);
    let without = plain.photographs(&views).unwrap();
    let errors = |noise: f64, seed: u64| -> Vec<Vec<f64>> {
        let with = Studio { noise, seed, ..plain }.photographs(&views).unwrap();
        let errors = |(with, without): (&Photograph, &Photograph)| {
            let pairs = with.pixels.iter().flatten().zip(without.pixels.iter().flatten());
            pairs.map(|(a, b)| a - b).collect()
        };
        with.iter().zip(&without).map(errors).collect()
    };
    for deviation in [0.05, 0.6] {
        let found = errors(deviation, 3);
        for errors in &found {
            let n = errors.len() as f64;
            let mean = errors.iter().sum::<f64>() / n;
            let found = (errors.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
            assert!(mean.abs() <= 5.0 * deviation / n.sqrt(), "{mean}");
            assert!((found - deviation).abs() <= 5.0 * deviation / (2.0 * n).sqrt(), "{found}");
        }
        let correlation = |a: &[f64], b: &[f64]| {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (a.len() as f64 * deviation * deviation)
        };
        let bound = 5.0 / (found[0].len() as f64).sqrt();
        assert!(correlation(&found[0], &found[1]).abs() <= bound);
        assert!(correlation(&found[0], &found[0][1..]).abs() <= bound);
        assert!(correlation(&found[0], &found[0][3..]).abs() <= bound);
    }
    assert_eq!(errors(0.1, 7), errors(0.1, 7));
    assert_ne!(errors(0.1, 7), errors(0.1, 8));
    assert!(errors(0.0, 7).iter().flatten().all(|error| *error == 0.0));
}

/// Bitwise, as are the sums over photographs in memory and over those in files.
#[test]
fn photographs_have_the_same_bits_with_any_number_of_threads_and_in_files() {
    let mesh = super::torus();
    let mut rng = rng(6);
    let colors: Vec<[f64; 3]> = (0..mesh.vertices.len()).map(|_| rng.random()).collect();
    let light = Light { direction: Some([1.0, 2.0, 3.0]), ambient: 0.3 };
    let studio =
        Studio { light, noise: 0.2, samples: 2, ..studio(&mesh, Paint::Vertices(&colors)) };
    let views = views(5, [80, 60]);
    let with =
        |threads| with_threads(Some(threads), || studio.photographs(&views).unwrap()).unwrap();
    let one = with(1);
    assert!(one == with(2) && one == with(3));

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("views.toml"), to_toml(&views)).unwrap();
    for (view, photograph) in views.iter().zip(&one) {
        let bytes = photograph.bytes().into_flattened();
        let image = image::RgbImage::from_raw(80, 60, bytes).unwrap();
        image.save(folder.path().join(&view.image)).unwrap();
    }
    let options = ViewOptions::default();
    let in_memory = of_photographs(&views, &one, &mesh, &options).unwrap();
    let in_files = read(&folder.path().join("views.toml"), &mesh, &options).unwrap();
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&in_memory.means.values), bits(&in_files.means.values));
    assert_eq!(bits(&in_memory.evidence.variance), bits(&in_files.evidence.variance));
}

/// The nearest surface is seen, from either side; views that show nothing, and faces behind the camera, are reported.
#[test]
fn photographs_show_what_is_nearest() {
    let sphere = shape("sphere:3");
    let n = sphere.vertices.len();
    let both = disjoint([sphere.clone(), sphere.clone().scaled(0.5)]);
    let labels: Vec<usize> = (0..2 * n).map(|k| usize::from(k >= n)).collect();
    let views = views(3, [40, 30]);
    let of = |mesh: &Mesh| {
        let paint = Paint::Regions { labels: &labels[..mesh.vertices.len()], colors: &PALETTE };
        studio(mesh, paint).photographs(&views).unwrap()
    };
    let alone = of(&sphere);
    assert_eq!(of(&both), alone);
    assert_eq!(of(&flipped(sphere.clone())), alone);
    let mut away = sphere.clone();
    let twice = 2.0 * views[0].camera.center().coords;
    away.vertices.iter_mut().for_each(|x| *x += twice);
    let [behind, ..] = &of(&away)[..] else { panic!() };
    assert!(!behind.shows_surface && behind.behind == sphere.faces.len());
    assert!(behind.pixels.iter().all(|pixel| *pixel == [0.5; 3]));
}

/// Each message is one line that says what is wrong.
#[test]
fn impossible_scenes_are_refused() {
    let mesh = shape("sphere:1");
    let n = mesh.vertices.len();
    let labels = vec![2; n];
    let good = studio(&mesh, Paint::Regions { labels: &labels, colors: &PALETTE });
    let one = views(1, [8, 8]);
    let refused = |studio: Studio, views: &[View], clause: &str| {
        let message = studio.photographs(views).unwrap_err().to_string();
        assert!(message.contains(clause) && !message.contains('\n'), "{message}");
    };
    assert!(good.photographs(&one).is_ok() && good.photographs(&[]).unwrap().is_empty());
    let paint = Paint::Regions { labels: &labels[1..], colors: &PALETTE };
    refused(Studio { paint, ..good }, &one, "41 labels for 42 vertices");
    let paint = Paint::Regions { labels: &labels, colors: &PALETTE[..2] };
    refused(
        Studio { paint, ..good },
        &one,
        "vertex 0 has the label 2, but only 2 regions have colors",
    );
    refused(Studio { paint: Paint::Vertices(&PALETTE), ..good }, &one, "3 colors for 42 vertices");
    let nan = vec![[f64::NAN; 3]; n];
    refused(Studio { paint: Paint::Vertices(&nan), ..good }, &one, "must be finite");
    for direction in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 1.0]] {
        let light = Light { direction: Some(direction), ambient: 0.0 };
        refused(Studio { light, ..good }, &one, "must have three finite numbers, not all 0");
    }
    for ambient in [-0.1, f64::NAN, f64::INFINITY] {
        let light = Light { direction: None, ambient };
        refused(Studio { light, ..good }, &one, "the ambient light");
    }
    for noise in [-0.1, f64::NAN, f64::INFINITY] {
        refused(Studio { noise, ..good }, &one, "the noise");
    }
    refused(Studio { background: [0.0, 1.5, 0.0], ..good }, &one, "the background 0,1.5,0");
    let sized = |size: Option<[u32; 2]>| vec![View { size, ..one[0].clone() }];
    refused(good, &sized(None), "the size of view-000.png is not known");
    refused(good, &sized(Some([0, 8])), "cannot have 0 x 8 pixels");
    refused(good, &sized(Some([1 << 20, 1 << 20])), "cannot have 1048576 x 1048576 pixels");
}

/// A photograph of more samples than are in memory at a time has the pixels of one z-buffer.
#[test]
fn large_photographs_are_made_in_bands() {
    let mesh = shape("torus:30x20").scaled(3.0);
    let (size, s) = ([1100, 500], 4);
    let camera = &cameras(2, 4.0, size)[1];
    let color = |x: Vector3<f64>| [x.x.abs(), x.y.abs(), x.z.abs()];
    let found = super::rendered(&mesh, camera, s, color, [0.5; 3]);
    let zbuffer = ZBuffer::new(&mesh, &camera.pinhole, size, s);
    for (i, pixel) in found.pixels.iter().enumerate() {
        let mut mean = Vector3::zeros();
        for k in 0..s * s {
            let (column, row) = (i % size[0] * s + k % s, i / size[0] * s + k / s);
            mean += match zbuffer.face(row * zbuffer.width + column) {
                None => Vector3::repeat(0.5),
                Some(j) => {
                    let pairs = mesh.corners(j).into_iter().zip(zbuffer.on_face(j, column, row));
                    color(pairs.map(|(x, beta)| x.coords * beta).sum()).into()
                }
            } / (s * s) as f64;
        }
        assert!((mean - Vector3::from(*pixel)).amax() <= 1e-12, "{i}");
    }
}

/// The weight of the pixels of a perfect photograph is where its surface is.
#[test]
fn pixels_that_show_the_surface_are_those_that_count() {
    let mesh = shape("torus:30x20").scaled(3.0);
    let ball = Ball::of(&mesh).unwrap();
    let white = vec![[1.0; 3]; mesh.vertices.len()];
    let studio = Studio { background: [0.0; 3], ..studio(&mesh, Paint::Vertices(&white)) };
    let views = around(&ball, 4, 3.0, [90, 70]).unwrap();
    for (view, photograph) in views.iter().zip(studio.photographs(&views).unwrap()) {
        let lit = photograph.pixels.iter().filter(|pixel| pixel[0] > 0.5).count();
        let picture = Picture::of_bytes(90, 70, photograph.bytes());
        let found = of_view(&mesh, &view.camera, &picture, &with_samples(1));
        assert_eq!(found.pixels.used, lit as u64);
    }
}
