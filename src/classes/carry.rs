//! Costs, labels and colors between the vertices and the faces of a mesh.
//!
//! ```text
//! to vertices    f_k = sum_{j at k} A_j / 3 s_j,   s_k = f_k / a_k       exact: int u s for U linear on each face
//! to faces       s_j = (s_1 + s_2 + s_3) / 3                              exact: int u s for s linear on each face
//! ```
//!
//! a_k is the barycentric area. Unknown rows cost 0, and a row is unknown if all rows that it comes from are.

use ndarray::{Array1, Array2};

use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::incidence::Incidence;
use crate::sweep::{collect, ranges, sweep_parts};

/// V x m pointwise costs from F x m, for the barycentric mass: integrated, they are the integrals of the costs of the
/// faces.
pub fn to_vertices(mesh: &Mesh, s: &Array2<f64>) -> Array2<f64> {
    let areas = barycentric_areas(mesh);
    let around = Incidence::new(mesh, |j, _| j as u32);
    filled((mesh.vertices.len(), s.ncols()), |k, row| {
        let faces = around.at(k).iter().map(|&j| j as usize);
        let known = |&j: &usize| !mesh.is_degenerate(j) && !s[[j, 0]].is_nan();
        let mut is_known = false;
        for j in faces.filter(known) {
            is_known = true;
            let share = mesh.face_area(j) / 3.0 / areas[k];
            row.iter_mut().zip(s.row(j)).for_each(|(sum, s)| *sum += share * s);
        }
        if !is_known {
            row.fill(f64::NAN);
        }
    })
}

/// F x m pointwise costs from V x m.
pub fn to_faces(mesh: &Mesh, s: &Array2<f64>) -> Array2<f64> {
    filled((mesh.faces.len(), s.ncols()), |j, row| {
        let corners = mesh.faces[j].map(|v| v as usize);
        let mut is_known = false;
        for v in corners.into_iter().filter(|&v| !s[[v, 0]].is_nan()) {
            is_known = true;
            row.iter_mut().zip(s.row(v)).for_each(|(sum, s)| *sum += s / 3.0);
        }
        if !is_known {
            row.fill(f64::NAN);
        }
    })
}

/// The label of each face, for U and labels of the vertices: that of two corners or more, otherwise the one with the
/// largest u in the middle of the face.
pub fn labels_of_faces(mesh: &Mesh, u: &Array2<f64>, labels: &Array1<i32>) -> Array1<i32> {
    let label = |j: usize| {
        let corners = mesh.faces[j].map(|v| v as usize);
        let [a, b, c] = corners.map(|v| labels[v]);
        if a == b || a == c {
            return a;
        }
        if b == c {
            return b;
        }
        let in_the_middle = |p: i32| corners.iter().map(|&v| u[[v, p as usize]]).sum::<f64>();
        [b, c]
            .into_iter()
            .fold(a, |best, p| if in_the_middle(p) > in_the_middle(best) { p } else { best })
    };
    collect(mesh.faces.len(), label).into()
}

/// The label of each vertex: the one that covers most of the area around it, the first of equal ones; 0 at vertices
/// without faces.
pub fn labels_of_vertices(mesh: &Mesh, labels: &Array1<i32>, m: usize) -> Array1<i32> {
    let around = Incidence::new(mesh, |j, _| j as u32);
    let label = |k: usize| {
        let mut area = vec![0.0; m];
        for &j in around.at(k) {
            // Faces without area count where there are no others.
            area[labels[j as usize] as usize] += mesh.face_area(j as usize).max(f64::MIN_POSITIVE);
        }
        (1..m).fold(0, |best, p| if area[p] > area[best] { p } else { best }) as i32
    };
    collect(mesh.vertices.len(), label).into()
}

/// The mean color of the faces around each vertex, by area; NaN where all are.
pub fn colors_to_vertices(mesh: &Mesh, color: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        let color = color(j);
        if color[0].is_nan() {
            continue;
        }
        let area = mesh.face_area(j).max(f64::MIN_POSITIVE);
        for &v in face {
            let (sum, total) = &mut sums[v as usize];
            *total += area;
            (0..3).for_each(|c| sum[c] += area * color[c]);
        }
    }
    // 0 / 0 is NaN.
    sums.into_iter().map(|(sum, total)| sum.map(|c| c / total)).collect()
}

/// An array whose rows are filled in parallel; they are 0 before.
fn filled((rows, m): (usize, usize), fill: impl Fn(usize, &mut [f64]) + Sync) -> Array2<f64> {
    let mut numbers = vec![0.0; rows * m];
    let cuts: Vec<usize> = ranges(rows).into_iter().map(|row| row * m).collect();
    sweep_parts(&mut numbers, &cuts, |first, part| {
        for (row, numbers) in (first / m..).zip(part.chunks_mut(m)) {
            fill(row, numbers);
        }
    });
    Array2::from_shape_vec((rows, m), numbers).expect("rows of m numbers")
}
