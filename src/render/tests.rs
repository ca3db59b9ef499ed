//! Tests of the picture: geometry, cuts, views and colors.

use nalgebra::{Point3, Vector3};

use super::*;
use crate::colormap;
use crate::optics::edge;

const GRAY: [f64; 3] = [0.6; 3];
const BLUE: [f64; 3] = [0.1, 0.3, 0.8];
const HALF: usize = 120;
const BORDER: usize = 4;

/// An n x n grid on [-1, 1]^2 at height z; `from_above` views it from above.
fn plane(n: usize, z: f64) -> Mesh {
    let step = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let vertices =
        (0..(n + 1) * (n + 1)).map(|k| Point3::new(step(k % (n + 1)), step(k / (n + 1)), z));
    let mut faces = Vec::new();
    for i in 0..n {
        for k in 0..n {
            let a = (i * (n + 1) + k) as u32;
            let b = a + n as u32 + 1;
            faces.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    Mesh::new(vertices.collect(), faces)
}

/// Both meshes in one, as separate components.
fn union(mut a: Mesh, b: Mesh) -> Mesh {
    let offset = a.vertices.len() as u32;
    a.vertices.extend(b.vertices);
    a.faces.extend(b.faces.iter().map(|face| face.map(|v| v + offset)));
    a
}

/// Two regions, the second where `second` is positive.
fn field(mesh: &Mesh, second: impl Fn(&Point3<f64>) -> f64) -> Vec<f64> {
    mesh.vertices.iter().flat_map(|x| [0.0, second(x)]).collect()
}

fn from_above(mesh: &Mesh, data: &[[f64; 3]], u: &[f64]) -> RgbImage {
    let scene = Scene::new(mesh, u, 2).unwrap();
    let camera = Camera::fit(Vector3::z(), Vector3::y(), &scene.mesh.vertices);
    drawn(&scene, data, camera)
}

/// Both halves in squares of side `HALF`, the mesh with a margin of `BORDER`.
fn drawn(scene: &Scene, data: &[[f64; 3]], camera: Camera) -> RgbImage {
    let [width, height] = camera.extent();
    let border = BORDER as f64;
    let camera = camera.scaled((HALF as f64 - 2.0 * border) / width.max(height), border);
    let normals = normals::corner_normals(&scene.mesh);
    let layers = halves(scene, data, &[GRAY, BLUE]);
    let halves = scene.draw(&scene.field(), &camera, Some(&normals), &layers, Ground::White);
    let mut both = blank(2 * HALF as u32, HALF as u32);
    for (i, half) in halves.iter().enumerate() {
        copy(&opaque(half), &mut both, [i * HALF, 0]);
    }
    both
}

/// A picture with the first view only, at low resolution.
fn small_preview(mesh: &Mesh, u: &[f64]) -> RgbImage {
    let data = vec![GRAY; mesh.vertices.len()];
    let scene = Scene::new(mesh, u, 2).unwrap();
    drawn(&scene, &data, cameras(&scene).swap_remove(0))
}

/// The number of views.
fn view_count(mesh: &Mesh, u: &[f64]) -> usize {
    cameras(&Scene::new(mesh, u, 2).unwrap()).len()
}

fn cameras(scene: &Scene) -> Vec<Camera> {
    let straight = view::straight_on(&scene.mesh);
    view::cameras(&scene.mesh, &scene.field(), View::Auto, straight)
}

fn is_cut(image: &RgbImage, x: usize, y: usize) -> bool {
    x >= HALF && image.get_pixel(x as u32, y as u32).0.iter().all(|&c| c < 60)
}

fn cut_pixels(image: &RgbImage) -> usize {
    let all = (0..2 * HALF).flat_map(|x| (0..HALF).map(move |y| (x, y)));
    all.filter(|&(x, y)| is_cut(image, x, y)).count()
}

fn is_white(image: &RgbImage, x: usize, y: usize) -> bool {
    image.get_pixel(x as u32, y as u32).0 == [255; 3]
}

/// A bumpy closed surface around the origin.
fn blob() -> Mesh {
    let (rows, columns) = (24, 48);
    let mut vertices = vec![Point3::new(0.0, 1.3, 0.0), Point3::new(0.0, -1.3, 0.0)];
    for i in 1..rows {
        for k in 0..columns {
            let theta = std::f64::consts::PI * i as f64 / rows as f64;
            let phi = std::f64::consts::TAU * k as f64 / columns as f64;
            let r = 1.0 + 0.3 * theta.cos().powi(2) + 0.2 * theta.sin() * (2.0 * phi).sin();
            let (s, c) = theta.sin_cos();
            vertices.push(Point3::new(r * s * phi.cos(), r * c, r * s * phi.sin()));
        }
    }
    let at = |i: usize, k: usize| match i {
        0 => 0,
        i if i == rows => 1,
        i => (2 + (i - 1) * columns + k % columns) as u32,
    };
    let mut faces = Vec::new();
    for i in 0..rows {
        for k in 0..columns {
            faces.push([at(i, k), at(i + 1, k + 1), at(i + 1, k)]);
            faces.push([at(i, k), at(i, k + 1), at(i + 1, k + 1)]);
        }
    }
    faces.retain(|[a, b, c]| a != b && b != c && c != a);
    Mesh::new(vertices, faces)
}

#[test]
fn a_frontal_square_covers_its_pixels_without_holes() {
    for n in [1, 4, 13] {
        let mesh = plane(n, 0.0);
        let data = vec![GRAY; mesh.vertices.len()];
        let image = from_above(&mesh, &data, &field(&mesh, |_| -1.0));
        for x in 0..HALF {
            for y in 0..HALF {
                let depth = x.min(y).min(HALF - 1 - x).min(HALF - 1 - y);
                for x in [x, x + HALF] {
                    if depth < BORDER {
                        assert!(is_white(&image, x, y));
                    } else {
                        assert_eq!(image.get_pixel(x as u32, y as u32), image.get_pixel(60, 60));
                    }
                }
            }
        }
    }
}

#[test]
fn a_surface_facing_the_viewer_keeps_its_color() {
    let mesh = plane(1, 0.0);
    let image = from_above(&mesh, &[BLUE; 4], &field(&mesh, |_| -1.0));
    for (byte, c) in image.get_pixel(60, 60).0.iter().zip(BLUE) {
        assert!((f64::from(*byte) / 255.0 - c).abs() < 0.1, "{byte} {c}");
    }
}

#[test]
fn hidden_surfaces_are_invisible_in_any_order_of_the_faces() {
    let (front, back) = (plane(3, 0.5), plane(3, -0.5).scaled(0.9));
    let gray = vec![GRAY; front.vertices.len()];
    let green = vec![[0.0, 1.0, 0.0]; back.vertices.len()];
    let covered = union(front.clone(), back.clone());
    let colors = [gray.clone(), green.clone()].concat();
    let image = from_above(&covered, &colors, &field(&covered, |_| -1.0));
    let swapped = union(back, front);
    let colors = [green, gray].concat();
    assert_eq!(image, from_above(&swapped, &colors, &field(&swapped, |_| -1.0)));
    assert!(image.pixels().all(|p| p.0[0] == p.0[1]));
}

#[test]
fn the_cut_lies_where_the_labels_change_and_nowhere_else() {
    let mesh = plane(7, 0.0);
    let data = vec![GRAY; mesh.vertices.len()];
    assert_eq!(cut_pixels(&from_above(&mesh, &data, &field(&mesh, |_| -1.0))), 0);
    let image = from_above(&mesh, &data, &field(&mesh, |x| x.x - 0.1));
    // x = 0.1 is 5 % of the square's width to the right of the center.
    let column = HALF as f64 * 1.5 + 0.05 * (HALF - 2 * BORDER) as f64;
    for y in 6..HALF - 6 {
        for x in 0..2 * HALF {
            let distance = (x as f64 + 0.5 - column).abs();
            if distance > 0.5 * labels::LINE_WIDTH + 0.7 {
                assert!(!is_cut(&image, x, y), "{x} {y}");
            } else if distance < 0.5 * labels::LINE_WIDTH - 0.7 {
                assert!(is_cut(&image, x, y), "{x} {y}");
            }
        }
    }
}

#[test]
fn the_contour_of_an_occluder_is_not_a_cut() {
    let small = plane(6, 0.4).scaled(0.5);
    let layered = union(small, plane(6, -0.4));
    let data = vec![GRAY; layered.vertices.len()];
    let image = from_above(&layered, &data, &field(&layered, |x| -x.z));
    assert_eq!(cut_pixels(&image), 0);

    // One component: a sheet with its left half folded over its right half. The labels change on the fold, which the
    // upper half hides.
    let mut folded = plane(16, 0.0);
    for x in &mut folded.vertices {
        (x.x, x.z) = if x.x < 0.0 { (-1.0 - x.x, 0.8) } else { (2.0 * x.x - 1.0, 0.0) };
    }
    let data = vec![GRAY; folded.vertices.len()];
    let image = from_above(&folded, &data, &field(&folded, |x| 0.4 - x.z));
    let region = |x: usize| image.get_pixel((HALF + x) as u32, 60).0;
    assert_ne!(region(HALF / 4), region(3 * HALF / 4));
    assert_eq!(cut_pixels(&image), 0);
}

#[test]
fn no_cut_runs_between_components_that_touch() {
    let mut left = plane(8, 0.0);
    let mut right = left.clone();
    for (a, b) in left.vertices.iter_mut().zip(&mut right.vertices) {
        (a.x, b.x) = (0.5 * a.x - 0.5, 0.5 * b.x + 0.5);
    }
    let split = left.vertices.len();
    let both = union(left, right);
    let data = vec![GRAY; 2 * split];
    let u: Vec<f64> =
        (0..2 * split).flat_map(|k| [0.0, if k < split { -1.0 } else { 1.0 }]).collect();
    assert_eq!(cut_pixels(&from_above(&both, &data, &u)), 0);
}

#[test]
fn a_cut_behind_the_surface_is_hidden() {
    let covered = union(plane(5, 0.5), plane(5, -0.5).scaled(0.9));
    let data = vec![GRAY; covered.vertices.len()];
    let u = field(&covered, |x| if x.z < 0.0 { x.x } else { -1.0 });
    assert_eq!(cut_pixels(&from_above(&covered, &data, &u)), 0);
}

#[test]
fn position_and_scale_of_the_mesh_do_not_matter() {
    let mesh = blob();
    let u = field(&mesh, |x| x.x + 0.3 * x.y);
    let image = small_preview(&mesh, &u);
    assert!(cut_pixels(&image) > 100);
    assert_eq!(image, small_preview(&mesh.clone().scaled(1.0 / 1024.0), &u));
    for (c, shift) in [(1e-4, 0.0), (1e4, 1e6), (1.0, -1e5)] {
        let mut moved = mesh.clone().scaled(c);
        for x in &mut moved.vertices {
            x.coords += Vector3::repeat(shift);
        }
        let other = small_preview(&moved, &u);
        let pairs = image.as_raw().iter().zip(other.as_raw());
        let changed = pairs.filter(|(a, b)| a.abs_diff(**b) > 4).count();
        assert!(changed < image.as_raw().len() / 1000, "{c} {shift}: {changed}");
    }
}

#[test]
fn orientation_does_not_matter_and_the_same_input_gives_the_same_bytes() {
    let mesh = blob();
    let u = field(&mesh, |x| x.z);
    let image = small_preview(&mesh, &u);
    assert_eq!(image, small_preview(&mesh, &u));
    let mut mixed = mesh.clone();
    for face in mixed.faces.iter_mut().step_by(2) {
        face.swap(1, 2);
    }
    let other = small_preview(&mixed, &u);
    let pairs = image.as_raw().iter().zip(other.as_raw());
    let changed = pairs.filter(|(a, b)| a.abs_diff(**b) > 4).count();
    assert!(changed < image.as_raw().len() / 1000, "{changed}");
}

#[test]
fn unreferenced_vertices_do_not_matter() {
    let mesh = blob();
    let mut extended = mesh.clone();
    extended.vertices.push(Point3::new(1e9, f64::NAN, 0.0));
    let second = |x: &Point3<f64>| x.z;
    assert_eq!(
        small_preview(&mesh, &field(&mesh, second)),
        small_preview(&extended, &field(&extended, second))
    );
}

/// The whole picture, in palette colors.
fn picture(mesh: &Mesh, u: &[f64], view: View) -> RgbImage {
    let data = vec![GRAY; mesh.vertices.len()];
    let regions = [0, 1].map(|p| Region {
        color: colormap::categorical(p),
        mean: Some(GRAY),
        text: format!("{p}   50.0 %"),
    });
    Picture { mesh, data: &data, caption: "colors", regions: &regions, u, view }.draw()
}

#[test]
fn a_mesh_without_extent_leaves_the_picture_white() {
    let white = |mesh: &Mesh| {
        let image = picture(mesh, &vec![0.5; 2 * mesh.vertices.len()], View::Auto);
        assert_eq!(image.width(), 2 * HALF_SIZE as u32);
        let top = legend::CAPTION_HEIGHT as u32;
        let rows = top..top + HALF_SIZE as u32;
        image.enumerate_pixels().filter(|(_, y, _)| rows.contains(y)).all(|p| p.2.0 == [255; 3])
    };
    assert!(white(&Mesh::default()));
    assert!(white(&Mesh::new(vec![Point3::origin()], vec![[0, 0, 0]])));
    let axis = [0.0, 1.0, 2.0].map(|s| Point3::new(s, 0.0, 0.0)).to_vec();
    let line = picture(&Mesh::new(axis, vec![[0, 1, 2]]), &[0.5; 6], View::Auto);
    assert!(line.height() < HALF_SIZE as u32);
}

/// Stripes a few pixels wide: the line leaves at least half of each.
#[test]
fn the_line_covers_at_most_half_of_thin_regions() {
    let mesh = plane(224, 0.0);
    let data = vec![GRAY; mesh.vertices.len()];
    for width in [4, 8, 16] {
        let stripe = |x: f64| ((x + 1.0) / 2.0 * 224.0 / f64::from(width)).floor() as i32 % 2;
        let u = field(&mesh, |x| if stripe(x.x + 1e-9) == 0 { 1.0 } else { -1.0 });
        let image = from_above(&mesh, &data, &u);
        // Summed darkness instead of counted pixels, since thin lines are faint.
        let half = HALF - 2 * BORDER;
        let covered: f64 = (HALF + BORDER..2 * HALF - BORDER)
            .map(|x| {
                let [r, g, b] = image.get_pixel(x as u32, 60).0.map(f64::from);
                (1.0 - (r + g + b) / (3.0 * 110.0)).clamp(0.0, 1.0)
            })
            .sum();
        assert!(covered < 0.55 * half as f64, "{width}: {covered} of {half}");
        assert!(covered > 0.02 * half as f64, "{width}: {covered}");
    }
}

/// Regions are shown in palette colors, not in their means.
#[test]
fn regions_of_equal_means_look_different() {
    let mesh = plane(4, 0.0);
    let image = picture(&mesh, &field(&mesh, |x| x.x - 0.1), View::Auto);
    let (width, y) = (image.width(), image.height() / 2);
    assert_ne!(image.get_pixel(width * 5 / 8, y), image.get_pixel(width * 7 / 8, y));
    // A flat mesh is unlit: its colors are those of the legend.
    let byte = colormap::categorical(0).map(|c| (255.0 * c).round() as u8);
    assert_eq!(image.get_pixel(width * 5 / 8, y).0, byte);
}

#[test]
fn a_flat_mesh_fills_its_half_and_keeps_its_proportions() {
    let mut mesh = plane(4, 0.0);
    for x in &mut mesh.vertices {
        x.y *= 0.25;
    }
    let image = picture(&mesh, &field(&mesh, |_| -1.0), View::Auto);
    let margin = MARGIN as u32;
    assert_eq!(image.width(), 2 * HALF_SIZE as u32);
    assert!(image.get_pixel(margin + 1, image.height() / 2 - 10).0 != [255; 3]);
    assert!(image.height() < 200 + 2 * margin + 100, "{}", image.height());
}

#[test]
fn a_second_view_is_added_if_the_first_one_hides_much() {
    let ball = blob();
    assert_eq!(view_count(&ball, &field(&ball, |x| x.x)), 2);
    let flat = plane(6, 0.0);
    assert_eq!(view_count(&flat, &field(&flat, |x| x.x)), 1);
    // A shallow bowl is viewed from the inside.
    let mut bowl = plane(12, 0.0);
    for x in &mut bowl.vertices {
        *x = Point3::new(x.x, 0.08 * (x.x * x.x + x.y * x.y), x.y);
    }
    assert_eq!(view_count(&bowl, &field(&bowl, |x| x.x)), 1);
}

#[test]
fn views_parse_from_axes_sides_and_angles() {
    let view = |text: &str| text.parse::<View>();
    assert_eq!(view("auto"), Ok(View::Auto));
    assert_eq!(view("-y"), Ok(View::Axis { axis: 1, positive: false }));
    assert_eq!(view("front"), view("0,0"));
    assert_eq!(view("back"), view("180, 0"));
    assert_eq!(view("-30,12.5"), Ok(View::Around { azimuth: -30.0, elevation: 12.5 }));
    for text in ["", "left", "1", "0,91", "nan,0", "0,nan", "--z", "1,2,3"] {
        assert!(view(text).is_err(), "{text}");
    }
    // Each view shows its side.
    let mesh = blob();
    let sides = [("x", 0, 1.0), ("-x", 0, -1.0), ("y", 1, 1.0), ("-y", 1, -1.0), ("z", 2, 1.0)];
    for (text, axis, sign) in
        sides.into_iter().chain([("-z", 2, -1.0), ("90,0", 0, 1.0), ("0,90", 1, 1.0)])
    {
        let u = field(&mesh, |x| sign * x[axis] - 0.2);
        let image = picture(&mesh, &u, view(text).unwrap());
        let middle = image.get_pixel(image.width() * 3 / 4, image.height() / 2).0.map(i32::from);
        let orange = colormap::categorical(1).map(|c| (255.0 * c) as i32);
        let ratio = |[r, _, b]: [i32; 3]| f64::from(b) / f64::from(r);
        assert!(ratio(middle) < 0.3 && ratio(orange) < 0.3, "{text} {middle:?}");
    }
}

#[test]
fn the_view_shows_the_side_with_the_regions() {
    let mesh = blob();
    for angle in 0..8 {
        let (s, c) = f64::from(angle).sin_cos();
        let spot = field(&mesh, |x| c * x.x + s * x.z - 0.8);
        assert!(cut_pixels(&small_preview(&mesh, &spot)) > 30, "{angle}");
    }
}

#[test]
fn a_flat_mesh_is_viewed_straight_on_in_any_plane() {
    let upright = plane(4, 0.0);
    let u = field(&upright, |x| x.x - 0.1);
    let image = small_preview(&upright, &u);
    let turns: [fn(f64, f64) -> [f64; 3]; 2] = [|x, y| [x, 0.0, -y], |x, y| [0.0, y, -x]];
    for turn in turns {
        let mut mesh = upright.clone();
        for x in &mut mesh.vertices {
            *x = turn(x.x, x.y).into();
        }
        let other = small_preview(&mesh, &u);
        let pairs = image.as_raw().iter().zip(other.as_raw());
        assert!(pairs.filter(|(a, b)| a.abs_diff(**b) > 4).count() < 100);
    }
}

#[test]
fn the_camera_fits_the_mesh_exactly() {
    let mesh = blob();
    let camera = Camera::fit(Vector3::new(1.0, 0.4, 0.7), Vector3::y(), &mesh.vertices);
    let [width, height] = camera.extent();
    let camera = camera.scaled(100.0 / width.max(height), 7.0);
    let reach = |f: fn(&edge::Projected) -> f64| {
        let values = || mesh.vertices.iter().map(|&x| f(&camera.project(x)));
        (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
    };
    let (x, y) = (reach(|p| p.x), reach(|p| p.y));
    assert!((x.0 - 7.0).abs() < 1e-9 && (y.0 - 7.0).abs() < 1e-9, "{x:?} {y:?}");
    assert!((x.1.max(y.1) - 107.0).abs() < 1e-9, "{x:?} {y:?}");
    let [w, h] = camera.size();
    assert!(w as f64 - x.1 >= 7.0 - 1e-9 && h as f64 - y.1 >= 7.0 - 1e-9, "{x:?} {y:?}");
}

#[test]
fn normals_are_smooth_on_smooth_surfaces_and_keep_creases() {
    let mut mesh = blob();
    for x in &mut mesh.vertices {
        x.coords.normalize_mut();
    }
    for face in mesh.faces.iter_mut().step_by(3) {
        face.swap(0, 1);
    }
    let normals = normals::corner_normals(&mesh);
    for (face, normals) in mesh.faces.iter().zip(&normals) {
        for (&v, n) in face.iter().zip(normals) {
            let radial = mesh.vertices[v as usize].coords.cast::<f32>();
            assert!(n.dot(&radial).abs() > 0.995);
        }
    }
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = vec![[0, 1, 2], [0, 3, 1]];
    let crease = Mesh::new(corners.map(Point3::from).to_vec(), faces);
    let normals = normals::corner_normals(&crease);
    assert_eq!(normals, vec![[Vector3::z(); 3], [Vector3::y(); 3]]);
}

#[test]
fn srgb_survives_the_round_trip_through_linear_light() {
    for byte in 0..=255_u8 {
        let [linear, ..] = shading::linear_from_srgb([f64::from(byte) / 255.0; 3]);
        assert_eq!(shading::srgb_from_linear([linear; 3]), [byte; 3]);
    }
}
