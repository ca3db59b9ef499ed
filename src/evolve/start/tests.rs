//! Starts are closed surfaces of the right size; hulls have the shape and the genus of what the views show.

use super::*;
use crate::data::views::{self, Ball};
use crate::evolve::folds::{self, Folds};
use crate::evolve::silhouette::{Silhouette, overlap};
use crate::mesh::distance::between;
use crate::mesh::{Mesh, Statistics};
use crate::optics::pinhole::Pinhole;
use crate::samples::{disjoint, random_rotation, random_vector, rng, shape};
use crate::sweep::with_threads;
use nalgebra::{Matrix3, Vector3};

fn assert_closed(mesh: &Mesh, euler_characteristic: i64, components: usize) {
    let found = Statistics::of(mesh);
    assert_eq!((found.euler_characteristic, found.components), (euler_characteristic, components));
    let defects = [
        found.boundary_edges,
        found.non_manifold_edges,
        found.inconsistent_edges,
        found.degenerate_faces,
        found.duplicate_faces,
        found.unreferenced_vertices,
    ];
    assert_eq!(defects, [0; 6]);
}

fn volume(mesh: &Mesh) -> f64 {
    let part = |j: usize| {
        let [a, b, c] = mesh.corners(j).map(|x| x.coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    (0..mesh.faces.len()).map(part).sum()
}

fn cameras(ball: &Ball, n: usize, size: [usize; 2]) -> Vec<(Pinhole, [usize; 2])> {
    let views = views::around(ball, n, 4.0, size.map(|n| n as u32)).unwrap();
    views.into_iter().map(|view| (view.camera, size)).collect()
}

const UNIT: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 1.0 };

fn silhouettes(mesh: &Mesh, n: usize) -> Vec<Silhouette> {
    let cameras = cameras(&UNIT, n, [160, 120]);
    cameras.into_iter().map(|(camera, size)| Silhouette::of(mesh, &camera, size)).collect()
}

#[test]
fn spheres_have_their_center_and_radius() {
    let center = Point3::new(3.0, -1.0, 2.0);
    let mesh = sphere(center, 0.7, 3);
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (642, 1280));
    assert!(mesh.vertices.iter().all(|x| ((x - center).norm() - 0.7).abs() <= 1e-15));
    assert_closed(&mesh, 2, 1);
}

#[test]
fn boxes_have_their_volume_and_area() {
    let (low, high) = (Point3::new(-1.0, 2.0, 0.0), Point3::new(2.0, 3.0, 0.5));
    for cells in [1, 2, 7] {
        let mesh = cuboid(low, high, cells);
        assert_closed(&mesh, 2, 1);
        assert!((volume(&mesh) - 1.5).abs() <= 1e-14);
        assert!((mesh.area() - 2.0 * (3.0 + 1.5 + 0.5)).abs() <= 1e-14);
    }
    assert_eq!(cuboid(low, high, 6).faces.len(), 2 * 2 * (6 * 2 + 6 + 2));
}

/// The rays through the nearer borders of the image have the slope h / 2f, and all cameras look at the center.
#[test]
fn the_ball_that_all_cameras_see_touches_the_borders_of_their_images() {
    let mut rng = rng(5);
    for (n, size) in [(3, [160, 120]), (24, [60, 90])] {
        let ball = Ball { center: Point3::from(5.0 * random_vector(&mut rng)), radius: 0.4 };
        let found = around(&cameras(&ball, n, size)).unwrap();
        assert!((found.center - ball.center).norm() <= 1e-12 * 5.0);
        let slope = 1.0 / (0.9 * 15.0_f64.sqrt());
        let expected = 1.6 * slope / slope.hypot(1.0);
        assert!((found.radius - expected).abs() <= 1e-12, "{} {expected}", found.radius);
        // Cameras that are moved and turned with the scene.
        let (turn, by) = (*random_rotation(&mut rng).matrix(), random_vector(&mut rng));
        let moved = |(camera, size): (Pinhole, _)| (camera.moved(10.0, turn, by), size);
        let moved = around(&cameras(&ball, n, size).into_iter().map(moved).collect::<Vec<_>>());
        let moved = moved.unwrap();
        let center = Point3::from(10.0 * (turn * ball.center.coords) + by);
        assert!((moved.center - center).norm() <= 1e-10);
        assert!((moved.radius - 10.0 * expected).abs() <= 1e-10);
    }
}

