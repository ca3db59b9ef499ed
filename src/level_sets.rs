//! Thresholds of a labeling in two regions: the energies of the sets {u > t}, u the first column of U.
//!
//! ```text
//! E(t) = E( 1_{u > t}, 1_{u <= t} )                                          as labels of the vertices
//! L(t) = int_{u > t} s_0 + int_{u <= t} s_1 + sqrt(2) lambda |{u = t}|       along the level lines through the faces
//! ```
//!
//! where u and s are linear on each face, each minus the energy of U with the same data term: that of the given mass for
//! E(t), the exact integral, that is, the consistent mass, for L(t). On continuous domains every threshold of an optimal u is optimal: T. F. Chan,
//! S. Esedoglu, M. Nikolova, *Algorithms for finding global minimizers of image segmentation and denoising models*, SIAM J.
//! Appl. Math. 66, 2006. On meshes only the mean is: int_0^1 L(t) dt is the energy of U by the coarea formula,
//! but L(t) is no energy of labels, and the labels of {u > t} cut along edges. A jump between two regions has the total
//! variation sqrt(2), hence the factor.

use nalgebra::Vector3;
use ndarray::{Array2, ArrayView1};
use serde::{Deserialize, Serialize};

use crate::contour::LevelLine;
use crate::costs;
use crate::error::Result;
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::Mass;
use crate::regions;
use crate::request::Request;
use crate::solve::{model_mesh, problem_of};
use crate::sweep::sum;

/// The energies of the set {u > t} minus that of U, in units of cost times area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelSet {
    /// t.
    pub threshold: f64,
    /// E(t) - E(U).
    pub labels: f64,
    /// L(t) minus the energy of U with the consistent mass.
    pub lines: f64,
}

/// The energies of {u > t}, minus that of U, at the midpoints of `count` equal parts of [0, 1], for pointwise costs s (V x 2) and the first
/// column of U. Unknown vertices cost 0.
///
/// # Errors
/// Costs that [`costs::checked`] refuses, forbidden labels, no face with an area, and energies that leave the range of double precision.
pub fn level_sets(
    mesh: &Mesh,
    s: &Array2<f64>,
    u: ArrayView1<'_, f64>,
    count: usize,
    request: &Request,
) -> Result<Vec<LevelSet>> {
    assert!(s.ncols() == 2 && u.len() == s.nrows());
    let (s, _) = costs::checked(s, Mass::Consistent)?;
    let (mesh, _) = model_mesh(mesh)?;
    let s: Vec<Row<2>> = regions::rows(s.view());
    let problem = problem_of::<2>(&mesh, 2, s.clone(), request)?;
    let rows: Vec<Row<2>> = u.iter().map(|&u| Row([u, 1.0 - u])).collect();
    let energy = problem.energy(&rows);
    let exact = Request { mass: Mass::Consistent, ..request.clone() };
    let exact = problem_of::<2>(&mesh, 2, s.clone(), &exact)?;
    let exact_energy = exact.baseline + exact.energy(&rows);
    let at = |t: f64| {
        let labels: Vec<Row<2>> = u.iter().map(|&u| Row::one_hot(usize::from(u <= t))).collect();
        let of_faces = sum(mesh.faces.len(), |j| {
            let corners = mesh.faces[j].map(|v| v as usize);
            let face = Face {
                x: mesh.corners(j).map(|x| x.coords),
                u: corners.map(|v| u[v]),
                s: corners.map(|v| s[v].0),
            };
            face.energy(t, request.lambda)
        });
        LevelSet {
            threshold: t,
            labels: problem.energy(&labels) - energy,
            lines: of_faces - exact_energy,
        }
    };
    Ok((0..count).map(|i| at((i as f64 + 0.5) / count as f64)).collect())
}

/// A face and what is known at its corners.
struct Face {
    x: [Vector3<f64>; 3],
    u: [f64; 3],
    s: [[f64; 2]; 3],
}

