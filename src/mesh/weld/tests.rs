//! Welding restores meshes that were taken apart, and near vertices are those of all pairs.

use nalgebra::Point3;
use rand::RngExt;

use super::*;
use crate::mesh::Statistics;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::samples::{bumpy, disjoint, random_vector, rng, shape, shuffled, zoo};
use crate::sweep::with_threads;

/// The mesh with separate vertices for every face, and the original vertex of each.
fn taken_apart(mesh: &Mesh) -> (Mesh, Vec<u32>) {
    let before = mesh.faces.as_flattened().to_vec();
    let vertices = before.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let faces = (0..mesh.faces.len() as u32).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
    (Mesh::new(vertices, faces), before)
}

#[test]
fn welding_restores_what_was_taken_apart() {
    for (name, mesh) in zoo() {
        let (apart, before) = taken_apart(&mesh);
        let weld = Weld::exact(&apart).unwrap();
        let whole = Statistics::of(&mesh);
        let again = Statistics::of(&weld.mesh);
        assert_eq!(again.vertices, whole.vertices - whole.unreferenced_vertices, "{name}");
        assert_eq!(again.euler_characteristic, whole.euler_characteristic, "{name}");
        assert_eq!(
            (again.components, again.boundary_edges, again.inconsistent_edges),
            (whole.components, whole.boundary_edges, whole.inconsistent_edges),
            "{name}"
        );
        assert_eq!(weld.merged, apart.vertices.len() - again.vertices, "{name}");
        for (v, &k) in before.iter().enumerate() {
            let now = weld.mesh.vertices[weld.of[v] as usize];
            assert_eq!(now, mesh.vertices[k as usize], "{name}");
        }
        assert!(weld.mesh.faces.iter().zip(&mesh.faces).all(|(now, face)| {
            now.map(|v| weld.mesh.vertices[v as usize]) == face.map(|v| mesh.vertices[v as usize])
        }));
        assert!(Weld::exact(&weld.mesh).is_none(), "{name}");
    }
}

#[test]
fn the_first_of_each_class_is_kept_and_both_zeros_are_equal() {
    let points = [[0.0, 1.0, 0.0], [5.0; 3], [-0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [5.0; 3], [5.0; 3]];
    let mut mesh = Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 3], [2, 3, 4]]);
    let weld = Weld::exact(&mesh).unwrap();
    // The last vertex is in no face.
    assert_eq!(weld.of, [0, 1, 0, 2, 1, 3]);
    assert_eq!((weld.merged, weld.onto, coincident(&mesh)), (2, 2, 2));
    assert_eq!(weld.mesh.faces, [[0, 1, 2], [0, 2, 1]]);
    assert_eq!(weld.spread(&[7, 8, 9, 10]), [7, 8, 7, 9, 8, 10]);
    mesh.vertices.iter_mut().for_each(|x| x.x += 1.0);
    assert_eq!(Weld::exact(&mesh).unwrap().of, weld.of);
}

/// Compared with all pairs of points, also at extreme scales, with clusters and lattices.
#[test]
fn the_grid_finds_all_pairs() {
    let mut rng = rng(211);
    for (case, scale) in [1.0, 1e-30, 1e30, 1.0, 1.0, 1e4].into_iter().enumerate() {
        for tolerance in [1e-300, 1e-9, 1e-3, 0.03, 0.2, 1.0, 10.0] {
            let points: Vec<Point3<f64>> = (0..300)
                .map(|k| {
                    let x = random_vector(&mut rng);
                    let place = match case {
                        3 => x.map(|x| (8.0 * x).round() / 8.0),
                        4 => x * 0.01 + nalgebra::Vector3::repeat(f64::from(k % 5) * 0.2),
                        5 => x * 1e-9 + nalgebra::Vector3::repeat(1.0),
                        _ => x,
                    };
                    Point3::from(place * scale)
                })
                .collect();
            let tolerance = tolerance * scale;
            let faces = (0..100).map(|j| [3 * j, 3 * j + 1, 3 * j + 2]).collect();
            let mesh = Mesh::new(points.clone(), faces);
            let mut joined = DisjointSets::new(points.len());
            for (a, x) in (0..).zip(&points) {
                for (b, y) in (0..a).zip(&points) {
                    if (x - y).norm() <= tolerance {
                        joined.join(a, b);
                    }
                }
            }
            let expected: Vec<u32> = (0..points.len() as u32).map(|v| joined.root(v)).collect();
            assert_eq!(near(&mesh, firsts(&mesh), tolerance), expected, "{case} {tolerance:e}");
        }
    }
}

