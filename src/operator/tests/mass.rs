//! The mass matrices are quadratures on the surface; the Laplacian is the cotangent Laplacian.

use nalgebra::{DMatrix, Point3};
use sprs::CsMat;
use strum::IntoEnumIterator;

use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::{barycentric_areas, cotangents, mixed_voronoi_areas};
use crate::operator::mass::consistent_inverse;
use crate::operator::mass::consistent_matrix;
use crate::operator::{Mass, Matrix};
use crate::samples::{assert_within, random_rows, random_vector, rng, with_isolated_vertices, zoo};

fn times(matrix: &CsMat<f64>, x: &[f64]) -> Vec<f64> {
    matrix.outer_iterator().map(|row| row.iter().map(|(k, &value)| value * x[k]).sum()).collect()
}

#[test]
fn weights_are_row_sums_and_add_up_to_the_area() {
    for (name, mesh) in zoo() {
        let n = mesh.vertices.len();
        let row_sums = times(&consistent_matrix(&mesh), &vec![1.0; n]);
        for (sum, a) in row_sums.iter().zip(barycentric_areas(&mesh)) {
            assert_within(*sum, a, 1e-13, a);
        }
        for mass in Mass::iter() {
            let weights = mass.weights(&mesh);
            assert!(weights.iter().all(|&a| a >= 0.0), "{name}");
            assert_within(weights.iter().sum(), mesh.area(), 1e-9, mesh.area());
            let integral = mass.on(&mesh).integrate(&vec![Row([1.0, -2.0]); n]);
            for (f, a) in integral.iter().zip(&weights) {
                assert_within(f.0[0], *a, 1e-13, *a);
                assert_within(f.0[1], -2.0 * a, 1e-13, *a);
            }
        }
    }
}

/// The mixed cells of an obtuse face, by their definition; plain Voronoi areas would be negative here.
#[test]
fn voronoi_cells_of_obtuse_faces() {
    let corners = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(Point3::from);
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]);
    assert_eq!(mixed_voronoi_areas(&mesh), vec![1.25, 1.25, 2.5]);
}

/// int u w over a triangle for linear u, w, by the edge midpoint rule, which is exact.
#[test]
fn the_consistent_mass_integrates_products_of_linear_functions() {
    let mut rng = rng(31);
    for (_, mesh) in zoo() {
        let u = random_rows::<2>(mesh.vertices.len(), &mut rng);
        let product = |j: usize| -> f64 {
            let corners = mesh.faces[j].map(|k| u[k as usize]);
            let middle = |a: usize, b: usize| {
                let row = (corners[a] + corners[b]) * 0.5;
                row.0[0] * row.0[1]
            };
            mesh.face_area(j) / 3.0 * (middle(0, 1) + middle(1, 2) + middle(2, 0))
        };
        let exact: f64 = (0..mesh.faces.len()).map(product).sum();
        let [x, y] = [0, 1].map(|p| u.iter().map(|row| row.0[p]).collect::<Vec<f64>>());
        let by_matrix = times(&consistent_matrix(&mesh), &y);
        let quadrature: f64 = x.iter().zip(by_matrix).map(|(x, my)| x * my).sum();
        assert_within(quadrature, exact, 1e-12, mesh.area());
        let integrated = Mass::Consistent.on(&mesh).integrate(&u);
        let quadrature: f64 = x.iter().zip(&integrated).map(|(x, f)| x * f.0[1]).sum();
        assert_within(quadrature, exact, 1e-12, mesh.area());
    }
}

#[test]
fn consistent_integration_is_the_matrix_product() {
    let mut rng = rng(32);
    for (_, mesh) in zoo() {
        let s = random_rows::<3>(mesh.vertices.len(), &mut rng);
        let f = Mass::Consistent.on(&mesh).integrate(&s);
        let area = barycentric_areas(&mesh);
        for p in 0..3 {
            let column: Vec<f64> = s.iter().map(|row| row.0[p]).collect();
            let product = times(&consistent_matrix(&mesh), &column);
            for (v, value) in product.iter().enumerate() {
                assert_within(f[v].0[p], *value, 1e-13, area[v]);
            }
        }
    }
}

#[test]
fn the_consistent_mass_is_inverted() {
    let mut rng = rng(33);
    for (name, mesh) in zoo() {
        let s = random_rows::<3>(mesh.vertices.len(), &mut rng);
        let mut solved = Mass::Consistent.on(&mesh).integrate(&s);
        consistent_inverse(&mesh).solve(&mut solved);
        let area = barycentric_areas(&mesh);
        // On needles areas differ by 1e6, and so does the condition number.
        let tolerance = if name == "needles" { 1e-9 } else { 1e-11 };
        for v in (0..s.len()).filter(|&v| area[v] > 0.0) {
            assert!((solved[v] - s[v]).max_abs() <= tolerance, "{name}, vertex {v}");
        }
    }
}

/// A vertex without faces has no weight, and the inverse does not change its value.
#[test]
fn isolated_vertices_weigh_nothing() {
    let mesh = with_isolated_vertices(crate::samples::bumpy(4));
    let last = mesh.vertices.len() - 1;
    for mass in Mass::iter() {
        let weights = mass.weights(&mesh);
        assert_eq!((weights[0], weights[last]), (0.0, 0.0));
        let f = mass.on(&mesh).integrate(&vec![Row([3.0, 4.0]); last + 1]);
        assert_eq!((f[0], f[last]), (Row::ZERO, Row::ZERO));
    }
    let mut g = vec![Row([3.0, 4.0]); last + 1];
    consistent_inverse(&mesh).solve(&mut g);
    assert_eq!((g[0], g[last]), (Row([3.0, 4.0]), Row([3.0, 4.0])));
}

/// K^T A^-1 K = sum over faces and corners of cot(angle) / 2 on the opposite edge.
#[test]
fn the_laplacian_is_the_cotangent_laplacian() {
    for (name, mesh) in zoo() {
        let n = mesh.vertices.len();
        let mut expected = DMatrix::<f64>::zeros(n, n);
        let mut size = 0.0_f64;
        for (j, face) in mesh.faces.iter().enumerate() {
            let corners = face.map(|k| k as usize);
            for (i, cotangent) in cotangents(&mesh, j).into_iter().enumerate() {
                let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                for (row, col, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                    expected[(row, col)] += sign * 0.5 * cotangent;
                }
                size = size.max(cotangent.abs());
            }
        }
        let laplacian = Matrix::new(&mesh).laplacian();
        let mut actual = DMatrix::zeros(n, n);
        for (&value, (row, col)) in laplacian.iter() {
            actual[(row, col)] = value;
        }
        let tolerance = if name == "needles" { 1e-8 } else { 1e-11 };
        assert!((&actual - &expected).amax() <= tolerance * size, "{name}");
    }
}

/// The Dirichlet energy of a linear function on a flat piece is its squared gradient times the area.
#[test]
fn the_laplacian_gives_the_dirichlet_energy() {
    let mesh = crate::samples::shape("grid:8x5");
    let g = random_vector(&mut rng(34));
    let u: Vec<f64> = mesh.vertices.iter().map(|x| g.dot(&x.coords)).collect();
    let lu = times(&Matrix::new(&mesh).laplacian(), &u);
    let energy: f64 = u.iter().zip(lu).map(|(u, lu)| u * lu).sum();
    assert_within(energy, g.xy().norm_squared() * mesh.area(), 1e-13, energy);
}
