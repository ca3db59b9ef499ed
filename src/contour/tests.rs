use nalgebra::{Point3, Vector3};
use ndarray::{Array1, Array2};
use rand::RngExt;
use rand::seq::SliceRandom;

use super::face::{BITS, Partition};
use super::*;
use crate::field::Row;
use crate::mesh::{Mesh, Statistics};
use crate::operator::Mass;
use crate::regions;
use crate::request::Request;
use crate::run::Stop;
use crate::samples::{
    assert_within, bumpy, observed_order, random_rotation, random_rows, rng, shape, shuffled, soup,
    zoo,
};
use crate::solve::problem_of;
use crate::sweep::with_threads;

/// U with u_p at each vertex from a function of its position.
fn field(mesh: &Mesh, m: usize, u: impl Fn(&Point3<f64>, usize) -> f64) -> Array2<f64> {
    Array2::from_shape_fn((mesh.vertices.len(), m), |(v, p)| u(&mesh.vertices[v], p))
}

/// Two regions of a function: the first where it is positive.
fn two(mesh: &Mesh, d: impl Fn(&Point3<f64>) -> f64) -> Array2<f64> {
    field(mesh, 2, |x, p| (0.5 + if p == 0 { d(x) } else { -d(x) }).clamp(0.0, 1.0))
}

fn one_hot(labels: &[usize], m: usize) -> Array2<f64> {
    Array2::from_shape_fn((labels.len(), m), |(v, p)| f64::from(u8::from(labels[v] == p)))
}

/// Random rows of the simplex, or of few values, so that entries tie at corners, along edges and in faces.
fn random_field(vertices: usize, m: usize, values: Option<i32>, seed: u64) -> Array2<f64> {
    let mut rng = rng(seed);
    Array2::from_shape_fn((vertices, m), |_| match values {
        Some(values) => f64::from(rng.random_range(0..=values)) / f64::from(values),
        None => rng.random::<f64>(),
    })
}

/// Everything that must hold for the cells of any U.
fn check(mesh: &Mesh, u: &Array2<f64>, name: &str) {
    let cells = Cells::new(mesh, u.view(), None);
    let (areas, area) = (cells.areas(), mesh.area());
    assert_within(areas.iter().sum(), area, 1e-12, area);
    let (cut, labels) = cells.cut_mesh();
    assert_within(cut.area(), area, 1e-12, area);
    assert_eq!(cut.vertices[..mesh.vertices.len()], mesh.vertices, "{name}");
    // Every node lies in each face that it is a node of.
    for face in &cells.divided {
        let x = mesh.corners(face.face).map(|x| x.coords);
        let size = x.iter().map(|x| x.norm()).fold(0.0, f64::max);
        for node in &face.nodes {
            let b = node.barycentric;
            assert!(b.iter().all(|&b| b >= 0.0) && (b.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            let point = (0..3).map(|i| b[i] * x[i]).sum::<Vector3<f64>>();
            assert!((cells.point(node.id).coords - point).norm() <= 1e-15 * size, "{name}");
        }
    }
    let mut of_labels = vec![0.0; u.ncols()];
    (0..labels.len()).for_each(|j| of_labels[usize::from(labels[j])] += cut.face_area(j));
    for (a, b) in of_labels.into_iter().zip(areas) {
        assert_within(a, b, 1e-12, area);
    }
    let (before, after) = (Statistics::of(mesh), Statistics::of(&cut));
    assert_eq!(before.components, after.components, "{name}");
    let contours = cells.contours();
    // The chords in two faces with the same corners are one edge of the cut mesh, but two of the contour.
    if before.duplicate_faces == 0 && before.degenerate_faces == 0 {
        assert_eq!(before.euler_characteristic, after.euler_characteristic, "{name}");
        assert_eq!(before.boundary_loops, after.boundary_loops, "{name}");
        assert_eq!(before.inconsistent_edges == 0, after.inconsistent_edges == 0, "{name}");
        assert_eq!(before.non_manifold_edges == 0, after.non_manifold_edges == 0, "{name}");
        // The contour is where the faces of the cut mesh have different labels.
        let length = contours.length();
        assert_within(length, length_between_labels(&cut, &labels), 1e-12, length + area.sqrt());
    }
    for polyline in &contours.polylines {
        let [p, r] = polyline.regions;
        assert!(p < r && polyline.points.len() >= 2, "{name}");
        assert!(polyline.points.windows(2).all(|ends| ends[0] != ends[1]), "{name}");
    }
}

/// The total length of the edges between faces of different labels, once for each pair of labels.
fn length_between_labels(mesh: &Mesh, labels: &[u8]) -> f64 {
    let mut edges: Vec<([u32; 2], u8)> = Vec::new();
    for (face, &p) in mesh.faces.iter().zip(labels) {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], p));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let length = |[a, b]: [u32; 2]| (mesh.vertices[a as usize] - mesh.vertices[b as usize]).norm();
    let pairs = |count: usize| (count * (count - 1) / 2) as f64;
    edges.chunk_by(|(a, _), (b, _)| a == b).map(|e| pairs(e.len()) * length(e[0].0)).sum()
}

