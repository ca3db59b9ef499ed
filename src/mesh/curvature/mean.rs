//! Signed mean curvature at the vertices (M. Meyer, M. Desbrun, P. Schröder, A. Barr, *Discrete Differential-Geometry
//! Operators for Triangulated 2-Manifolds*, 2003, equation 8):
//!
//! ```text
//! H_v = < n_v, sum over the edges vk of (cot alpha_vk + cot beta_vk) (x_v - x_k) > / (4 a_v)
//! ```
//!
//! with the mixed Voronoi areas a_v and the area-weighted unit normals n_v. This is H n = -1/2 Laplace-Beltrami(x),
//! projected onto the normal, so that H passes smoothly through zero. On a sphere of radius r with outward normals, H =
//! 1/r: H is positive where the surface is convex as seen from the side to which the normals point. Coordinates rounded
//! by up to delta, modeled as random errors, cause a standard deviation of
//!
//! ```text
//! delta / sqrt(3)  sqrt( (sum_k w_k)^2 + sum_k w_k^2 ) / (4 a_v),     w_k = cot alpha_vk + cot beta_vk
//! ```

use nalgebra::Vector3;

use super::size::of_ordinary_size;
use crate::mesh::Mesh;
use crate::mesh::geometry::{cotangents, mixed_voronoi_areas, opposite_edges};
use crate::mesh::sides::{edges, sides};

/// H at the V vertices, in 1/length.
///
/// The formula is not valid on the boundary: a boundary vertex takes the mean of its interior neighbors. H is NaN if
/// there are none, and at vertices without area or normal. Reversing every face changes the sign; where neighbors
/// disagree in orientation the sign is that of the larger area, see [`crate::mesh::orient`].
pub fn mean_curvature(mesh: &Mesh) -> Vec<f64> {
    let (mesh, unit) = of_ordinary_size(mesh);
    let area = mixed_voronoi_areas(&mesh);
    let mut gradient = vec![Vector3::zeros(); mesh.vertices.len()];
    let mut normal = vec![Vector3::zeros(); mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        let cotangents = cotangents(&mesh, j);
        let edges = opposite_edges(&mesh, j);
        for (i, &v) in face.iter().enumerate() {
            let (v, next, last) = (v as usize, (i + 1) % 3, (i + 2) % 3);
            // The edges from corner i: x_v - x_next = -e_last and x_v - x_last = e_next.
            gradient[v] += cotangents[next] * edges[next] - cotangents[last] * edges[last];
            normal[v] += mesh.area_vector(j);
        }
    }
    let mut curvature: Vec<f64> = (0..mesh.vertices.len())
        .map(|v| match normal[v].try_normalize(0.0) {
            Some(normal) if area[v] > 0.0 => unit * normal.dot(&gradient[v]) / (4.0 * area[v]),
            _ => f64::NAN,
        })
        .collect();
    fill_boundary(&mesh, &mut curvature);
    curvature
}

/// The standard deviation of H at the V vertices if coordinates are rounded by up to delta; 0 at vertices without area.
pub fn rounding_noise(mesh: &Mesh, delta: f64) -> Vec<f64> {
    let area = mixed_voronoi_areas(mesh);
    // The two cotangents of a w_k are mostly about equal: w_k^2 <= 2 cot^2 alpha + 2 cot^2 beta.
    let mut sums = vec![(0.0, 0.0); mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        let cotangents = cotangents(mesh, j);
        for (i, &v) in face.iter().enumerate() {
            for cotangent in [cotangents[(i + 1) % 3], cotangents[(i + 2) % 3]] {
                let (sum, squares) = &mut sums[v as usize];
                *sum += cotangent;
                *squares += 2.0 * cotangent * cotangent;
            }
        }
    }
    let deviation = |(&area, (sum, squares)): (&f64, (f64, f64))| {
        if area > 0.0 {
            delta / 3.0_f64.sqrt() * (sum * sum + squares).sqrt() / (4.0 * area)
        } else {
            0.0
        }
    };
    area.iter().zip(sums).map(deviation).collect()
}

