//! Alpha-expansion: labels without a relaxation, by minimum cuts of a graph.
//!
//! ```text
//! G(labels) = sum_v f_v,label(v) + sum over the edges vw of w_vw [ label(v) != label(w) ]
//! labels   <- argmin G over the labelings that differ from the current one only where the label becomes p
//! ```
//!
//! A step is one minimum cut of the whole graph, for the next p. It is accepted if it lowers G by more than rounding;
//! after as many refused steps as there are labels, the labels are a local minimum and the method has settled. G is at
//! most twice its minimum then. Y. Boykov, O. Veksler, R. Zabih, *Fast approximate energy minimization via graph cuts*,
//! IEEE Transactions on Pattern Analysis and Machine Intelligence 23(11), 2001.
//!
//! With exact weights and two regions, the labels are optimal after one step (`rounding/graph.rs` has the weights). The
//! method has no dual field: its bound is B, that of q = 0.

use super::{Adjustable, Built, Description, Iterate, OneByOne, Setting, Setup, Step};
use crate::domain::Domain;
use crate::field::{Row, Tangent};
use crate::operator::Operator;
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::rounding::expansion::{Costs, NONE, best_expansion};
use crate::rounding::graph::{EdgeWeights, Graph};
use crate::sweep::collect;

pub(super) const DESCRIPTION: Description = Description {
    name: "alpha-expansion",
    summary: "minimum cuts of a graph, no relaxation; labels without a lower bound, which --label-gap adds",
    reference: "Boykov, Veksler, Zabih 2001; Boykov, Kolmogorov 2003 and 2004",
    steps: "one minimum cut each, for one label after the other, from the labels of the smallest costs",
};

/// The settings of alpha-expansion: `weights`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// w, the weights of the edges.
    pub weights: EdgeWeights,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { weights: EdgeWeights::Exact }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        vec![Setting::choice(
            "weights",
            &mut self.weights,
            "weights of the edges: exact where a face has at most two labels; `cotangent` and `crofton` are common \
             alternatives whose cuts cost only about the length",
        )]
    }
}

pub(super) fn build<'a, K: Operator + 'a, const M: usize>(
    settings: &Settings,
    setup: Setup<'_, K, M>,
) -> Built<'a, K, M> {
    Ok(Box::new(OneByOne::new(AlphaExpansion::new(settings, setup))))
}

struct AlphaExpansion<const M: usize> {
    /// One-hot.
    u: Vec<Row<M>>,
    /// Zero: the method has no dual field.
    q: Vec<Tangent<M>>,
    labels: Vec<u8>,
    graph: Graph,
    /// See [`best_expansion`].
    node: Vec<u32>,
    /// The labels that are allowed anywhere.
    allowed: Vec<u8>,
    /// Which of them is expanded next.
    next: usize,
    /// Number of steps since the last change.
    refused: usize,
    /// The lambda of the graph.
    lambda: f64,
    graph_of: GraphOf,
}

/// The graph for another lambda.
type GraphOf = Box<dyn Fn(f64) -> Graph>;

fn graph_of(domain: Domain<'_>, weights: EdgeWeights) -> GraphOf {
    match domain {
        Domain::Vertices(mesh) => {
            let mesh = mesh.clone();
            Box::new(move |lambda| Graph::new((&mesh).into(), weights, lambda))
        }
        Domain::Weighted(mesh, factors) => {
            let (mesh, factors) = (mesh.clone(), factors.to_vec());
            Box::new(move |lambda| Graph::new(Domain::Weighted(&mesh, &factors), weights, lambda))
        }
        Domain::Faces(dual) => {
            let dual = dual.clone();
            Box::new(move |lambda| Graph::new((&dual).into(), weights, lambda))
        }
    }
}