/// Cells of a single face: they partition it, and hold the points at which their region is the largest.
#[test]
fn the_cells_of_a_face_are_those_of_brute_force() {
    let mut rng = rng(2201);
    let unit = 1_i64 << BITS;
    let mut interior = 0;
    for case in 0..4000 {
        let m = rng.random_range(2..=9);
        let coarse = [1, 2, 3, 1000, unit][case % 5];
        let values: Vec<[i64; 3]> =
            (0..m).map(|_| std::array::from_fn(|_| rng.random_range(0..=coarse))).collect();
        let partition = Partition::new(m, |i, p| values[p][i]);
        let nodes: Vec<[f64; 3]> =
            partition.nodes.iter().map(|&w| w.map(|x| x as f64 / partition_sum(w))).collect();
        interior += usize::from(partition.nodes.iter().any(|w| w.iter().all(|&w| w > 0)));
        let mut areas = 0.0;
        let mut seen = [false; 9];
        for cell in &partition.cells {
            assert!(!std::mem::replace(&mut seen[cell.region], true), "one cell per region");
            let polygon: Vec<[f64; 3]> = cell.corners.iter().map(|&(n, _)| nodes[n]).collect();
            let area = super::cells::share(&polygon);
            assert!(area > 0.0 && polygon.len() >= 3);
            areas += area;
        }
        assert_within(areas, 1.0, 1e-13, 1.0);
        // Integer points, at which all comparisons are exact.
        let n = 30;
        for a in 0..=n {
            for b in 0..=n - a {
                let w = [a, b, n - a - b];
                let at =
                    |p: usize| (0..3).map(|i| w[i] as i128 * values[p][i] as i128).sum::<i128>();
                let largest = (0..m).map(at).max().unwrap();
                let x = w.map(|w| w as f64 / n as f64);
                let inside = partition.cells.iter().filter(|cell| {
                    (0..cell.corners.len()).all(|i| {
                        let [a, b] = [i, (i + 1) % cell.corners.len()].map(|i| cell.corners[i].0);
                        super::cells::share(&[nodes[a], nodes[b], x]) > 1e-12
                    })
                });
                for cell in inside {
                    assert_eq!(at(cell.region), largest, "{values:?}");
                }
            }
        }
    }
    assert!(interior > 500, "{interior}");
}

fn partition_sum(w: [i128; 3]) -> f64 {
    w.iter().sum::<i128>() as f64
}

/// A region that is the largest inside the face only: a small triangle around the centroid.
#[test]
fn a_region_may_be_largest_at_no_corner() {
    let values = [[9, 0, 0], [0, 9, 0], [0, 0, 9], [4, 4, 4]];
    let partition = Partition::new(4, |i, p| values[p][i]);
    let inner = &partition.cells[3];
    assert_eq!((inner.region, inner.corners.len()), (3, 3));
    let mut corners: Vec<[i128; 3]> =
        inner.corners.iter().map(|&(n, _)| partition.nodes[n].map(|w| 9 * w)).collect();
    for w in &mut corners {
        let sum = w.iter().sum::<i128>() / 9;
        *w = w.map(|w| w / sum);
    }
    corners.sort_unstable();
    assert_eq!(corners, [[1, 4, 4], [4, 1, 4], [4, 4, 1]]);
    assert_eq!(partition.nodes.len(), 3 + 3 + 3);
}

