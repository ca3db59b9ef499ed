//! The best labels that are constant on every component, and the dual field that certifies them where lambda is so
//! large that they are optimal.
//!
//! ```text
//! u_v = e_p,  p = argmin_p F_p,   F = sum_v f_v                          over the component of v
//! K^T q = -(f_v - (a_v / a) F),   q_j = (K phi)_j / A_j,   K^T A^-1 K phi = K^T q
//! ```
//!
//! For a label that some vertices of the component forbid, K^T q raises f_v to the cost of the best label wherever it
//! is allowed. The remainder to a sum of zero goes to the vertices that forbid it, whose cost is infinite anyway.
//!
//! f + K^T q has the same minimizer p everywhere, so D(q) = sum min_p F_p = E(U): the gap is zero if |q_j| <= lambda.
//! Being a gradient, q has the smallest mean square among all fields with this divergence. Where some |q_j| is larger,
//! it is projected onto the ball, and the bound is true but not sharp. First-order methods approach such a q slowly,
//! especially on long thin surfaces; here it takes one Poisson problem.

use crate::field::{Row, Tangent};
use crate::mesh::disjoint_sets::DisjointSets;
use crate::operator::{Adjoint, Cholesky, Operator, normal_matrix};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::sweep::sweep;

/// Maximum number of entries of the Cholesky factor: 400 MB. A surface of 200,000 vertices needs a tenth of it.
const MAX_FACTOR_ENTRIES: usize = 50_000_000;

/// The best labels that are constant on every component.
pub struct ConstantLabels<const M: usize> {
    /// The component of each vertex, named by the smallest vertex in it.
    component: Vec<u32>,
    /// F of each component, at the index of its smallest vertex.
    total: Vec<Row<M>>,
}

impl<const M: usize> ConstantLabels<M> {
    pub fn new<K: Operator>(problem: &Problem<K, M>) -> Self {
        let n = problem.k.vertices();
        let mut joined = DisjointSets::new(n);
        for j in 0..problem.k.faces() {
            let [a, b, c] = problem.k.face(j).corners.map(|v| v as u32);
            joined.join(a, b);
            joined.join(a, c);
        }
        let component: Vec<u32> = (0..n as u32).map(|v| joined.root(v)).collect();
        let mut total = vec![Row::ZERO; n];
        for (f, &c) in problem.f.iter().zip(&component) {
            total[c as usize] +=
                Row::from_fn(|p| if f.0[p] == FORBIDDEN_COST { 0.0 } else { f.0[p] });
        }
        // A label that one vertex forbids is forbidden in its component. Summing FORBIDDEN_COST would overflow.
        for (f, &c) in problem.f.iter().zip(&component) {
            let total = &mut total[c as usize];
            *total =
                Row::from_fn(
                    |p| if f.0[p] == FORBIDDEN_COST { FORBIDDEN_COST } else { total.0[p] },
                );
        }
        ConstantLabels { component, total }
    }

    pub fn labels(&self) -> Vec<Row<M>> {
        let best = |&c: &u32| Row::one_hot(self.total[c as usize].argmin());
        self.component.iter().map(best).collect()
    }

