//! Restriction of costs to a coarser mesh, and prolongation of U and q to a finer one.
//!
//! With the prolongation P from the vertices of a coarse mesh to those of the finer one (`mesh/coarsen.rs`):
//!
//! ```text
//! f_coarse = P^T f                so that <P u, f> = <u, f_coarse>: costs are conserved
//! u_fine   = P u_coarse           rows of P are non-negative and sum to 1: u stays in the simplex
//! q_fine   = Proj_{|.|<=lambda}( tangential part of the mean over the corners of P qbar )
//! qbar_c   = sum_{j at c} A_j q_j / sum_{j at c} A_j     in space, R^{3 x m}
//! ```

use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::coarsen::{Coarsening, Parents};
use crate::mesh::geometry::frame;
use crate::problem::FORBIDDEN_COST;
use crate::relaxation::{DualSet, Relaxation, with_set};
use crate::sweep::sweep;

/// P^T f. A label is forbidden at a coarse vertex if all finer vertices that it represents forbid it, as for padding
/// regions. If only some do, these contribute the cost of their most expensive allowed label.
pub fn restrict<const M: usize>(level: &Coarsening, f: &[Row<M>]) -> Vec<Row<M>> {
    let n = level.mesh.vertices.len();
    let (mut coarse, mut allowed) = (vec![Row::<M>::ZERO; n], vec![[false; M]; n]);
    for (parents, f) in level.parents.iter().zip(f) {
        let most_expensive =
            Row::<M>::from_fn(|p| if f.0[p] == FORBIDDEN_COST { f.min() } else { f.0[p] }).max();
        let finite =
            Row::from_fn(|p| if f.0[p] == FORBIDDEN_COST { most_expensive } else { f.0[p] });
        for (&c, w) in parents.corners.iter().zip(parents.weights) {
            coarse[c as usize] += finite * w;
            let allowed = &mut allowed[c as usize];
            (0..M).for_each(|p| allowed[p] |= w > 0.0 && f.0[p] < FORBIDDEN_COST);
        }
    }
    for (coarse, allowed) in coarse.iter_mut().zip(&allowed) {
        *coarse = Row::from_fn(|p| if allowed[p] { coarse.0[p] } else { FORBIDDEN_COST });
    }
    coarse
}

/// P u.
pub fn prolong<const M: usize>(parents: &[Parents], u: &[Row<M>]) -> Vec<Row<M>> {
    let mut fine = vec![Row::ZERO; parents.len()];
    sweep(
        (&mut fine[..], parents),
        #[inline(always)]
        |_, (fine, parents)| *fine = interpolate(parents, |c| u[c]),
    );
    fine
}

#[inline(always)]
fn interpolate<const M: usize>(parents: &Parents, at: impl Fn(usize) -> Row<M>) -> Row<M> {
    let [a, b, c] = parents.corners.map(|c| at(c as usize));
    let [wa, wb, wc] = parents.weights;
    a * wa + b * wb + c * wc
}

/// q on the finer mesh. Tangent vectors are averaged in space, so the orientation of the faces does not matter.
pub fn prolong_dual<const M: usize>(
    level: &Coarsening,
    fine: &Mesh,
    q: &[Tangent<M>],
    (lambda, relaxation): (f64, Relaxation),
) -> Vec<Tangent<M>> {
    let mean = vertex_means(&level.mesh, q);
    let mut at_vertex = vec![[Row::<M>::ZERO; 3]; fine.vertices.len()];
    sweep(
        (&mut at_vertex[..], &level.parents[..]),
        #[inline(always)]
        |_, (at, parents)| {
            *at = [0, 1, 2].map(|i| interpolate(parents, |c| mean[c][i]));
        },
    );
    let mut fine_q = vec![Tangent::ZERO; fine.faces.len()];
    with_set!(relaxation, set => sweep(
        &mut fine_q[..],
        #[inline(always)]
        |j, q| {
            let [a, b, c] = fine.faces[j].map(|v| &at_vertex[v as usize]);
            let in_space = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) * (1.0 / 3.0));
            let along = frame(fine, j)
                .map(|e| in_space[0] * e[0] + in_space[1] * e[1] + in_space[2] * e[2]);
            *q = set.project(Tangent(along), lambda);
        },
    ));
    fine_q
}

/// qbar at each vertex: the rows of its three coordinates in space; zero at vertices without faces.
fn vertex_means<const M: usize>(mesh: &Mesh, q: &[Tangent<M>]) -> Vec<[Row<M>; 3]> {
    let mut mean = vec![[Row::<M>::ZERO; 3]; mesh.vertices.len()];
    let mut area = vec![0.0; mesh.vertices.len()];
    for (j, &Tangent([q1, q2])) in q.iter().enumerate() {
        let a = mesh.face_area(j);
        let [e1, e2] = frame(mesh, j);
        let in_space = [0, 1, 2].map(|i| q1 * (a * e1[i]) + q2 * (a * e2[i]));
        for v in mesh.faces[j].map(|v| v as usize) {
            area[v] += a;
            (0..3).for_each(|i| mean[v][i] += in_space[i]);
        }
    }
    for (mean, area) in mean.iter_mut().zip(area) {
        if area > 0.0 {
            *mean = mean.map(|row| row * (1.0 / area));
        }
    }
    mean
}

#[cfg(test)]
mod tests;