#[test]
fn cells_divide_any_mesh_without_gaps() {
    for (name, mesh) in zoo() {
        for (m, values) in
            [(2, None), (3, None), (6, None), (2, Some(1)), (3, Some(1)), (4, Some(2))]
        {
            for seed in 0..4 {
                check(&mesh, &random_field(mesh.vertices.len(), m, values, seed), name);
            }
        }
    }
}

/// Faces agree on their edges for rows of the simplex, constant U and 64 regions as well.
#[test]
fn cells_divide_a_surface_for_any_u() {
    let mesh = shape("torus:16x10");
    let vertices = mesh.vertices.len();
    check(&mesh, &Array2::from_elem((vertices, 5), 0.2), "constant");
    check(&mesh, &random_field(vertices, 64, None, 5), "64 regions");
    check(&mesh, &random_field(vertices, 64, Some(3), 6), "64 regions with ties");
    let rows = regions::array(&random_rows::<4>(vertices, &mut rng(7)), 4);
    check(&mesh, &rows, "rows");
    // Values that differ by the last bits only.
    let tiny = random_field(vertices, 3, None, 8).mapv(|u| 0.3 + 3e-16 * (10.0 * u).floor());
    check(&mesh, &tiny, "nearly constant");
}

#[test]
fn faces_without_a_cut_stay_as_they_are() {
    let mesh = bumpy(6);
    let cells =
        Cells::new(&mesh, one_hot(&vec![1; mesh.vertices.len()], 3).view(), None).cut_mesh();
    assert_eq!(cells.0.faces, mesh.faces);
    assert!(cells.1.iter().all(|&p| p == 1));
}

/// One-hot U: midpoints of edges, and the centroid of a face with three labels.
#[test]
fn one_hot_rows_are_cut_at_midpoints() {
    let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
    let mesh = Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 2], [1, 3, 2]]);
    let contours = Cells::new(&mesh, one_hot(&[0, 1, 2, 1], 3).view(), None).contours();
    let point = |i: u32| contours.points[i as usize];
    let third = 1.0 / 3.0;
    let near = |x: Point3<f64>, y: [f64; 3]| (x - Point3::from(y)).norm() < 1e-15;
    let ends: Vec<([usize; 2], usize)> =
        contours.polylines.iter().map(|line| (line.regions, line.points.len())).collect();
    assert_eq!(ends, [([0, 1], 2), ([0, 2], 2), ([1, 2], 3)]);
    assert!(contours.polylines.iter().all(|line| {
        let line = [line.points[0], line.points[line.points.len() - 1]];
        line.iter().any(|&i| near(point(i), [third, third, 0.0]))
    }));
    let exact = [[0.5, 0., 0.], [0., 0.5, 0.], [0.5, 0.5, 0.], [0.5, 1., 0.]];
    for midpoint in exact {
        assert!(contours.points.contains(&Point3::from(midpoint)), "{midpoint:?}");
    }
    assert_eq!(contours.points.len(), 5);
}

/// The cut of one-hot rows has the length of the labels where no face has three of them.
#[test]
fn the_cut_of_labels_in_two_regions_is_their_contour() {
    let mesh = bumpy(9);
    let mut rng = rng(31);
    let labels: Vec<usize> = mesh.vertices.iter().map(|_| rng.random_range(0..2)).collect();
    let contours = Cells::new(&mesh, one_hot(&labels, 2).view(), None).contours();
    let labels: Array1<i32> = labels.iter().map(|&p| p as i32).collect();
    let length = cut_length(&mesh, labels.view());
    assert_within(contours.length(), length, 1e-12, length);
}