impl Face {
    /// The part of L(t) on the face.
    fn energy(&self, t: f64, lambda: f64) -> f64 {
        let Face { x, u, s } = self;
        let area = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).norm();
        let whole = |p: usize| area * (s[0][p] + s[1][p] + s[2][p]) / 3.0;
        let above = u.map(|u| u > t);
        let Some(line) = LevelLine::new(*u, t, above) else {
            return whole(usize::from(!above[0]));
        };
        let ([i, j, k], alpha) = (line.corners, line.alpha);
        // The integral of a linear function over the triangle at corner i.
        let corner = |p: usize| {
            let at = |e: usize| s[i][p] + alpha[e] * (s[[j, k][e]][p] - s[i][p]);
            area * alpha[0] * alpha[1] * (s[i][p] + at(0) + at(1)) / 3.0
        };
        let (own, other) = if above[i] { (0, 1) } else { (1, 0) };
        let cut = 2.0_f64.sqrt() * lambda * line.length(*x);
        corner(own) + whole(other) - corner(other) + cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Mass;
    use crate::run::Stop;
    use crate::samples::{assert_within, bumpy, random_rows, rng};
    use crate::solver::Method;
    use rand::RngExt;

    fn request(mass: Mass) -> Request {
        Request {
            lambda: 0.3,
            relaxation: Default::default(),
            mass,
            method: Method::default(),
            stop: Stop::default(),
            coarse_to_fine: false,
            keep_dual: false,
            rounding: Default::default(),
            label_gap: None,
        }
    }

    /// The coarea formula: the mean of L over all thresholds is the energy of U, whatever the mass of E.
    #[test]
    fn the_mean_over_all_thresholds_is_the_energy() {
        let mesh = bumpy(6);
        let mut rng = rng(911);
        let s = regions::array(&random_rows::<2>(mesh.vertices.len(), &mut rng), 2) + 2.0;
        let u: Vec<f64> = mesh.vertices.iter().map(|_| rng.random()).collect();
        for mass in [Mass::Barycentric, Mass::Consistent] {
            let request = request(mass);
            let problem = problem_of::<2>(&mesh, 2, regions::rows(s.view()), &request).unwrap();
            let rows: Vec<Row<2>> = u.iter().map(|&u| Row([u, 1.0 - u])).collect();
            let energy = problem.baseline + problem.energy(&rows);
            // The midpoint rule, since L is piecewise smooth.
            let error = |count: usize| {
                let all = level_sets(&mesh, &s, ArrayView1::from(&u), count, &request).unwrap();
                (all.iter().map(|set| set.lines).sum::<f64>() / count as f64).abs() / energy
            };
            let errors = [error(500), error(2000)];
            assert!(errors[0] < 1e-3 && errors[1] < 0.2 * errors[0] + 1e-6, "{errors:?}");
        }
    }

    /// The labels of binary U are U.
    #[test]
    fn binary_labels_have_the_energy_of_u() {
        let mesh = bumpy(8);
        let mut rng = rng(912);
        let s = regions::array(&random_rows::<2>(mesh.vertices.len(), &mut rng), 2) + 2.0;
        let u: Vec<f64> = mesh.vertices.iter().map(|x| f64::from(u8::from(x.z > 0.1))).collect();
        for mass in [Mass::Barycentric, Mass::Consistent] {
            for set in level_sets(&mesh, &s, ArrayView1::from(&u), 7, &request(mass)).unwrap() {
                assert_eq!(set.labels, 0.0);
            }
        }
    }

    /// The level line of a linear function through a square has its exact length, and the parts their exact area.
    #[test]
    fn level_lines_of_a_linear_function_are_straight() {
        let mesh = crate::samples::shape("grid:7x5");
        let (low, high) = (mesh.vertices[0].x, mesh.vertices.last().unwrap().x);
        let height = mesh.vertices.last().unwrap().y - mesh.vertices[0].y;
        let width = high - low;
        let u: Vec<f64> = mesh.vertices.iter().map(|x| (x.x - low) / width).collect();
        let s = Array2::from_shape_fn((u.len(), 2), |(_, p)| p as f64);
        let request = request(Mass::Consistent);
        for set in level_sets(&mesh, &s, ArrayView1::from(&u), 9, &request).unwrap() {
            // The line is as long as the total variation of U.
            let exact = (set.threshold - 0.5) * width * height;
            assert_within(set.lines, exact, 1e-12, width * height);
        }
    }
}
