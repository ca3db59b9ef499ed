//! From files to labels.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use tempfile::TempDir;

use super::scene::{BALL, Camera, rendered};
use super::torus;
use crate::data::views::{PixelWeights, View, ViewOptions, Viewed, around, read, to_toml};
use crate::data::{DataModel, Initial, Radiance};
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::operator::Mass;
use crate::run::Stop;
use crate::samples::{disjoint, rng, shape};
use crate::segment::{Alternation, segment};
use crate::solve::Request;
use crate::sweep::with_threads;

const PALETTE: [[f64; 3]; 3] = [[0.8, 0.2, 0.2], [0.2, 0.7, 0.3], [0.3, 0.3, 0.9]];

/// Three bands.
fn region(x: Vector3<f64>) -> usize {
    let turned = x.z + 0.3 * x.x;
    usize::from(turned > -0.3) + usize::from(turned > 0.35)
}

fn png(path: &Path, [w, h]: [usize; 2], pixel: impl Fn(usize) -> [u8; 3]) {
    let mut image = image::RgbImage::new(w as u32, h as u32);
    image.pixels_mut().enumerate().for_each(|(i, to)| to.0 = pixel(i));
    image.save(path).unwrap();
}

/// A folder with `views.toml` and images of a mesh in three colors; `change` changes each view in the file.
fn scene(
    mesh: &Mesh,
    n: usize,
    size: [usize; 2],
    change: impl Fn(&mut View),
) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let mut views = around(&BALL, n, 4.0, size.map(|n| n as u32)).unwrap();
    for view in &mut views {
        let camera = Camera { pinhole: view.camera, size };
        let colors = rendered(mesh, &camera, 3, |x| PALETTE[region(x)], [0.0; 3]).bytes();
        png(&folder.path().join(&view.image), size, |i| colors[i]);
        change(view);
    }
    let path = folder.path().join("views.toml");
    std::fs::write(&path, to_toml(&views)).unwrap();
    (folder, path)
}

/// Images of unknown size.
fn unsized_view(view: &mut View) {
    view.size = None;
}