/// The line x = c through a plane mesh, for linear U: its length, its ends, the areas on both sides.
#[test]
fn straight_lines_are_exact_for_linear_u() {
    let mesh = shape("grid:7x5");
    let (low, high) = (mesh.vertices[0], *mesh.vertices.last().unwrap());
    let size = high - low;
    // Through edges, and along edges and vertices.
    for at in [0.37, 2.0 / 7.0, 0.5, 3.0 / 7.0] {
        let u = two(&mesh, |x| 0.4 * ((x.x - low.x) / size.x - at));
        let cells = Cells::new(&mesh, u.view(), None);
        let contours = cells.contours();
        assert_eq!(contours.polylines.len(), 1, "{at}");
        let line = &contours.polylines[0];
        assert!(line.regions == [0, 1] && !line.is_closed());
        assert_within(line.length, size.y, 1e-12, size.y);
        assert_within(cells.areas()[1], at * size.x * size.y, 1e-10, size.x * size.y);
        for x in &contours.points {
            assert_within(x.x, low.x + at * size.x, 1e-11, size.x);
        }
        check(&mesh, &u, "line");
    }
}

/// Three sectors of a plane that meet at a known point, in a face and at a vertex.
#[test]
fn three_regions_meet_at_their_junction() {
    let mesh = shape("grid:8x8");
    let middle = nalgebra::center(&mesh.vertices[0], mesh.vertices.last().unwrap());
    let width = mesh.vertices.last().unwrap().x - mesh.vertices[0].x;
    for offset in [Vector3::new(0.013, 0.029, 0.0) * width, Vector3::zeros()] {
        let junction = middle + offset;
        let angle = |p: usize| (90.0 + 120.0 * p as f64).to_radians();
        let u = field(&mesh, 3, |x, p| {
            let d = x - junction;
            0.3 + 0.3 * (d.x * angle(p).cos() + d.y * angle(p).sin()) / width
        });
        let contours = Cells::new(&mesh, u.view(), None).contours();
        let pairs: Vec<[usize; 2]> = contours.polylines.iter().map(|line| line.regions).collect();
        assert_eq!(pairs, [[0, 1], [0, 2], [1, 2]]);
        for line in &contours.polylines {
            let ends = [line.points[0], line.points[line.points.len() - 1]];
            let near = |&&i: &&u32| (contours.points[i as usize] - junction).norm() < 1e-10;
            assert_eq!(ends.iter().filter(near).count(), 1);
            let [a, b] = ends.map(|i| contours.points[i as usize]);
            assert_within(line.length, (b - a).norm(), 1e-10, width);
        }
        check(&mesh, &u, "junction");
    }
}

/// The lengths of circles converge with order 2: on the sphere for a function of the height, on the plane for the distance.
#[test]
fn circles_converge_to_their_length() {
    let (mut steps, mut errors) = (Vec::new(), Vec::new());
    for level in 2..=6 {
        let mesh = shape(&format!("sphere:{level}"));
        let height = 0.3;
        let u = two(&mesh, |x| 0.4 * (x.z / x.coords.norm() - height));
        let contours = Cells::new(&mesh, u.view(), None).contours();
        assert!(contours.polylines.len() == 1 && contours.polylines[0].is_closed());
        let radius = mesh.vertices[0].coords.norm();
        let exact = std::f64::consts::TAU * radius * (1.0 - height * height).sqrt();
        steps.push(0.5_f64.powi(level));
        errors.push((contours.length() / exact - 1.0).abs());
    }
    let order = observed_order(&steps, &errors);
    assert!(order >= 1.8, "sphere {order}: {errors:?}");

    let (mut steps, mut errors) = (Vec::new(), Vec::new());
    for cells in [16, 32, 64, 128] {
        let mesh = shape(&format!("grid:{cells}x{cells}"));
        let (low, high) = (mesh.vertices[0], *mesh.vertices.last().unwrap());
        let (middle, width) = (nalgebra::center(&low, &high), high.x - low.x);
        let (radius, h) = (0.31 * width, width / f64::from(cells));
        let u = two(&mesh, |x| ((radius - (x - middle).norm()) / (4.0 * h)).clamp(-0.5, 0.5));
        let cells = Cells::new(&mesh, u.view(), None);
        let contours = cells.contours();
        assert!(contours.polylines.len() == 1 && contours.polylines[0].is_closed());
        steps.push(h);
        let length = std::f64::consts::TAU * radius;
        errors.push((contours.length() / length - 1.0).abs());
        assert_within(cells.areas()[0], 0.5 * radius * length, h * h / (width * width), 1.0);
    }
    let order = observed_order(&steps, &errors);
    assert!(order >= 1.8, "plane {order}: {errors:?}");
}