#[test]
fn cameras_that_do_not_look_at_one_point_are_refused() {
    let fails = |cameras: &[(Pinhole, [usize; 2])], clause: &str| {
        let message = around(cameras).unwrap_err().to_string();
        assert!(message.contains(clause) && !message.contains('\n'), "{message}");
    };
    fails(&[], "same direction");
    fails(&cameras(&UNIT, 1, [160, 120]), "same direction");
    let k = Matrix3::new(100.0, 0.0, 79.5, 0.0, 100.0, 59.5, 0.0, 0.0, 1.0);
    let at = |r: Matrix3<f64>, x: f64| {
        (Pinhole::new(k, r, -(r * Vector3::new(x, 0.0, 0.0))).unwrap(), [160, 120])
    };
    let i = Matrix3::identity();
    fails(&[at(i, -1.0), at(i, 1.0)], "same direction");
    // Back to back: the point between them is behind both.
    let back = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0);
    let right = Matrix3::new(0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
    fails(&[at(i, 0.0), at(back, 0.1), at(right, 0.2)], "one point");
}

/// The hull of a ball contains it, and comes close to it between the contours.
#[test]
fn the_hull_of_a_sphere_is_one_within_a_voxel() {
    let ball = sphere(Point3::new(0.1, -0.05, 0.0), 0.8, 5);
    for resolution in [16, 32, 48] {
        let found = hull(&silhouettes(&ball, 24), resolution).unwrap();
        assert_closed(&found, 2, 1);
        let voxel = 1.6 / resolution as f64 / (1.6 * 3.0_f64.sqrt());
        let distances = between(&found, &ball);
        assert!(distances.largest <= voxel, "{resolution}: {distances:?} {voxel}");
        assert!(distances.mean <= 0.3 * voxel, "{resolution}: {distances:?} {voxel}");
        assert_eq!(folds::count(&found), Folds { folded_edges: 0, intersecting_pairs: 0 });
    }
}

#[test]
fn the_hull_of_a_torus_has_its_hole() {
    let torus = shape("torus:80x50").scaled(2.8);
    let silhouettes = silhouettes(&torus, 24);
    for (resolution, least) in [(24, 0.96), (40, 0.975)] {
        let found = hull(&silhouettes, resolution).unwrap();
        assert_closed(&found, 0, 1);
        let distances = between(&found, &torus);
        assert!(distances.mean <= 0.02, "{distances:?}");
        let filled = overlap(&found, &silhouettes).iou();
        assert!(filled >= least, "{resolution}: {filled}");
    }
}

#[test]
fn hulls_have_well_shaped_faces_and_the_same_bits_with_any_number_of_threads() {
    let torus = shape("torus:80x50").scaled(2.8);
    let silhouettes = silhouettes(&torus, 12);
    let with = |threads| with_threads(Some(threads), || hull(&silhouettes, 20).unwrap()).unwrap();
    let found = with(1);
    assert_eq!(found, with(2));
    let quality = |j: usize| {
        let [a, b, c] = found.corners(j);
        let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
        4.0 * 3.0_f64.sqrt() * found.face_area(j) / squares
    };
    let mut qualities: Vec<f64> = (0..found.faces.len()).map(quality).collect();
    qualities.sort_by(f64::total_cmp);
    assert!(qualities[0] > 0.1 && qualities[qualities.len() / 20] > 0.5, "{}", qualities[0]);
}

#[test]
fn two_bodies_have_two_hulls_and_specks_none() {
    let at = |x: f64, radius: f64| sphere(Point3::new(x, 0.0, 0.0), radius, 4);
    let two = disjoint([at(-0.5, 0.3), at(0.5, 0.3)]);
    assert_closed(&hull(&silhouettes(&two, 24), 40).unwrap(), 4, 2);
    let speck = disjoint([at(-0.5, 0.4), at(0.8, 0.05)]);
    assert_closed(&hull(&silhouettes(&speck, 24), 40).unwrap(), 2, 1);
}

#[test]
fn silhouettes_without_a_hull_are_refused() {
    let ball = sphere(Point3::origin(), 0.5, 3);
    let fails = |silhouettes: &[Silhouette], clause: &str| {
        let message = hull(silhouettes, 16).unwrap_err().to_string();
        assert!(message.contains(clause) && !message.contains('\n'), "{message}");
    };
    fails(&[], "same direction");
    let good = silhouettes(&ball, 6);
    let mut empty = good.clone();
    empty[2].inside.fill(false);
    fails(&empty, "view 3 is empty");
    // What one view shows at the left, another one shows above.
    let mut apart = good.clone();
    let corner = |s: &mut Silhouette, right: bool, below: bool| {
        s.inside.fill(false);
        let pixel = usize::from(right) * 155 + usize::from(below) * 115 * 160;
        s.inside[pixel] = true;
    };
    (0..6).for_each(|i| corner(&mut apart[i], i % 2 == 0, i % 3 == 0));
    fails(&apart, "no point");
    fails(&good[..1], "same direction");
}
