//! Vertex areas and cotangents of a triangle mesh.
//!
//! Barycentric: a_k = sum over the faces j at x_k of A_j / 3. Mixed Voronoi (M. Meyer, M. Desbrun,
//! P. Schröder, A. Barr, *Discrete Differential-Geometry Operators for Triangulated 2-Manifolds*, 2003,
//! section 3.3): a non-obtuse face gives its corner i the Voronoi share
//!
//! ```text
//! ( |e_ik|^2 cot(angle at l) + |e_il|^2 cot(angle at k) ) / 8
//! ```
//!
//! and an obtuse one A_j / 2 to its obtuse corner and A_j / 4 to the others. Both partitions are
//! nonnegative and sum to the area of the mesh. Degenerate faces contribute nothing.

use nalgebra::Vector3;

use super::Mesh;
use crate::sweep;

/// a_k by the barycentric partition, V areas; 0 at unreferenced vertices.
pub fn barycentric_areas(mesh: &Mesh) -> Vec<f64> {
    corner_sums(
        mesh,
        #[inline(always)]
        |j| [mesh.face_area(j) / 3.0; 3],
    )
}

/// N_k, the V normals of the vertices: the sum of the area vectors of the faces around each, divided by its length; 0
/// where it vanishes.
pub fn vertex_normals(mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); mesh.vertices.len()];
    for (j, corners) in mesh.faces.iter().enumerate() {
        let area_vector = mesh.area_vector(j);
        corners.iter().for_each(|&k| normals[k as usize] += area_vector);
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(0.0).unwrap_or_default();
    }
    normals
}

/// a_k by the mixed Voronoi partition, V areas; 0 at unreferenced vertices.
pub fn mixed_voronoi_areas(mesh: &Mesh) -> Vec<f64> {
    corner_sums(mesh, |j| {
        let edges = opposite_edges(mesh, j);
        let cotangents = cotangents(mesh, j);
        match cotangents.iter().position(|&cotangent| cotangent < 0.0) {
            Some(obtuse) => {
                let area = mesh.face_area(j);
                let mut share = [area / 4.0; 3];
                share[obtuse] = area / 2.0;
                share
            }
            None => {
                let term = |i: usize| edges[i].norm_squared() * cotangents[i] / 8.0;
                [term(1) + term(2), term(2) + term(0), term(0) + term(1)]
            }
        }
    })
}

/// The cotangents of the angles at the three corners of face j; zeros for a degenerate face.
///
/// The area is computed from the two shorter edges, whose cross product has the smallest rounding error: the long edges
/// of a needle nearly cancel.
pub fn cotangents(mesh: &Mesh, j: usize) -> [f64; 3] {
    if mesh.is_degenerate(j) {
        return [0.0; 3];
    }
    let edges = opposite_edges(mesh, j);
    let mut by_length = [0, 1, 2];
    by_length.sort_by(|&a, &b| edges[a].norm_squared().total_cmp(&edges[b].norm_squared()));
    let twice_area = edges[by_length[0]].cross(&edges[by_length[1]]).norm();
    if twice_area == 0.0 {
        return [0.0; 3];
    }
    // The edges at corner i are e_{i+1} and -e_{i+2}.
    [0, 1, 2].map(|i| -edges[(i + 1) % 3].dot(&edges[(i + 2) % 3]) / twice_area)
}

/// The edge opposite to each corner of face j, head to tail: they sum to zero.
pub fn opposite_edges(mesh: &Mesh, j: usize) -> [Vector3<f64>; 3] {
    let [x1, x2, x3] = mesh.corners(j);
    [x3 - x2, x1 - x3, x2 - x1]
}

/// The orthonormal frame of face j in which `operator` expresses tangents: e1 along the edge from corner 1 to corner 2,
/// e2 towards corner 3. It does not depend on the side of the face.
pub fn frame(mesh: &Mesh, j: usize) -> [Vector3<f64>; 2] {
    let [x1, x2, x3] = mesh.corners(j);
    let e1 = (x2 - x1).normalize();
    let n = (x2 - x1).cross(&(x3 - x1)).normalize();
    [e1, n.cross(&e1)]
}

/// Sums a share per face corner into its vertex, over the faces that are not degenerate.
fn corner_sums(mesh: &Mesh, share: impl Fn(usize) -> [f64; 3] + Sync) -> Vec<f64> {
    sweep::scatter(
        mesh.vertices.len(),
        mesh.faces.len(),
        #[inline(always)]
        |j| mesh.faces[j].map(|v| v as usize),
        #[inline(always)]
        |j| if mesh.is_degenerate(j) { [0.0; 3] } else { share(j) },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn triangle(corners: [[f64; 3]; 3]) -> Mesh {
        Mesh::new(corners.map(Point3::from).to_vec(), vec![[0, 1, 2]])
    }

    fn assert_near(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn the_equilateral_triangle_is_shared_equally_by_both() {
        let mesh = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.75_f64.sqrt(), 0.0]]);
        for areas in [barycentric_areas(&mesh), mixed_voronoi_areas(&mesh)] {
            for a in areas {
                assert_near(a, mesh.area() / 3.0, 1e-14);
            }
        }
    }

    #[test]
    fn the_right_triangle_gives_half_to_its_right_angle() {
        let mesh = triangle([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        assert_eq!(mixed_voronoi_areas(&mesh), vec![3.0, 1.5, 1.5]);
    }

    #[test]
    fn the_partitions_are_nonnegative_and_sum_to_the_area_even_on_needles() {
        for height in [1e-12, 1e-6, 1e-2, 1.0, 1e3, 1e6, 1e12] {
            for foot in [-5.0, 0.0, 1e-9, 0.3, 0.5, 1.0, 7.0] {
                let mesh = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [foot, height, 0.0]]);
                for areas in [barycentric_areas(&mesh), mixed_voronoi_areas(&mesh)] {
                    assert!(areas.iter().all(|&a| a >= 0.0), "{foot} {height}: {areas:?}");
                    assert_near(areas.iter().sum(), mesh.area(), 1e-9);
                }
            }
        }
    }

    #[test]
    fn degenerate_faces_and_unreferenced_vertices_have_no_area() {
        let mut mesh = triangle([[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]);
        mesh.faces.push([0, 0, 1]);
        mesh.vertices.push(Point3::new(5.0, 5.0, 5.0));
        assert_eq!(mixed_voronoi_areas(&mesh), vec![0.0; 4]);
        assert_eq!(barycentric_areas(&mesh), vec![0.0; 4]);
    }
}