/// The cut of labels of a circle zigzags: on a regular grid it is too long by the same share, however fine the grid.
#[test]
fn cuts_of_labels_do_not_converge() {
    let excess = [64, 256].map(|cells| {
        let mesh = shape(&format!("grid:{cells}x{cells}"));
        let (low, high) = (mesh.vertices[0], *mesh.vertices.last().unwrap());
        let (middle, radius) = (nalgebra::center(&low, &high), 0.31 * (high.x - low.x));
        let inside = |x: &Point3<f64>| i32::from((x - middle).norm() > radius);
        let labels: Array1<i32> = mesh.vertices.iter().map(inside).collect();
        cut_length(&mesh, labels.view()) / (std::f64::consts::TAU * radius) - 1.0
    });
    assert!(excess.iter().all(|excess| (0.1..0.25).contains(excess)), "{excess:?}");
    assert_within(excess[0], excess[1], 0.1, excess[1]);
}

/// On a closed surface, the boundary of two regions has no ends.
#[test]
fn contours_of_two_regions_on_a_closed_surface_are_loops() {
    for name in ["torus:20x13", "sphere:3"] {
        let mesh = shape(name);
        for seed in 0..10 {
            let random = random_field(mesh.vertices.len(), 2, None, seed);
            let contours = Cells::new(&mesh, random.view(), None).contours();
            assert!(!contours.polylines.is_empty());
            assert!(contours.polylines.iter().all(Polyline::is_closed), "{name} {seed}");
        }
    }
}

/// Points of the contour as sorted bits, and its length.
fn fingerprint(mesh: &Mesh, u: &Array2<f64>) -> (Vec<[u64; 3]>, f64) {
    let contours = Cells::new(mesh, u.view(), None).contours();
    let bits = |x: &Point3<f64>| [x.x, x.y, x.z].map(f64::to_bits);
    let mut points: Vec<[u64; 3]> = contours.points.iter().map(bits).collect();
    points.sort_unstable();
    (points, contours.length())
}

/// The order of vertices and faces, the first corner of a face and the order of regions do not matter.
#[test]
fn the_contour_does_not_depend_on_any_order() {
    let mesh = bumpy(8);
    let mut rng = rng(41);
    let u = regions::array(&random_rows::<4>(mesh.vertices.len(), &mut rng), 4);
    let (points, length) = fingerprint(&mesh, &u);
    // Coordinates of points within faces depend on the order of their corners, up to rounding.
    let same = |(other, other_length): (Vec<[u64; 3]>, f64)| {
        assert_eq!(points.len(), other.len());
        assert_within(length, other_length, 1e-13, length);
    };
    let (renumbered, previous) = shuffled(&mesh, &mut rng);
    let rows = Array2::from_shape_fn(u.dim(), |(v, p)| u[[previous[v] as usize, p]]);
    same(fingerprint(&renumbered, &rows));
    let mut order = [0, 1, 2, 3];
    order.shuffle(&mut rng);
    same(fingerprint(&mesh, &Array2::from_shape_fn(u.dim(), |(v, p)| u[[v, order[p]]])));
    let areas = Cells::new(&mesh, u.view(), None).areas();
    let permuted = Array2::from_shape_fn(u.dim(), |(v, p)| u[[v, order[p]]]);
    let permuted = Cells::new(&mesh, permuted.view(), None).areas();
    for (p, area) in permuted.into_iter().enumerate() {
        assert_within(area, areas[order[p]], 1e-13, mesh.area());
    }
    let mut turned = mesh.clone();
    turned.faces.iter_mut().for_each(|face| face.rotate_left(1));
    same(fingerprint(&turned, &u));
}

