//! Topology, orientation and area stay; valences and lengths improve; regular meshes stay as they are.

use super::*;
use crate::evolve::smoothing::tangential;
use crate::mesh::{Mesh, Statistics};
use crate::samples::{rng, shape, zoo};
use nalgebra::Point3;
use ndarray::Array2;
use rand::RngExt;

const ANGLE: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// Splits, collapses and flips.
fn all(mesh: &Mesh) -> [(&'static str, Remeshed); 4] {
    [
        ("split", split_long(mesh, 1.3)),
        ("flip", flip(mesh, ANGLE)),
        ("collapse", collapse_short(mesh, 0.8)),
        ("collapse more", collapse_short(mesh, 1.2)),
    ]
}

/// A closed surface with faces of different sizes and valences.
fn irregular(text: &str, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let mut mesh = shape(text);
    for _ in 0..2 {
        let marked: Vec<bool> = mesh.vertices.iter().map(|_| rng.random_bool(0.3)).collect();
        let divides = |a: u32, b: u32| marked[a as usize] && marked[b as usize];
        mesh = mesh.divided(divides, |_| [1.0; 3]).mesh;
    }
    mesh
}

fn squared_deviation(mesh: &Mesh) -> i64 {
    let mut valences = vec![0_i64; mesh.vertices.len()];
    mesh.faces.as_flattened().iter().for_each(|&k| valences[k as usize] += 1);
    valences.iter().filter(|&&n| n > 0).map(|n| (n - 6).pow(2)).sum()
}

#[test]
fn topology_and_orientation_stay() {
    for (text, seed) in [("sphere:2", 1), ("torus:24x16", 2), ("grid:9x9", 3)] {
        let mesh = irregular(text, seed);
        let before = Statistics::of(&mesh);
        for (name, Remeshed { mesh: found, .. }) in all(&mesh) {
            let after = Statistics::of(&found);
            let context = format!("{text} {name} {} {}", before.faces, after.faces);
            assert_eq!(after.euler_characteristic, before.euler_characteristic, "{context}");
            assert_eq!(after.boundary_loops, before.boundary_loops, "{context}");
            assert_eq!(after.components, before.components, "{context}");
            assert_eq!(
                [
                    after.inconsistent_edges,
                    after.non_manifold_edges,
                    after.duplicate_faces,
                    after.degenerate_faces,
                    after.unreferenced_vertices,
                ],
                [0; 5],
                "{context}"
            );
            // The surfaces enclose volumes of the same sign and of nearly the same size.
            if before.boundary_edges == 0 {
                let ratio = volume(&found) / volume(&mesh);
                assert!((ratio - 1.0).abs() < 0.1, "{context}: {ratio}");
                assert_eq!(after.boundary_edges, 0, "{context}");
            }
        }
    }
}

fn volume(mesh: &Mesh) -> f64 {
    let part = |j: usize| {
        let [a, b, c] = mesh.corners(j).map(|x| x.coords);
        a.dot(&b.cross(&c)) / 6.0
    };
    (0..mesh.faces.len()).map(part).sum()
}

#[test]
fn a_plane_stays_the_same_plane() {
    let mut mesh = irregular("grid:12x8", 4);
    let mut rng = rng(8);
    for x in &mut mesh.vertices {
        if [x.x, 1.5 * x.y].iter().all(|c| (0.001..0.999).contains(c)) {
            x.x += rng.random_range(-0.005..0.005);
            x.y += rng.random_range(-0.005..0.005);
        }
    }
    for (name, found) in all(&mesh) {
        assert!((found.mesh.area() - mesh.area()).abs() <= 1e-14, "{name}");
        let up = |j: usize| found.mesh.area_vector(j).z > 0.0;
        assert!((0..found.mesh.faces.len()).all(up), "{name}");
    }
}

#[test]
fn regular_meshes_do_not_change() {
    for text in ["torus:24x16", "grid:8x8", "sphere:0"] {
        let mesh = shape(text);
        for (name, found) in &all(&mesh)[1..2] {
            assert!(found.mesh == mesh, "{text} {name}");
        }
        assert!(split_long(&mesh, 2.5).mesh == mesh, "{text}");
        assert!(collapse_short(&mesh, 0.3).mesh == mesh, "{text}");
    }
}

#[test]
fn flips_improve_the_valences_and_end() {
    for (text, seed) in [("sphere:3", 5), ("torus:24x16", 6)] {
        let mesh = irregular(text, seed);
        let found = flip(&mesh, ANGLE).mesh;
        let (before, after) = (squared_deviation(&mesh), squared_deviation(&found));
        assert!(after * 3 < before * 2, "{text}: {before} {after}");
        assert!(flip(&found, ANGLE).mesh == found, "{text}");
    }
}

#[test]
fn splits_leave_no_long_edge_between_two_old_vertices() {
    let mesh = irregular("torus:24x16", 7);
    let limit = 1.3 * median_edge_length(&mesh).unwrap();
    let Remeshed { mesh: found, parents } = split_long(&mesh, 1.3);
    assert!(found.vertices.len() > mesh.vertices.len());
    assert!((found.area() - mesh.area()).abs() <= 1e-13);
    let old = |k: u32| parents[k as usize].2 == 0.0;
    for &[a, b, c] in &found.faces {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            let length = (found.vertices[a as usize] - found.vertices[b as usize]).norm();
            assert!(length <= limit || !(old(a) && old(b)));
        }
    }
    assert!(split_long(&mesh, 0.0).mesh == mesh.subdivided());
}

/// In turns with flips and smoothing, which remove what stands in the way of collapses.
#[test]
fn collapses_remove_short_edges() {
    let mut mesh = shape("torus:24x16");
    for factor in [1.0, 1.1, 1.2] {
        mesh = split_long(&mesh, factor).mesh;
    }
    let limit = 0.7 * median_edge_length(&mesh).unwrap();
    let short = |mesh: &Mesh| {
        let length =
            |a: u32, b: u32| (mesh.vertices[a as usize] - mesh.vertices[b as usize]).norm();
        let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        sides.filter(|&(a, b)| length(a, b) < limit).count()
    };
    let before = short(&mesh);
    for _ in 0..20 {
        mesh = flip(&collapse_below(&mesh, limit).mesh, ANGLE).mesh;
        mesh.vertices = tangential(&mesh, 0.3).into_iter().map(Point3::from).collect();
    }
    assert!(before > 3000 && short(&mesh) <= 10, "{before} {}", short(&mesh));
    assert_eq!(Statistics::of(&mesh).euler_characteristic, 0);
}

/// Positions are interpolated like any other values.
#[test]
fn parents_interpolate_positions() {
    for (name, mesh) in zoo() {
        let positions =
            Array2::from_shape_fn((mesh.vertices.len(), 3), |(k, i)| mesh.vertices[k][i]);
        for (kind, found) in all(&mesh) {
            let expected = found.interpolated(positions.view());
            let size = mesh.vertices.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
            for (x, row) in found.mesh.vertices.iter().zip(expected.outer_iter()) {
                let expected = Point3::new(row[0], row[1], row[2]);
                assert!((x - expected).norm() <= 1e-15 * size, "{name} {kind}");
            }
        }
    }
}

/// The collapse of an edge of a tetrahedron would leave two faces on the same corners.
#[test]
fn the_smallest_surfaces_do_not_collapse() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let tetrahedron = Mesh::new(corners.map(Point3::from).to_vec(), faces);
    for (name, found) in &all(&tetrahedron)[1..] {
        assert_eq!(found.mesh, tetrahedron, "{name}");
    }
}