/// A tolerance that spans many vertices does not take quadratic time.
#[test]
fn large_tolerances_are_fast() {
    let two = disjoint([shape("torus:400x250"), {
        let mut other = shape("torus:400x250");
        other.vertices.iter_mut().for_each(|x| x.x += 2.0);
        other
    }]);
    for tolerance in [1e-3, 0.1, 1.0, 100.0] {
        let weld = Weld::within(&two, tolerance);
        if tolerance >= 0.1 {
            let surfaces = if tolerance < 10.0 { 2 } else { 1 };
            assert_eq!(weld.unwrap().mesh.vertices.len(), surfaces);
        }
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (apart, _) = taken_apart(&shuffled(&bumpy(60), &mut rng(3)).0);
    let one = with_threads(Some(1), || Weld::exact(&apart)).unwrap();
    for threads in [2, 3, 7] {
        assert_eq!(with_threads(Some(threads), || Weld::exact(&apart)).unwrap(), one);
    }
    assert_eq!(Weld::within(&apart, 1e-12), one);
}

#[test]
fn means_keep_integrals_and_ignore_unknown_values() {
    let (mut apart, before) = taken_apart(&bumpy(12));
    let mut rng = rng(9);
    let colors: Vec<[f64; 3]> =
        (0..before.len()).map(|_| [0; 3].map(|_| rng.random_range(0.0..1.0))).collect();
    apart.colors = Some(colors.clone());
    let weld = Weld::exact(&apart).unwrap();
    let means = weld.mesh.colors.clone().unwrap();
    let integral = |mesh: &Mesh, colors: &[[f64; 3]], i: usize| {
        let terms = barycentric_areas(mesh).into_iter().zip(colors);
        terms.map(|(a, color)| a * color[i]).sum::<f64>()
    };
    for i in 0..3 {
        let (whole, sum) = (integral(&apart, &colors, i), integral(&weld.mesh, &means, i));
        assert!((whole - sum).abs() < 1e-14 * whole.abs());
    }
    // Equal values at all copies give the same bits.
    let of_place: Vec<f64> = before.iter().map(|&k| 0.1 + f64::from(k) / 3.0).collect();
    let same = weld.spread(&weld.means(&of_place, 1));
    assert_eq!(same, of_place);
    // One known copy is enough.
    let seldom: Vec<f64> = (0..before.len())
        .map(|v| if weld.of[..v].contains(&weld.of[v]) { f64::NAN } else { 4.5 })
        .collect();
    assert!(weld.means(&seldom, 1).iter().all(|&x| x == 4.5));
    assert!(weld.means(&vec![f64::NAN; before.len()], 1).iter().all(|x| x.is_nan()));
    // A label that is forbidden at one copy is forbidden.
    let mut costs = vec![1.0; before.len()];
    costs[5] = f64::INFINITY;
    assert_eq!(weld.means(&costs, 1)[weld.of[5] as usize], f64::INFINITY);
    let unweighted = weld.means_by(&costs, 1, &vec![0.0; before.len()]);
    assert_eq!(unweighted[weld.of[5] as usize], f64::INFINITY);
    assert!(unweighted.iter().all(|x| !x.is_nan()));
}

#[test]
fn overlapping_sheets_become_non_manifold() {
    let grid = shape("grid:4x3");
    let mut back = grid.clone();
    back.faces.iter_mut().for_each(|face| face.swap(1, 2));
    let weld = Weld::exact(&disjoint([grid.clone(), back])).unwrap();
    let inner = Statistics::of(&grid).edges - Statistics::of(&grid).boundary_edges;
    assert_eq!(weld.new_non_manifold_edges, inner);
    // Touching at a vertex makes none, and earlier ones are not counted.
    let mut beside = grid.clone();
    beside.vertices.iter_mut().for_each(|x| *x += nalgebra::Vector3::new(1.0, 0.75, 0.0));
    let weld = Weld::exact(&disjoint([grid, beside])).unwrap();
    assert_eq!((weld.merged, weld.new_non_manifold_edges), (1, 0));
    let (mut seam, _) = taken_apart(&shape("sphere:1"));
    assert_eq!(Weld::exact(&seam).unwrap().new_non_manifold_edges, 0);
    let points =
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0; 3]];
    seam = Mesh::new(
        points.map(Point3::from).to_vec(),
        vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [5, 2, 3]],
    );
    assert_eq!(Weld::exact(&seam).unwrap().new_non_manifold_edges, 0);
}

#[test]
fn soups_are_shattered_and_mended_at_the_smallest_tolerance() {
    let sphere = shape("sphere:3");
    let (mut soup, _) = taken_apart(&sphere);
    assert!(!is_shattered(&sphere) && is_shattered(&soup));
    assert_eq!(mending_tolerance(&soup), Some(0.0));
    let mut rng = rng(2);
    soup.vertices.iter_mut().for_each(|x| *x += 1e-7 * random_vector(&mut rng));
    let tolerance = mending_tolerance(&soup).unwrap();
    assert!((1e-7..1e-5).contains(&tolerance), "{tolerance}");
    assert_eq!(Weld::within(&soup, tolerance).unwrap().mesh.vertices.len(), sphere.vertices.len());
    // Two distant triangles are not a soup.
    assert!(!is_shattered(&disjoint([shape("grid:1x1"), shape("grid:1x1")])));
    let mut far = taken_apart(&sphere).0;
    for (j, x) in far.vertices.iter_mut().enumerate() {
        x.x += 10.0 * (j / 3) as f64;
    }
    assert!(is_shattered(&far) && mending_tolerance(&far).is_none());
}