/// Synthetic views of a labeled sphere give its labels and colors back.
#[test]
fn views_of_a_labeled_surface_give_its_labels_and_colors() {
    let mesh = shape("sphere:4");
    let (_folder, path) = scene(&mesh, 12, [160, 120], |_| ());
    let areas = barycentric_areas(&mesh);
    for weights in [PixelWeights::Pixel, PixelWeights::Angle, PixelWeights::Unit] {
        let options = ViewOptions { weights, pure: 2, grazing: 0.2, ..ViewOptions::default() };
        let Viewed { means, evidence, coverage } = read(&path, &mesh, &options).unwrap();
        assert_eq!((coverage.views, coverage.views_used), (12, 12));
        assert!(coverage.unseen_share == 0.0 && coverage.warnings.is_empty());
        let mean: f64 = evidence.density.iter().zip(&areas).map(|(r, a)| r * a).sum();
        assert!((mean / mesh.area() - 1.0).abs() <= 1e-12);
        let model = Radiance::new(&means, &evidence);
        let request = Request {
            lambda: 0.002,
            relaxation: Default::default(),
            mass: Mass::Barycentric,
            method: crate::solver::Method::default(),
            stop: Stop { relative_gap: Some(1e-4), ..Stop::default() },
            coarse_to_fine: true,
            keep_dual: false,
            rounding: Default::default(),
            label_gap: None,
        };
        let alternation = Alternation {
            regions: 3,
            initial: Initial::KMeans,
            seed: 0,
            every: 10,
            labels: None,
            seeds: Default::default(),
        };
        let mut observe = |_: Option<&_>| std::ops::ControlFlow::Continue(());
        let found = segment(&mesh, &model, &alternation, &request, &mut observe).unwrap();
        // The region of each color.
        let order = PALETTE.map(|color| {
            let distance = |p: &usize| -> f64 {
                let pairs = found.parameters[*p].mean.iter().zip(color);
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let p = (0..3).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            assert!(distance(&p) < 0.02, "{:?}", found.parameters);
            p
        });
        let right: f64 = (0..mesh.vertices.len())
            .filter(|&k| {
                found.solution.labels[k] as usize == order[region(mesh.vertices[k].coords)]
            })
            .map(|k| areas[k])
            .sum();
        assert!(right > 0.985 * mesh.area(), "{weights:?} {}", right / mesh.area());
    }
}

/// Bitwise, with several views in memory at a time.
#[test]
fn statistics_have_the_same_bits_with_any_number_of_threads() {
    let mesh = torus();
    let (_folder, path) = scene(&mesh, 9, [80, 60], unsized_view);
    let with = |threads| {
        let read = || read(&path, &mesh, &ViewOptions::default()).unwrap();
        let Viewed { means, evidence, .. } = with_threads(Some(threads), read).unwrap();
        let numbers = [means.values, evidence.density, evidence.variance].concat();
        numbers.into_iter().map(f64::to_bits).collect::<Vec<u64>>()
    };
    let one = with(1);
    assert!([2, 3, 4].iter().all(|&threads| with(threads) == one));
}

/// A vertex that no pixel sees costs nothing.
#[test]
fn unseen_vertices_are_unknown() {
    let sphere = shape("sphere:3");
    let mesh = disjoint([sphere.clone(), sphere.clone().scaled(0.5)]);
    let (_folder, path) = scene(&sphere, 8, [80, 60], unsized_view);
    let Viewed { means, evidence, coverage } = read(&path, &mesh, &ViewOptions::default()).unwrap();
    let n = sphere.vertices.len();
    let model = Radiance::new(&means, &evidence);
    assert!((0..n).all(|k| model.is_known(k)) && (n..2 * n).all(|k| !model.is_known(k)));
    let mu = model.start(Initial::KMeans, 3, &barycentric_areas(&mesh), &mut rng(1)).unwrap();
    let costs = model.costs::<3>(&mu);
    assert!(costs.iter().all(|s| s.0.iter().all(|s| s.is_finite())));
    assert!(costs[n..].iter().all(|s| s.0 == [0.0; 3]));
    // A quarter of the area of the other sphere.
    assert!((coverage.unseen_share - 0.2).abs() < 1e-9, "{}", coverage.unseen_share);
    assert!(coverage.warnings[0].contains("20.00 % of the area"), "{:?}", coverage.warnings);
}

/// Masks leave out what is dark.
#[test]
fn masks_leave_out_dark_pixels() {
    let mesh = shape("sphere:3");
    let (folder, path) = scene(&mesh, 6, [80, 60], |view| view.mask = Some("mask.png".into()));
    png(&folder.path().join("mask.png"), [80, 60], |i| [if i % 80 < 40 { 255 } else { 0 }; 3]);
    let masked = read(&path, &mesh, &ViewOptions::default()).unwrap().coverage;
    let sum = masked.pixels_used + masked.pixels_left_out;
    assert!(masked.pixels_used.abs_diff(masked.pixels_left_out) < sum / 20);
    png(&folder.path().join("mask.png"), [80, 60], |_| [0; 3]);
    let error = read(&path, &mesh, &ViewOptions::default()).err().unwrap().to_string();
    assert!(error.contains("dark in the masks"), "{error}");
    png(&folder.path().join("mask.png"), [80, 59], |_| [0; 3]);
    let error = read(&path, &mesh, &ViewOptions::default()).err().unwrap().to_string();
    assert!(error.contains("80 x 59 pixels, but its image 80 x 60"), "{error}");
}

/// Each message is one line that says what is wrong.
#[test]
fn views_that_do_not_fit_are_refused() {
    let sphere = shape("sphere:2");
    let refused = |mesh: &Mesh, path: &Path, options: &ViewOptions, clause: &str| {
        let message = read(path, mesh, options).err().unwrap().to_string();
        assert!(message.contains(clause) && !message.contains('\n'), "{message}");
    };
    let all = ViewOptions::default();
    let (folder, path) = scene(&sphere, 3, [80, 60], |view| view.size = Some([640, 480]));
    refused(&sphere, &path, &all, "has 80 x 60 pixels, but its camera is for 640 x 480");
    let elsewhere = ViewOptions { images: Some("nowhere".into()), ..all.clone() };
    refused(&sphere, &path, &elsewhere, "3 of its images do not exist");
    std::fs::remove_file(folder.path().join("view-001.png")).unwrap();
    refused(&sphere, &path, &all, "view-001.png: does not exist");
    std::fs::write(folder.path().join("view-001.png"), b"text").unwrap();
    std::fs::remove_file(folder.path().join("view-000.png")).unwrap();
    std::fs::write(folder.path().join("view-000.png"), b"text").unwrap();
    refused(&sphere, &path, &all, "view-000.png: is neither a PNG nor a JPEG");

    let (_folder, path) = scene(&sphere, 3, [80, 60], unsized_view);
    let mut away = sphere.clone();
    away.vertices.iter_mut().for_each(|x| *x += Vector3::new(50.0, 60.0, 70.0));
    refused(&away, &path, &all, "the surface");
    let mut inside_out = sphere.clone();
    inside_out.faces.iter_mut().for_each(|face| face.swap(0, 1));
    refused(&inside_out, &path, &all, "oriented inwards");
    let border = ViewOptions { border: 30, ..all.clone() };
    refused(&sphere, &path, &border, "lower --border");
    let pure = ViewOptions { pure: 60, ..all };
    refused(&sphere, &path, &pure, "lower --pure");
}