/// Replaces the boundary values by the mean of their interior neighbors.
fn fill_boundary(mesh: &Mesh, values: &mut [f64]) {
    let with_area = (0..mesh.faces.len()).filter(|&j| !mesh.is_degenerate(j));
    let sides = sides(&with_area.map(|j| mesh.faces[j]).collect::<Vec<_>>());
    let mut on_boundary = vec![false; values.len()];
    for edge in edges(&sides) {
        if let [side] = edge {
            side.edge.iter().for_each(|&v| on_boundary[v as usize] = true);
        }
    }
    let mut sums = vec![(0.0, 0.0); values.len()];
    for [k, l] in edges(&sides).map(|edge| edge[0].edge.map(|k| k as usize)) {
        for (v, neighbor) in [(k, l), (l, k)] {
            if on_boundary[v] && !on_boundary[neighbor] && !values[neighbor].is_nan() {
                sums[v].0 += values[neighbor];
                sums[v].1 += 1.0;
            }
        }
    }
    for v in (0..values.len()).filter(|&v| on_boundary[v]) {
        let (sum, count) = sums[v];
        values[v] = if count > 0.0 { sum / count } else { f64::NAN };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use std::f64::consts::TAU;

    /// A doubly periodic grid on the torus, outward orientation, with its angle v at each vertex.
    fn torus(big: f64, small: f64, n: usize) -> (Mesh, Vec<f64>) {
        let (columns, rows) = (3 * n, n);
        let mut vertices = Vec::new();
        let mut angles = Vec::new();
        for i in 0..columns {
            for k in 0..rows {
                let (s, v) = (TAU * i as f64 / columns as f64, TAU * k as f64 / rows as f64);
                let ring = big + small * v.cos();
                vertices.push(Point3::new(ring * s.cos(), ring * s.sin(), small * v.sin()));
                angles.push(v);
            }
        }
        let at = |i: usize, k: usize| ((i % columns) * rows + k % rows) as u32;
        let mut faces = Vec::new();
        for i in 0..columns {
            for k in 0..rows {
                faces.push([at(i, k), at(i + 1, k), at(i + 1, k + 1)]);
                faces.push([at(i, k), at(i + 1, k + 1), at(i, k + 1)]);
            }
        }
        (Mesh::new(vertices, faces), angles)
    }

    fn octahedron_sphere(r: f64, levels: usize) -> Mesh {
        let mut corners: Vec<[Vector3<f64>; 3]> = Vec::new();
        for signs in 0..8 {
            let s = [0, 1, 2].map(|b| if signs >> b & 1 == 1 { -1.0 } else { 1.0 });
            let mut t = [Vector3::x() * s[0], Vector3::y() * s[1], Vector3::z() * s[2]];
            if s[0] * s[1] * s[2] < 0.0 {
                t.swap(1, 2);
            }
            corners.push(t);
        }
        for _ in 0..levels {
            corners = corners
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let mid = |p: Vector3<f64>, q: Vector3<f64>| (p + q).normalize();
                    let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
                    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
                })
                .collect();
        }
        let mut index = std::collections::HashMap::new();
        let mut vertices = Vec::new();
        let faces = corners
            .iter()
            .map(|t| {
                t.map(|p| {
                    *index.entry([p.x, p.y, p.z].map(|c| (c * 1e9).round() as i64)).or_insert_with(
                        || {
                            vertices.push(Point3::from(p * r));
                            vertices.len() as u32 - 1
                        },
                    )
                })
            })
            .collect();
        Mesh::new(vertices, faces)
    }

    fn torus_error(n: usize) -> f64 {
        let (big, small) = (3.0, 1.0);
        let (mesh, angles) = torus(big, small, n);
        mean_curvature(&mesh)
            .iter()
            .zip(&angles)
            .map(|(h, v)| {
                let exact = (big + 2.0 * small * v.cos()) / (2.0 * small * (big + small * v.cos()));
                (h - exact).abs()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn torus_curvature_converges_with_order_two() {
        let (coarse, fine) = (torus_error(24), torus_error(48));
        assert!(fine < 2e-3, "{fine}");
        assert!((coarse / fine).log2() > 1.8, "{coarse} {fine}");
    }

    #[test]
    fn a_sphere_has_curvature_one_over_r() {
        for r in [1e-4, 1.0, 1e4] {
            for h in mean_curvature(&octahedron_sphere(r, 4)) {
                assert!((h * r - 1.0).abs() < 0.01, "{h} {r}");
            }
        }
    }

    #[test]
    fn reversed_faces_reverse_the_sign() {
        let (mesh, _) = torus(3.0, 1.0, 12);
        let mut reversed = mesh.clone();
        reversed.faces.iter_mut().for_each(|face| face.swap(1, 2));
        for (h, g) in mean_curvature(&mesh).iter().zip(mean_curvature(&reversed)) {
            assert!((h + g).abs() < 1e-12);
        }
    }

    #[test]
    fn scaling_by_c_divides_by_c() {
        let (mesh, _) = torus(3.0, 1.0, 12);
        for c in [1e-4, 1e4] {
            let scaled = mean_curvature(&mesh.clone().scaled(c));
            for (h, g) in mean_curvature(&mesh).iter().zip(scaled) {
                assert!((h - g * c).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn boundary_values_continue_the_interior_and_lone_faces_have_none() {
        let mut open = octahedron_sphere(1.0, 4);
        open.faces.retain(|face| face.iter().all(|&k| open.vertices[k as usize].z > -0.5));
        let curvature = mean_curvature(&open);
        for &k in open.faces.iter().flatten() {
            assert!((curvature[k as usize] - 1.0).abs() < 0.01);
        }
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
        let lone = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]);
        assert!(mean_curvature(&lone).iter().all(|h| h.is_nan()));
    }

    #[test]
    fn flipped_nonmanifold_and_degenerate_meshes_have_curvature_wherever_there_is_area() {
        let mut mesh = octahedron_sphere(1.0, 2);
        // Without symmetry, normals do not cancel.
        mesh.vertices.iter_mut().enumerate().for_each(|(k, x)| x.x += 0.01 * (k as f64).sin());
        for j in (0..mesh.faces.len()).step_by(3) {
            mesh.faces[j].swap(0, 1);
        }
        let twin = mesh.faces[1];
        mesh.faces.extend([twin, [0, 0, 1], [4, 4, 4]]);
        mesh.vertices.push(Point3::new(9.0, 9.0, 9.0));
        let curvature = mean_curvature(&mesh);
        assert!(curvature.last().unwrap().is_nan());
        assert!(curvature.iter().rev().skip(1).all(|h| h.is_finite()));
    }

    /// With random displacements, H has the predicted deviation.
    #[test]
    fn rounding_noise_is_as_predicted() {
        use rand::RngExt;
        let mut rng = crate::samples::rng(77);
        for (mesh, delta) in [(octahedron_sphere(1.0, 3), 1e-9), (torus(3.0, 1.0, 20).0, 1e-8)] {
            let exact = mean_curvature(&mesh);
            let foretold = rounding_noise(&mesh, delta);
            let mut squares = 0.0;
            for _ in 0..20 {
                let mut moved = mesh.clone();
                moved.vertices.iter_mut().for_each(|x| {
                    *x += delta * Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
                });
                let relative = mean_curvature(&moved).into_iter().zip(&exact).zip(&foretold);
                squares += relative.map(|((h, g), n)| ((h - g) / n).powi(2)).sum::<f64>();
            }
            let deviation = (squares / (20.0 * exact.len() as f64)).sqrt();
            assert!((0.8..1.1).contains(&deviation), "{deviation}");
        }
    }

    #[test]
    fn tiny_and_huge_meshes_have_the_same_curvature() {
        let mesh = octahedron_sphere(1.0, 2);
        for exponent in [-300, 150] {
            let c = 2.0_f64.powi(exponent);
            let scaled = mean_curvature(&mesh.clone().scaled(c));
            assert!(mean_curvature(&mesh).iter().zip(scaled).all(|(h, g)| *h == g * c));
        }
    }
}
