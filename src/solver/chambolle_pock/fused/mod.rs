//! The fused engine: the method for the stencil, several iterations in one pass over memory, on blocks of vectors, with
//! one part of the mesh per thread.
//!
//! The iterates are those of `rows` up to rounding: the sums K^T q are taken in another order, and products are rounded
//! together with the sums to which they are added. The order is the same for every number of threads, so that the bits
//! do not depend on that number, nor on whether the vectors are those of AVX2 or of AVX-512. In single precision the
//! problem is scaled by powers of two to numbers near 1; sampled iterates are made feasible in double precision.

mod bound;
mod buffer;
mod halo;
mod lanes;
mod layout;
mod part;
mod pass;

#[cfg(test)]
mod tests;

use pulp::Arch;

use bound::{Bounds, KnownBounds};
use buffer::Slices;
use halo::HaloMessage;
pub use lanes::Real;
use lanes::lane_order;
use layout::{BlockLayout, Lanes, Window};
use part::{Part, Units, groups, share_slots};
use pass::{Ball, MAX_DEPTH, Pass};

use super::stepping::Stepping;
use super::steps::Steps;
use crate::field::{Row, Tangent};
use crate::operator::{Adjoint, Operator, Stencil};
use crate::problem::Problem;
use crate::relaxation::{DualSet, Relaxation, with_set};
use crate::solver::{Iterate, Solver};
use crate::sweep::{collect, each, max, results, sum, sweep, sweep_parts, threads};

/// With fewer vertices than this, a thread would spend its time on the border.
const MIN_VERTICES_PER_THREAD: usize = 2048;

/// The size of a core's share of all caches, which should hold the data that the iterations of a pass use at a time.
const CACHE_BYTES: usize = 4 << 20;

pub struct Fused<T, const M: usize> {
    /// The vector instructions to use.
    arch: Arch,
    layout: BlockLayout,
    parts: Vec<Part<T>>,
    /// The messages that each part sent after the last pass, and those that it sends after the next.
    messages: [Vec<Vec<HaloMessage<T>>>; 2],
    units: Units,
    stepping: Stepping<M>,
    /// The number of iterations so far.
    iterations_made: usize,
    /// The position of each face in the order of the layout; empty until q is first read.
    face_positions: Vec<u32>,
    /// The iterate in the order of the mesh, as of the last time that it was read; until then q is empty if it is zero.
    u: Vec<Row<M>>,
    /// The number of iterations when u was last read; `usize::MAX` before.
    u_read_at: usize,
    q: Vec<Tangent<M>>,
    /// D(q) vertex by vertex; empty until it is first computed.
    bounds: Vec<f64>,
    /// For each part, the shares of K^T q from which D(q) is computed in single precision.
    shares: Vec<Slices<f64, 1>>,
    /// lambda as of the last step or restart.
    lambda: f64,
    relaxation: Relaxation,
}

/// Which thread computes what on a mesh, and where it is stored.
pub struct Partition {
    arch: Arch,
    layout: BlockLayout,
    windows: Vec<Window>,
}

impl Partition {
    /// For M regions and numbers of type T.
    pub fn new<T: Real, const M: usize>(stencil: &Stencil, arch: Arch) -> Self {
        let (corners, vertices) = (stencil.corners(), stencil.vertices());
        let layout = BlockLayout::new(corners, vertices, Lanes::new(lane_order::<T>(arch)));
        let count = threads().min(vertices / MIN_VERTICES_PER_THREAD).max(1);
        let windows = layout.windows(corners, count, depth::<T, M>(&layout));
        Partition { arch, layout, windows }
    }
}