impl<const M: usize> AlphaExpansion<M> {
    fn new<K: Operator>(settings: &Settings, setup: Setup<'_, K, M>) -> Self {
        let Setup { domain, problem, start, .. } = setup;
        let weights = settings.weights;
        let labels: Vec<u8> = collect(start.len(), |v| start[v].argmax() as u8);
        let mut method = AlphaExpansion {
            u: start,
            q: vec![Tangent::ZERO; problem.k.faces()],
            graph: Graph::new(domain, weights, problem.lambda),
            node: vec![NONE; labels.len()],
            labels,
            allowed: Vec::new(),
            next: 0,
            refused: 0,
            lambda: problem.lambda,
            graph_of: graph_of(domain, weights),
        };
        method.begin(&problem.f);
        method
    }

    /// The labels of the start, or the cheapest where these are forbidden.
    fn begin(&mut self, f: &[Row<M>]) {
        for (label, f) in self.labels.iter_mut().zip(f) {
            if f.0[usize::from(*label)] == FORBIDDEN_COST {
                *label = f.argmin() as u8;
            }
        }
        let is_allowed = |p: &u8| f.iter().any(|f| f.0[usize::from(*p)] != FORBIDDEN_COST);
        self.allowed = (0..M as u8).filter(is_allowed).collect();
        (self.next, self.refused) = (0, 0);
        let Self { u, labels, .. } = self;
        u.iter_mut().zip(labels).for_each(|(u, label)| *u = Row::one_hot((*label).into()));
    }

    /// G after vertices change to label p, minus G, and a bound of its rounding error.
    fn change(
        &self,
        f: &[Row<M>],
        distance: impl Fn(u8, u8) -> f64,
        changed: &[u32],
        p: u8,
    ) -> [f64; 2] {
        let after =
            |v: u32| if self.node[v as usize] == NONE { self.labels[v as usize] } else { p };
        let (mut sum, mut size) = (0.0, 0.0);
        let mut add = |new: f64, old: f64| {
            sum += new - old;
            size += new.abs() + old.abs();
        };
        for &v in changed {
            let (f, own) = (f[v as usize].0, self.labels[v as usize]);
            add(f[usize::from(p)], f[usize::from(own)]);
            for &(w, weight) in self.graph.neighbors(v) {
                // Edges between two changed vertices are visited twice.
                let share = if self.node[w as usize] == NONE { 1.0 } else { 0.5 };
                let share = share * weight;
                let before = self.labels[w as usize];
                add(share * distance(after(w), p), share * distance(own, before));
            }
        }
        [sum, 8.0 * f64::EPSILON * size]
    }
}

impl<K: Operator, const M: usize> Step<K, M> for AlphaExpansion<M> {
    fn step(&mut self, Problem { f, relaxation, .. }: &Problem<K, M>) {
        let Some(&p) = self.allowed.get(self.next) else { return };
        if self.refused == self.allowed.len() {
            return;
        }
        self.next = (self.next + 1) % self.allowed.len();
        self.refused += 1;
        let cost = |v: u32, p: u8| f[v as usize].0[usize::from(p)];
        let may_change = |v: &u32| self.labels[*v as usize] != p && cost(*v, p) != FORBIDDEN_COST;
        let nodes = (0..self.labels.len() as u32).filter(may_change).collect();
        let neighbors = |v: u32| self.graph.neighbors(v);
        let distance = |a: u8, b: u8| relaxation.label_metric().distance(a.into(), b.into());
        let costs = Costs { of_label: cost, distance, neighbors };
        let changed = best_expansion(nodes, &self.labels, p, costs, &mut self.node);
        changed.iter().for_each(|&v| self.node[v as usize] = 0);
        let [change, error] = self.change(f, distance, &changed, p);
        changed.iter().for_each(|&v| self.node[v as usize] = NONE);
        if change < -error {
            self.refused = 0;
            for v in changed.into_iter().map(|v| v as usize) {
                (self.labels[v], self.u[v]) = (p, Row::one_hot(p.into()));
            }
        }
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        if self.lambda != problem.lambda {
            self.lambda = problem.lambda;
            self.graph = (self.graph_of)(problem.lambda);
        }
        self.begin(&problem.f);
    }

