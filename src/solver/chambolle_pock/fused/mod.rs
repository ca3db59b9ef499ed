//! The method in one pass over memory, for the stencil: blocks of vectors, parts that threads own.
//!
//! The same iterates as `rows`, to rounding: only the sums K^T q run in another order. That order is one for
//! all numbers of threads, and no instruction set contracts or reorders anything, so the bits depend on
//! neither. In single precision the problem is scaled by powers of two to numbers near 1; what is looked at is
//! made feasible in double precision.

mod bound;
mod buffer;
mod lanes;
mod layout;
mod part;
mod pass;

#[cfg(test)]
mod tests;

use std::ops::Range;

use pulp::Arch;

use bound::{Bounds, Scratch};
use lanes::{Real, lane_order};
use layout::{Layout, connect, last};
use part::{Outbox, Part, Units};
use pass::Pass;

use super::Method;
use super::steps::Steps;
use crate::field::{Row, Tangent};
use crate::operator::{Operator, Stencil};
use crate::problem::Problem;
use crate::prox::project_ball;
use crate::solver::{Iterate, Solver};
use crate::sweep::{collect, each, max, results, sum, sweep, sweep_parts, threads};

/// A thread with fewer vertices than this spends its time at the border.
const LEAST_VERTICES: usize = 2048;

pub struct Fused<T, const M: usize> {
    /// The vector instructions to use.
    arch: Arch,
    parts: Vec<Part<T>>,
    /// What the parts sent after the last step, and room for what they send after the next.
    outboxes: [Vec<Outbox<T>>; 2],
    units: Units,
    method: Method<M>,
    /// The part of each face, and its number there; empty until q is looked at.
    home: Vec<(u32, u32)>,
    /// What was looked at last, in the order of the mesh; q is empty until then.
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    /// D(q) vertex by vertex, and what the parts need for it; empty until then.
    bounds: Vec<f64>,
    scratch: Vec<Scratch>,
    u_unpacked: bool,
    q_unpacked: bool,
    /// Whether the last step landed; if not, u is infeasible and stays so.
    landed: bool,
    faces: usize,
    /// As of the last step.
    lambda: f64,
}

impl<T: Real, const M: usize> Fused<T, M> {
    pub fn new<K: Operator>(
        problem: &Problem<K, M>,
        stencil: &Stencil,
        u: Vec<Row<M>>,
        q: Option<Vec<Tangent<M>>>,
        method: Method<M>,
        arch: Arch,
    ) -> Self {
        let order = lane_order::<T>(arch);
        let units = units::<T>(stencil, &method.steps);
        let count = threads().min(u.len() / LEAST_VERTICES).max(1);
        let ranges = split(stencil.corners(), u.len(), count);
        let mut layouts =
            results(ranges, |range| Layout::new(range, stencil.corners(), u.len(), &order));
        connect(&mut layouts);
        let kq = q.as_ref().map(|q| {
            problem.k.prepare_adjoint();
            collect(u.len(), |v| problem.k.adjoint_at(q, v))
        });
        let parts = results(layouts, |layout| {
            let mut part = Part::new(layout, M);
            part.set_u(&|v| &u[v].0);
            part.set_f(&|v| &problem.f[v].0, units);
            part.set_weights(stencil.weights(), units);
            part.set_steps(&method.steps, units);
            if let (Some(q), Some(kq)) = (&q, &kq) {
                part.set_q(&|j| q[j].0.each_ref().map(|row| &row.0[..]), &|v| &kq[v].0, units);
            }
            part
        });
        let outboxes = [0, 1].map(|_| {
            let post = |part: &Part<T>| {
                let mut outbox = Outbox::new();
                part.post(&mut outbox);
                outbox
            };
            parts.iter().map(post).collect()
        });
        let q = q.unwrap_or_default();
        Fused {
            arch,
            parts,
            outboxes,
            units,
            method,
            home: Vec::new(),
            u,
            q,
            bounds: Vec::new(),
            scratch: Vec::new(),
            u_unpacked: false,
            q_unpacked: false,
            landed: true,
            faces: stencil.corners().len(),
            lambda: problem.lambda,
        }
    }
}