impl<T: Real, const M: usize> Fused<T, M> {
    /// On a partition that was made for the same mesh, T and M; the relaxation must not be `Envelope`.
    pub fn new(
        problem: &Problem<Stencil, M>,
        u: Vec<Row<M>>,
        q: Option<Vec<Tangent<M>>>,
        stepping: Stepping<M>,
        partition: Partition,
    ) -> Self {
        let Partition { arch, layout, windows } = partition;
        let stencil = &problem.k;
        let units = units::<T>(stencil, &stepping.steps);
        let messages_from = |sender| HaloMessage::from(sender, &windows);
        let mut messages =
            [0, 1].map(|_| (0..windows.len()).map(messages_from).collect::<Vec<_>>());
        let kq = q.as_ref().map(|q| {
            let kt = stencil.adjoint();
            collect(u.len(), |v| kt.at(q, v))
        });
        let parts: Vec<Part<T>> = results(windows, |window| {
            let mut part = Part::new(window, &layout, u.len(), M);
            part.set_u(&u);
            part.set_f(&problem.f, units);
            part.set_steps(&stepping.steps, stencil.weights(), units);
            if let (Some(q), Some(kq)) = (&q, &kq) {
                part.set_q(q, kq, units);
            }
            part
        });
        for (part, messages) in parts.iter().zip(&mut messages[0]) {
            messages.iter_mut().for_each(|message| message.write(part));
        }
        let shares = if T::DOUBLE { 0 } else { 4 * groups(M) * share_slots(&layout) };
        let shares = parts.iter().map(|_| Slices::zeroed([shares])).collect();
        Fused {
            arch,
            layout,
            parts,
            messages,
            units,
            stepping,
            iterations_made: 0,
            face_positions: Vec::new(),
            u,
            u_read_at: usize::MAX,
            q: q.unwrap_or_default(),
            bounds: Vec::new(),
            shares,
            lambda: problem.lambda,
            relaxation: problem.relaxation,
        }
    }
}

/// The number of iterations of a pass that fit into the cache. Samples are taken every four, eight or more steps,
/// always a multiple of four unless the user asks for other intervals.
fn depth<T: Real, const M: usize>(layout: &BlockLayout) -> usize {
    let vertex = 3 * M + 1 + 4 * groups(M);
    let face = 2 * 3 + 4 + 2 * M + 3 * 4 * groups(M);
    let block = layout.lanes.width() * size_of::<T>() * (vertex + 2 * face);
    let fitting = CACHE_BYTES as f64 / (layout.lag().max(1.0) * block as f64);
    let depths = [MAX_DEPTH, MAX_DEPTH / 2, MAX_DEPTH / 4];
    depths.into_iter().find(|&depth| depth as f64 <= fitting).unwrap_or(1)
}

/// Units that bring the numbers near 1 in single precision; 1 in double precision.
fn units<T: Real>(stencil: &Stencil, steps: &Steps) -> Units {
    if T::DOUBLE {
        return Units { q: 1.0, k: 1.0 };
    }
    let inverse = |x: f64| if x.is_normal() { (-x.log2().floor()).exp2() } else { 1.0 };
    let largest = max(stencil.corners().len(), |j| {
        let [c1, c2, c3] = stencil.weights()[j];
        c1.max(c2.abs()).max(c3)
    });
    Units { q: inverse(steps.dual_scale()), k: inverse(largest) }
}

impl<T: Real, const M: usize> Solver<Stencil, M> for Fused<T, M> {
    fn advance(
        &mut self,
        problem: &Problem<Stencil, M>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64 {
        self.lambda = problem.lambda;
        let depth = self.parts[0].window.depth() as u64;
        let (mut made, mut last) = (0, false);
        while !last {
            let going = go_on();
            let iterations = if going { depth.min(steps - made) } else { 1 };
            made += iterations;
            last = !going || made == steps;
            self.pass(iterations as usize, last);
        }
        self.stepping.count(made);
        if self.stepping.is_due() {
            self.unpack();
            if self.stepping.rebalance(problem, Iterate { u: &self.u, q: &self.q }) {
                self.set_steps(problem);
            }
        }
        made
    }

    fn iterate(&mut self) -> Iterate<'_, M> {
        self.unpack()
    }

    fn labels(&mut self) -> &[Row<M>] {
        self.unpack_u();
        &self.u
    }

    fn dual_bound(&mut self, problem: &Problem<Stencil, M>) -> f64 {
        if self.iterations_made == 0 && self.q.is_empty() {
            // K^T q = 0.
            return sum(
                self.u.len(),
                #[inline(always)]
                |v| problem.f[v].min(),
            );
        }
        let Self { arch, layout, parts, units, bounds, shares, u, .. } = self;
        let (arch, layout, units, order) = (*arch, &*layout, *units, &lane_order::<f64>(*arch)[..]);
        bounds.resize(u.len(), 0.0);
        let mut rest = &mut bounds[..];
        let mut tasks = Vec::with_capacity(parts.len());
        for (part, shares) in parts.iter().zip(shares) {
            let (bounds, others) = rest.split_at_mut(part.own().len());
            tasks.push((part, shares, bounds));
            rest = others;
        }
        each(tasks, &|(part, shares, bounds)| {
            if T::DOUBLE {
                arch.dispatch(KnownBounds { part, bounds });
            } else {
                arch.dispatch(Bounds {
                    part,
                    layout,
                    problem,
                    units,
                    order,
                    shares: shares.all()[0],
                    bounds,
                });
            }
        });
        sum(
            bounds.len(),
            #[inline(always)]
            |v| bounds[v],
        )
    }