/// The crossings of two regions on edges have the same bits in every order.
#[test]
fn crossings_do_not_depend_on_the_order_of_the_vertices() {
    let mesh = bumpy(8);
    let mut rng = rng(43);
    let u = random_field(mesh.vertices.len(), 2, None, 43);
    let (renumbered, previous) = shuffled(&mesh, &mut rng);
    let rows = Array2::from_shape_fn(u.dim(), |(v, p)| u[[previous[v] as usize, p]]);
    assert_eq!(fingerprint(&mesh, &u).0, fingerprint(&renumbered, &rows).0);
}

/// Positions have no influence on what is cut, and motions move the cut.
#[test]
fn the_contour_moves_with_the_mesh() {
    let mesh = bumpy(8);
    let mut rng = rng(47);
    let u = random_field(mesh.vertices.len(), 3, None, 47);
    let rotation = random_rotation(&mut rng);
    let mut moved = mesh.clone().scaled(3.0);
    moved.vertices.iter_mut().for_each(|x| *x = rotation * *x + Vector3::new(1.0, 2.0, 3.0));
    let (a, b) = (fingerprint(&mesh, &u), fingerprint(&moved, &u));
    assert_eq!(a.0.len(), b.0.len());
    assert_within(b.1, 3.0 * a.1, 1e-12, b.1);
}

#[test]
fn the_same_bits_with_any_number_of_threads() {
    let mesh = shape("torus:130x70");
    let u = random_field(mesh.vertices.len(), 4, None, 51);
    let at = |threads| {
        let cells = || {
            let cells = Cells::new(&mesh, u.view(), None);
            (cells.contours(), cells.cut_mesh(), cells.areas())
        };
        with_threads(Some(threads), cells).unwrap()
    };
    let one = at(1);
    assert!([2, 3].into_iter().all(|threads| at(threads) == one));
}

/// Ties: a ridge is no cut, a valley with different cells on both sides is cut once, and a flat face belongs to the first
/// region.
#[test]
fn ties_along_edges_are_cut_once() {
    let points = [[0., 0., 0.], [1., 0., 0.], [0.5, 1., 0.], [0.5, -1., 0.]];
    let mesh = Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 2], [1, 0, 3]]);
    let contours = |ends: [f64; 2]| {
        let first = [0.5, 0.5, ends[0], ends[1]];
        let u =
            Array2::from_shape_fn((4, 2), |(v, p)| if p == 0 { first[v] } else { 1.0 - first[v] });
        check(&mesh, &u, "ties");
        let contours = Cells::new(&mesh, u.view(), None).contours();
        (contours.polylines.len(), contours.length())
    };
    assert_eq!(contours([0.9, 0.1]), (1, 1.0));
    assert_eq!(contours([0.1, 0.9]), (1, 1.0));
    assert_eq!(contours([0.9, 0.8]), (0, 0.0));
    assert_eq!(contours([0.1, 0.2]), (0, 0.0));
    assert_eq!(contours([0.5, 0.5]), (0, 0.0));
    assert_eq!(contours([0.5, 0.1]), (1, 1.0));
    assert_eq!(contours([0.5, 0.9]), (0, 0.0));
}