    /// The field described above; `None` if the factorization breaks down by rounding or would need too much memory, as
    /// on faces that join vertices at random.
    pub fn field<K: Operator>(&self, problem: &Problem<K, M>) -> Option<Vec<Tangent<M>>> {
        let Problem { k, f, .. } = problem;
        let n = k.vertices();
        let mut share = vec![0.0; n];
        for j in 0..k.faces() {
            k.face(j).corners.iter().for_each(|&v| share[v] += k.area(j) / 3.0);
        }
        let mut area = vec![0.0; n];
        share.iter().zip(&self.component).for_each(|(a, &c)| area[c as usize] += a);
        let part = |v: usize| {
            let c = self.component[v] as usize;
            if area[c] > 0.0 { share[v] / area[c] } else { 1.0 }
        };
        let mut divergence: Vec<Row<M>> = (0..n)
            .map(|v| {
                let total = &self.total[self.component[v] as usize];
                let best = total.min();
                let cost = |p: usize| if total.0[p] == FORBIDDEN_COST { best } else { total.0[p] };
                let f = f[v];
                Row::from_fn(|p| {
                    if f.0[p] == FORBIDDEN_COST { 0.0 } else { cost(p) * part(v) - f.0[p] }
                })
            })
            .collect();
        // The remainder to a sum of zero, and the number of vertices that share it.
        let mut remainder = vec![(Row::<M>::ZERO, Row::<M>::ZERO); n];
        for (v, divergence) in divergence.iter().enumerate() {
            let (sum, count) = &mut remainder[self.component[v] as usize];
            *sum += *divergence;
            *count += Row::from_fn(|p| f64::from(f[v].0[p] == FORBIDDEN_COST));
        }
        for (v, divergence) in divergence.iter_mut().enumerate() {
            let (sum, count) = &remainder[self.component[v] as usize];
            let shared = |p: usize| -sum.0[p] / count.0[p];
            *divergence =
                Row::from_fn(
                    |p| if f[v].0[p] == FORBIDDEN_COST { shared(p) } else { divergence.0[p] },
                );
        }
        // The sums over a component vanish, and so does phi at its smallest vertex, where 1 is added to the diagonal.
        let grounded: Vec<f64> =
            (0..n).map(|v| f64::from(self.component[v] as usize == v)).collect();
        let weights: Vec<f64> = (0..k.faces()).map(|j| 1.0 / k.area(j)).collect();
        let factor = Cholesky::within(&normal_matrix(k, &grounded, &weights), MAX_FACTOR_ENTRIES)?;
        let gradient = |phi: &[Row<M>]| {
            let mut q = vec![Tangent::ZERO; k.faces()];
            sweep(&mut q[..], |j, q| *q = k.at(phi, j) * weights[j]);
            q
        };
        let mut phi = divergence.clone();
        factor.solve(&mut phi);
        // One step of iterative refinement.
        let mut residual = divergence;
        let q = gradient(&phi);
        let kt = k.adjoint();
        sweep(&mut residual[..], |v, r| *r = *r - kt.at(&q, v));
        factor.solve(&mut residual);
        phi.iter_mut().zip(&residual).for_each(|(phi, &correction)| *phi += correction);
        let mut q = gradient(&phi);
        problem.make_feasible(&mut q);
        Some(q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relaxation::{DualSet, Relaxation, with_set};
    use crate::samples::{disjoint, random_problem, shape, with_isolated_vertices, zoo};
    use strum::IntoEnumIterator;

    /// For a lambda above all |q_j| the labels and the field are optimal; for a smaller one the bound stays true.
    #[test]
    fn large_lambdas_are_certified_in_closed_form() {
        for ((name, mesh), relaxation) in
            zoo().into_iter().flat_map(|one| Relaxation::iter().map(move |it| (one.clone(), it)))
        {
            let problem = random_problem::<4>(&mesh, 1e6 * mesh.area().sqrt(), 811);
            let mut problem = problem.in_relaxation(relaxation);
            problem.f.iter_mut().for_each(|f| f.0[3] = FORBIDDEN_COST);
            let constant = ConstantLabels::new(&problem);
            let (energy, spread) = (problem.energy(&constant.labels()), problem.spread());
            let bound = problem.dual_bound(&constant.field(&problem).unwrap());
            assert!((energy - bound).abs() <= 1e-9 * spread, "{name}: {energy} {bound}");
            problem.lambda = 0.01 * mesh.area().sqrt();
            let q = constant.field(&problem).unwrap();
            let allowed = problem.lambda * (1.0 + 1e-14);
            with_set!(relaxation, set => assert!(q.iter().all(|&q| set.gauge(q) <= allowed)));
            let bound = problem.dual_bound(&q);
            assert!(bound <= energy + 1e-12 * spread && bound.is_finite(), "{name}");
            assert!(bound >= -spread, "{name}");
        }
    }

    /// Every component, and every isolated vertex, has its own best label.
    #[test]
    fn components_are_labeled_separately() {
        let parts = disjoint([shape("sphere:1"), shape("torus:5x4")]);
        let mesh = with_isolated_vertices(parts);
        let problem = random_problem::<3>(&mesh, 1e3, 812);
        let constant = ConstantLabels::new(&problem);
        let labels = constant.labels();
        let split = 1 + shape("sphere:1").vertices.len();
        let last = labels.len() - 1;
        assert!(labels[1..split].iter().all(|u| *u == labels[1]));
        assert!(labels[split..last].iter().all(|u| *u == labels[split]));
        assert_eq!(
            [labels[0], labels[last]],
            [0, last].map(|v| Row::one_hot(problem.f[v].argmin()))
        );
        assert!(problem.total_variation(&labels) == 0.0);
    }

    /// A component never gets a label that one of its vertices forbids, and the bound stays exact.
    #[test]
    fn a_label_forbidden_at_a_vertex_is_forbidden_in_its_component() {
        let mesh = disjoint([shape("sphere:1"), shape("torus:5x4")]);
        let mut problem = random_problem::<3>(&mesh, 1e6, 813);
        let best = |problem: &Problem<_, 3>| ConstantLabels::new(problem).labels()[0].argmax();
        let before = best(&problem);
        problem.f[7].0[before] = FORBIDDEN_COST;
        let constant = ConstantLabels::new(&problem);
        let labels = constant.labels();
        assert_ne!(labels[0].argmax(), before);
        let bound = problem.dual_bound(&constant.field(&problem).unwrap());
        assert!((problem.energy(&labels) - bound).abs() <= 1e-9 * problem.spread());
    }
}
