//! The total variation is invariant under rigid motions and renumbering, and scales with the length.

use rand::RngExt;

use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Operator, Stencil};
use crate::samples::{assert_within, random_rotation, random_rows, random_vector, rng, zoo};

fn norms(mesh: &Mesh, u: &[Row<3>]) -> Vec<f64> {
    let k = Stencil::new(mesh);
    (0..k.faces()).map(|j| k.at(u, j).norm()).collect()
}

/// Compares norms one by one, relative to the largest possible value for the longest edge.
#[track_caller]
fn assert_same(mesh: &Mesh, a: &[f64], b: &[f64], tolerance: f64) {
    for (j, (a, b)) in a.iter().zip(b).enumerate() {
        let x = mesh.corners(j);
        let size = (x[1] - x[0]).norm() + (x[2] - x[0]).norm();
        assert_within(*a, *b, tolerance, size);
    }
}

#[test]
fn rigid_motions_change_nothing() {
    let mut rng = rng(11);
    for (name, mesh) in zoo() {
        let u = random_rows(mesh.vertices.len(), &mut rng);
        let turn = random_rotation(&mut rng);
        let shift = random_vector(&mut rng) * mesh.area().sqrt();
        let mut moved = mesh.clone();
        moved.vertices.iter_mut().for_each(|x| *x = turn * *x + shift);
        // Moved coordinates are rounded relative to their size, and the aspect ratio of a needle amplifies the error.
        let tolerance = if name == "needles" { 1e-7 } else { 1e-11 };
        assert_same(&mesh, &norms(&mesh, &u), &norms(&moved, &u), tolerance);
        let mut mirrored = mesh.clone();
        mirrored.vertices.iter_mut().for_each(|x| x.z = -x.z);
        assert_same(&mesh, &norms(&mesh, &u), &norms(&mirrored, &u), 1e-13);
    }
}

#[test]
fn numbering_changes_nothing() {
    let mut rng = rng(12);
    for (_, mesh) in zoo() {
        let n = mesh.vertices.len();
        let u = random_rows::<3>(n, &mut rng);
        let mut index: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            index.swap(i, rng.random_range(0..=i));
        }
        let (mut renumbered, mut moved) = (mesh.clone(), u.clone());
        for k in 0..n {
            renumbered.vertices[index[k]] = mesh.vertices[k];
            moved[index[k]] = u[k];
        }
        renumbered.faces.iter_mut().flatten().for_each(|k| *k = index[*k as usize] as u32);
        assert_eq!(norms(&mesh, &u), norms(&renumbered, &moved));
        let mut backwards = mesh.clone();
        backwards.faces.reverse();
        let mut reversed = norms(&backwards, &u);
        reversed.reverse();
        assert_eq!(norms(&mesh, &u), reversed);
    }
}

#[test]
fn the_choice_of_the_first_corner_changes_nothing() {
    let mut rng = rng(13);
    for (name, mesh) in zoo() {
        let u = random_rows(mesh.vertices.len(), &mut rng);
        let tolerance = if name == "needles" { 1e-8 } else { 1e-12 };
        let mut turned = mesh.clone();
        for _ in 0..2 {
            turned.faces.iter_mut().for_each(|face| face.rotate_left(1));
            assert_same(&mesh, &norms(&mesh, &u), &norms(&turned, &u), tolerance);
        }
        turned.faces.iter_mut().for_each(|face| face.swap(0, 2));
        assert_same(&mesh, &norms(&mesh, &u), &norms(&turned, &u), tolerance);
    }
}

#[test]
fn the_variation_scales_with_the_length() {
    let mut rng = rng(14);
    for (_, mesh) in zoo() {
        let u = random_rows(mesh.vertices.len(), &mut rng);
        for c in [1e-4, 0.3, 1e4] {
            let scaled = norms(&mesh.clone().scaled(c), &u);
            let expected: Vec<f64> = norms(&mesh, &u).iter().map(|x| c * x).collect();
            assert_same(&mesh.clone().scaled(c), &scaled, &expected, 1e-12);
        }
    }
}