/// The share that differs is 0 for the labels of one-hot U, 1 for other labels, and exact where a cut moves.
#[test]
fn labels_differ_from_cells_by_area() {
    let mesh = bumpy(7);
    let mut rng = rng(61);
    let labels: Vec<usize> = mesh.vertices.iter().map(|_| rng.random_range(0..4)).collect();
    let as_array =
        |shift: usize| labels.iter().map(|&p| ((p + shift) % 4) as i32).collect::<Array1<i32>>();
    let u = one_hot(&labels, 4);
    let cells = Cells::new(&mesh, u.view(), None);
    assert!(cells.share_that_differs(as_array(0).view()) < 1e-14);
    let differs = cells.share_that_differs(Array1::from_elem(labels.len(), 2).view());
    assert_within(differs, 1.0 - cells.areas()[2] / mesh.area(), 1e-13, 1.0);
    // A line that labels can only approximate by steps: the strip between it and the middle of a cell.
    let mesh = shape("grid:8x3");
    let (low, high) = (mesh.vertices[0], *mesh.vertices.last().unwrap());
    let width = high.x - low.x;
    let at = |x: &Point3<f64>| (x.x - low.x) / width * 8.0;
    let u = two(&mesh, |x| 0.05 * (at(x) - 3.2));
    let labels: Array1<i32> = mesh.vertices.iter().map(|x| i32::from(at(x) < 3.2)).collect();
    let differs = Cells::new(&mesh, u.view(), None).share_that_differs(labels.view());
    assert_within(differs, 0.3 / 8.0, 1e-10, 1.0);
}

/// E(t) <= E(U) for the threshold, whatever U and the mass; E(t) by the labels and the contour.
#[test]
fn the_energy_of_two_cells_is_at_most_that_of_u() {
    for (case, mass) in
        (0..24).zip([Mass::Barycentric, Mass::Voronoi, Mass::Consistent].into_iter().cycle())
    {
        let mesh = if case % 4 == 3 { soup(40, 90, case) } else { bumpy(5 + case as u32 % 5) };
        let (mesh, _) = mesh.without_degenerate_faces();
        let vertices = mesh.vertices.len();
        let mut rng = rng(700 + case);
        let s = regions::array(&random_rows::<2>(vertices, &mut rng), 2);
        let lambda = [0.0, 0.01, 0.1, 1.0][case as usize / 3 % 4];
        let request = Request {
            lambda,
            relaxation: Default::default(),
            mass,
            method: Default::default(),
            stop: Stop::default(),
            coarse_to_fine: false,
            keep_dual: false,
            rounding: Default::default(),
            label_gap: None,
        };
        let problem = problem_of::<2>(&mesh, 2, regions::rows(s.view()), &request).unwrap();
        // Values that are skewed, so that 1/2 is no good threshold, and ties.
        let power = [1.0, 5.0, 0.1][case as usize % 3];
        let mut first: Vec<f64> = (0..vertices).map(|_| rng.random::<f64>().powf(power)).collect();
        if case % 2 == 0 {
            first.iter_mut().for_each(|u| *u = (8.0 * *u).round() / 8.0);
        }
        let rows: Vec<Row<2>> = first.iter().map(|&u| Row([u, 1.0 - u])).collect();
        let energy = problem.energy(&rows);
        let t = threshold(&mesh, |k| problem.f[k].0, lambda, |k| first[k], energy);
        let data: f64 = (0..vertices).map(|k| problem.f[k].0[usize::from(first[k] < t)]).sum();
        let u = regions::array(&rows, 2);
        let cells = Cells::new(&mesh, u.view(), Some(t));
        let cut = 2.0_f64.sqrt() * lambda * cells.contours().length();
        assert!(
            data + cut <= energy + 1e-12 * energy.abs().max(1e-3),
            "{case}: {data} + {cut} > {energy}"
        );
    }
}

/// The mean of E(t) is E(U), so that thresholds whose energy is smaller are found even if they are few.
#[test]
fn bisection_finds_a_small_set_of_thresholds() {
    // E(t) is 10 for t <= 0.9 and 0 above; E(U) is 9.
    let mesh = shape("grid:4x4");
    let u = |k: usize| if k == 12 { 0.9 } else { 1.0 };
    let f = |k: usize| if k == 12 { [10.0, 0.0] } else { [0.0, 10.0] };
    let t = threshold(&mesh, f, 0.0, u, 9.0);
    assert!(t > 0.9 && t < 1.0, "{t}");
    assert_eq!(threshold(&mesh, f, 0.0, u, 10.0), 0.5);
}