    fn is_settled(&self) -> bool {
        self.refused == self.allowed.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::operator::Stencil;
    use crate::problem::rounded;
    use crate::run::{Run, Status, Stop};
    use crate::samples::{bumpy, random_problem, shape};
    use crate::solver::Solver;
    use std::ops::ControlFlow;

    const WEIGHTS: [EdgeWeights; 3] =
        [EdgeWeights::Exact, EdgeWeights::Cotangent, EdgeWeights::Crofton];

    fn method<const M: usize>(
        weights: EdgeWeights,
        mesh: &Mesh,
        problem: &Problem<Stencil, M>,
    ) -> AlphaExpansion<M> {
        let start = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
        AlphaExpansion::new(
            &Settings { weights },
            Setup { domain: mesh.into(), problem, start, dual_start: None },
        )
    }

    /// G of labels.
    fn energy<const M: usize>(graph: &Graph, f: &[Row<M>], labels: &[u8]) -> f64 {
        let data: f64 = labels.iter().zip(f).map(|(&p, f)| f.0[usize::from(p)]).sum();
        let cut = |v: usize| {
            let edges = graph.neighbors(v as u32).iter();
            edges.filter(|(w, _)| labels[*w as usize] != labels[v]).map(|edge| edge.1).sum::<f64>()
        };
        data + 0.5 * (0..labels.len()).map(cut).sum::<f64>()
    }

    /// Each step is the best expansion of its label, found by trying all, and the last labels cost at most twice the
    /// minimum.
    #[test]
    fn every_step_is_the_best_expansion() {
        let mesh = bumpy(2);
        let n = mesh.vertices.len();
        assert_eq!(n, 9);
        for seed in 0..12 {
            let problem = random_problem::<3>(&mesh, [0.1, 0.5, 1.0][seed as usize % 3], seed);
            for weights in WEIGHTS {
                let mut method = method(weights, &mesh, &problem);
                let graph = Graph::new((&mesh).into(), weights, problem.lambda);
                let g = |labels: &[u8]| energy(&graph, &problem.f, labels);
                while !Step::<Stencil, 3>::is_settled(&method) {
                    let (before, p) = (method.labels.clone(), method.allowed[method.next]);
                    Step::<Stencil, 3>::step(&mut method, &problem);
                    let expansions = (0..1_u32 << n).map(|set| {
                        let label = |v: usize| if set >> v & 1 == 1 { p } else { before[v] };
                        g(&(0..n).map(label).collect::<Vec<_>>())
                    });
                    let best = expansions.fold(f64::INFINITY, f64::min);
                    assert!((g(&method.labels) - best).abs() <= 1e-13, "{weights:?}, {seed}");
                }
                let all = (0..3_usize.pow(9)).map(|code| {
                    let label = |v: u32| (code / 3_usize.pow(v) % 3) as u8;
                    g(&(0..9).map(label).collect::<Vec<_>>())
                });
                let minimum = all.fold(f64::INFINITY, f64::min);
                assert!(g(&method.labels) <= 2.0 * minimum + 1e-13);
            }
        }
    }

    /// Two regions and exact weights: no labels cost less than those of the first step, by brute force over E itself.
    #[test]
    fn one_exact_cut_is_optimal_for_two_regions() {
        let mesh = bumpy(2);
        for seed in 0..20 {
            let problem = random_problem::<2>(&mesh, 0.3, seed);
            // From here every labeling is an expansion of label 0.
            let start = vec![Row::one_hot(1); 9];
            let setup =
                Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
            let mut method = AlphaExpansion::new(&Settings::default(), setup);
            Step::<Stencil, 2>::step(&mut method, &problem);
            let energy = |labels: u32| {
                let row = |v: u32| Row::one_hot((labels >> v & 1) as usize);
                problem.energy(&(0..9).map(row).collect::<Vec<_>>())
            };
            let best = (0..1 << 9).map(energy).fold(f64::INFINITY, f64::min);
            let found = problem.energy(&method.u);
            assert!((found - best).abs() <= 1e-13 * problem.spread(), "{seed}: {found} {best}");
        }
    }

    /// G never rises, the run ends as settled, and with exact weights E of the labels does not exceed G.
    #[test]
    fn the_run_settles() {
        for mesh in [shape("torus:24x16"), shape("sphere:3").scaled(1e-3)] {
            let problem = random_problem::<5>(&mesh, 0.1 * mesh.area().sqrt(), 7);
            for weights in WEIGHTS {
                let graph = Graph::new((&mesh).into(), weights, problem.lambda);
                let mut method = method(weights, &mesh, &problem);
                let first = energy(&graph, &problem.f, &method.labels);
                let mut before = first;
                for _ in 0..5 {
                    Step::<Stencil, 5>::step(&mut method, &problem);
                    let now = energy(&graph, &problem.f, &method.labels);
                    assert!(now <= before + 1e-13 * first);
                    before = now;
                }
                assert!(before < first);
                let mut run = Run::new(&method.u);
                let mut solver = OneByOne::new(method);
                let stop = Stop { iterations: Some(500), ..Stop::default() };
                let status =
                    run.advance(&mut solver, &problem, &stop, &mut |_| ControlFlow::Continue(()));
                assert_eq!(status, Status::Settled, "{weights:?}");
                let u = Solver::<Stencil, 5>::iterate(&mut solver).u;
                assert_eq!(rounded(u), u);
                if weights == EdgeWeights::Exact {
                    let labels: Vec<u8> = u.iter().map(|u| u.argmax() as u8).collect();
                    let g = energy(&graph, &problem.f, &labels);
                    assert!(problem.energy(u) <= g * (1.0 + 1e-13));
                }
            }
        }
    }

    /// Labels that are forbidden at the start are left at once, and forbidden ones are never taken.
    #[test]
    fn forbidden_labels_are_left_and_never_taken() {
        let mesh = bumpy(6);
        let mut problem = random_problem::<3>(&mesh, 1.0, 3);
        problem.f.iter_mut().step_by(2).for_each(|f| f.0[0] = FORBIDDEN_COST);
        let start = vec![Row::one_hot(0); problem.f.len()];
        let setup = Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
        let mut method = AlphaExpansion::new(&Settings::default(), setup);
        for _ in 0..8 {
            let allowed = |(u, f): (&Row<3>, &Row<3>)| f.0[u.argmax()] != FORBIDDEN_COST;
            assert!(method.u.iter().zip(&problem.f).all(allowed));
            Step::<Stencil, 3>::step(&mut method, &problem);
        }
    }

    /// On equilateral triangles with edges of length 1: 1/2 for exact weights, 1/sqrt(3) for dual edges, and pi
    /// sqrt(3) / 12, for which lines of all directions have their length on average; all times sqrt(2) lambda.
    #[test]
    fn weights_of_equilateral_triangles() {
        let rows = 6;
        let mut mesh = shape(&format!("grid:{rows}x{rows}"));
        for (v, x) in mesh.vertices.iter_mut().enumerate() {
            let [column, row] = [v % (rows + 1), v / (rows + 1)].map(|i| i as f64);
            *x = [column - 0.5 * row, 0.75_f64.sqrt() * row, 0.0].into();
        }
        let is_edge = |v: usize, w: u32| {
            let length = (mesh.vertices[v] - mesh.vertices[w as usize]).norm();
            (length - 1.0).abs() <= 1e-12
        };
        let center = 3 * (rows + 1) + 3;
        let expected = [0.5, 3.0_f64.sqrt().recip(), std::f64::consts::PI * 3.0_f64.sqrt() / 12.0];
        for (weights, expected) in WEIGHTS.into_iter().zip(expected) {
            let graph = Graph::new((&mesh).into(), weights, 0.7);
            let edges = graph.neighbors(center as u32);
            assert!(edges.len() == 6 && edges.iter().all(|edge| is_edge(center, edge.0)));
            let expected = 0.7 * 2.0_f64.sqrt() * expected;
            assert!(edges.iter().all(|edge| (edge.1 - expected).abs() <= 1e-12), "{weights:?}");
        }
    }
}