/// Ranges of vertices with about the same number of faces.
fn split(corners: &[[u32; 3]], vertices: usize, count: usize) -> Vec<Range<usize>> {
    // How many faces end before each vertex.
    let mut start = vec![0; vertices + 1];
    for corners in corners {
        start[last(corners) + 1] += 1;
    }
    for v in 0..vertices {
        start[v + 1] += start[v];
    }
    // A vertex costs about half as much as a face.
    let work = |v: usize| 2 * start[v] + v;
    let border = |k: usize| {
        let wanted = work(vertices) * k / count;
        (0..vertices).find(|&v| work(v) >= wanted).unwrap_or(vertices)
    };
    let borders: Vec<usize> = (0..count).map(border).chain([vertices]).collect();
    borders.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// Single precision needs numbers near 1; double precision takes them as they are.
fn units<T: Real>(stencil: &Stencil, steps: &Steps) -> Units {
    if T::DOUBLE {
        return Units { q: 1.0, k: 1.0 };
    }
    let inverse = |x: f64| if x.is_normal() { (-x.log2().floor()).exp2() } else { 1.0 };
    let longest = max(stencil.corners().len(), |j| {
        let [c1, c2, c3] = stencil.weights()[j];
        c1.max(c2.abs()).max(c3)
    });
    Units { q: inverse(steps.dual_scale()), k: inverse(longest) }
}

impl<K: Operator, T: Real, const M: usize> Solver<K, M> for Fused<T, M> {
    fn step(&mut self, problem: &Problem<K, M>, land: bool) {
        (self.lambda, self.landed) = (problem.lambda, land);
        let lambda = problem.lambda * self.units.q;
        let (arch, rho) = (self.arch, self.method.rho);
        self.outboxes.swap(0, 1);
        let [sent, received] = &mut self.outboxes;
        each(self.parts.iter_mut().zip(sent).collect(), &|(part, outbox)| {
            part.receive(received);
            arch.dispatch(Pass::<T, M> { part, lambda, rho, land });
            part.post(outbox);
        });
        (self.u_unpacked, self.q_unpacked) = (false, false);
        if self.method.due(land) {
            self.unpack();
            let now = Iterate { u: &self.u, q: &self.q };
            if self.method.rebalance(problem, now) {
                self.set_steps();
            }
        }
    }

    fn iterate(&mut self) -> Iterate<'_, M> {
        self.unpack()
    }

    fn labels(&mut self) -> &[Row<M>] {
        self.unpack_u();
        &self.u
    }

    fn dual_bound(&mut self, problem: &Problem<K, M>) -> f64 {
        if T::DOUBLE {
            // K^T q is at hand.
            sum(
                self.u.len(),
                #[inline(always)]
                |v| (problem.f[v] + owner(&self.parts, v).kq::<M>(v)).min(),
            )
        } else {
            let stencil = problem.k.stencil().expect("the engine was built from it");
            let Self { arch, parts, units, bounds, scratch, u, .. } = self;
            let (arch, units, order) = (*arch, *units, &lane_order::<f64>(*arch)[..]);
            bounds.resize(u.len(), 0.0);
            scratch.resize_with(parts.len(), Scratch::new);
            let mut rest = &mut bounds[..];
            let mut tasks = Vec::with_capacity(parts.len());
            for (part, scratch) in parts.iter().zip(scratch) {
                let (own, behind) = rest.split_at_mut(part.layout.range.len());
                tasks.push((part, scratch, own));
                rest = behind;
            }
            each(tasks, &|(part, scratch, bounds)| {
                arch.dispatch(Bounds { part, problem, stencil, units, order, scratch, bounds });
            });
            sum(
                bounds.len(),
                #[inline(always)]
                |v| bounds[v],
            )
        }
    }

    fn change(&mut self) -> Option<f64> {
        let changes = self.parts.iter().map(|part| part.change);
        Some(changes.fold(0.0, |most, change| if change > most { change } else { most }))
    }

    fn restart(&mut self, problem: &Problem<K, M>) {
        self.lambda = problem.lambda;
        self.unpack();
        self.method.restart(problem, Iterate { u: &self.u, q: &self.q });
        let units = self.units;
        each(self.parts.iter_mut().collect(), &|part| part.set_f(&|v| &problem.f[v].0, units));
        self.set_steps();
    }
}

impl<T: Real, const M: usize> Fused<T, M> {
    fn set_steps(&mut self) {
        let Self { parts, units, method, .. } = self;
        each(parts.iter_mut().collect(), &|part| part.set_steps(&method.steps, *units));
    }

    /// u in the order of the mesh, feasible in double precision too.
    fn unpack_u(&mut self) {
        if std::mem::replace(&mut self.u_unpacked, true) {
            return;
        }
        let Self { parts, u, landed, .. } = self;
        let ends = parts.iter().map(|part| part.layout.range.end);
        let cuts: Vec<usize> = [0].into_iter().chain(ends).collect();
        let feasible = T::DOUBLE || !*landed;
        sweep_parts(
            u,
            &cuts,
            #[inline(always)]
            |first, u| {
                owner(parts, first).read_u(u);
                if !feasible {
                    for row in u {
                        // A projection would give to closed regions too.
                        *row = *row * (1.0 / row.0.iter().sum::<f64>());
                    }
                }
            },
        );
    }

    /// q in the order of the mesh, feasible in double precision too.
    fn unpack_q(&mut self) {
        if std::mem::replace(&mut self.q_unpacked, true) {
            return;
        }
        let Self { parts, units, home, q, lambda, .. } = self;
        if home.is_empty() {
            home.resize(self.faces, (0, 0));
            for (k, part) in parts.iter().enumerate() {
                for (i, &j) in part.layout.faces.iter().enumerate() {
                    home[j as usize] = (k as u32, i as u32);
                }
            }
        }
        q.resize(home.len(), Tangent::ZERO);
        sweep(
            (&mut q[..], &home[..]),
            #[inline(always)]
            |_, (q, &(part, i))| {
                let tangent = parts[part as usize].q(i as usize, *units);
                *q = if T::DOUBLE { tangent } else { project_ball(tangent, *lambda) };
            },
        );
    }

    fn unpack(&mut self) -> Iterate<'_, M> {
        self.unpack_u();
        self.unpack_q();
        Iterate { u: &self.u, q: &self.q }
    }
}

/// The part that owns vertex v.
fn owner<T>(parts: &[Part<T>], v: usize) -> &Part<T> {
    &parts[parts.partition_point(|part| part.layout.range.end <= v)]
}