    fn change(&mut self) -> f64 {
        let changes = self.parts.iter().map(|part| part.change);
        changes.fold(0.0, |largest, change| if change > largest { change } else { largest })
    }

    fn restart(&mut self, problem: &Problem<Stencil, M>) {
        self.unpack();
        self.stepping.restart(problem, Iterate { u: &self.u, q: &self.q });
        self.set_costs(problem);
        self.set_steps(problem);
    }

    fn follow(&mut self, problem: &Problem<Stencil, M>) {
        self.set_costs(problem);
        if self.stepping.follow(problem) {
            self.set_steps(problem);
        }
    }
}

impl<T: Real, const M: usize> Fused<T, M> {
    fn set_costs(&mut self, problem: &Problem<Stencil, M>) {
        self.lambda = problem.lambda;
        let units = self.units;
        each(self.parts.iter_mut().collect(), &|part| part.set_f(&problem.f, units));
    }

    /// One pass of at most as many iterations as its depth; `last` is whether the last one has rho = 1.
    fn pass(&mut self, iterations: usize, last: bool) {
        let before = self.iterations_made;
        self.iterations_made += iterations;
        let ball = Ball::new(self.relaxation, self.lambda * self.units.q);
        let Self { arch, layout, parts, messages, stepping, .. } = self;
        let (arch, layout, rho) = (*arch, &*layout, stepping.rho);
        messages.swap(0, 1);
        let [sent, received] = messages;
        each(parts.iter_mut().zip(sent).enumerate().collect(), &|(k, (part, sent))| {
            for message in received.iter().flatten().filter(|message| message.to == k) {
                message.read(part);
            }
            arch.dispatch(Pass::<T, M> { part, layout, ball, rho, before, iterations, last });
            for message in sent {
                message.write(part);
            }
        });
    }

    fn set_steps(&mut self, problem: &Problem<Stencil, M>) {
        let Self { parts, units, stepping, .. } = self;
        each(parts.iter_mut().collect(), &|part| {
            part.set_steps(&stepping.steps, problem.k.weights(), *units);
        });
    }

    /// Reads u in the order of the mesh, made feasible in double precision.
    fn unpack_u(&mut self) {
        if self.u_read_at == self.iterations_made {
            return;
        }
        self.u_read_at = self.iterations_made;
        let Self { parts, u, .. } = self;
        let ends = parts.iter().map(|part| part.own().end);
        let cuts: Vec<usize> = [0].into_iter().chain(ends).collect();
        sweep_parts(
            u,
            &cuts,
            #[inline(always)]
            |first, u| {
                owner(parts, first).read_u(u);
                if !T::DOUBLE {
                    for row in u {
                        // A projection would give mass to padding regions too.
                        *row = *row * (1.0 / row.0.iter().sum::<f64>());
                    }
                }
            },
        );
    }

    /// Reads q in the order of the mesh, made feasible in double precision.
    fn unpack_q(&mut self) {
        let Self { layout, parts, units, face_positions, q, lambda, relaxation, .. } = self;
        if face_positions.is_empty() {
            face_positions.resize(layout.faces.len(), 0);
            for (i, &j) in layout.faces.iter().enumerate() {
                face_positions[j as usize] = i as u32;
            }
        }
        q.resize(face_positions.len(), Tangent::ZERO);
        let owner = |i: u32| {
            let block = layout.lanes.block(i as usize).0;
            &parts[parts.partition_point(|part| part.window.own_faces.end <= block)]
        };
        with_set!(*relaxation, set => sweep(
            (&mut q[..], &face_positions[..]),
            #[inline(always)]
            |_, (q, &i)| {
                let tangent = owner(i).q_at(i as usize, *units);
                *q = if T::DOUBLE { tangent } else { set.project(tangent, *lambda) };
            },
        ));
    }

    fn unpack(&mut self) -> Iterate<'_, M> {
        self.unpack_u();
        self.unpack_q();
        Iterate { u: &self.u, q: &self.q }
    }
}

/// The part that owns vertex v.
fn owner<T: Real>(parts: &[Part<T>], v: usize) -> &Part<T> {
    &parts[parts.partition_point(|part| part.own().end <= v)]
}
