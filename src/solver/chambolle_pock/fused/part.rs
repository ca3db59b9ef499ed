//! The numbers of what one thread owns, in the places of `layout`.
//!
//! Vertices and faces lie in blocks of as many as a vector has lanes, u and f as `[block][region][lane]`, q as
//! `[block][axis][region][lane]`. What faces gather and scatter, u_bar and K^T q, lies by vertex, four regions
//! of both beside each other.

use pulp::Arch;

use super::buffer::Buffer;
use super::lanes::Real;
use super::layout::{Lanes, Layout};
use super::pass::Pass;
use crate::field::{Row, Tangent};
use crate::solver::chambolle_pock::steps::Steps;

/// Regions 4g to 4g + 3 at a vertex.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct RowPair<T> {
    pub u_bar: [T; 4],
    pub kq: [T; 4],
}

/// How many pairs a vertex has.
pub const fn groups(m: usize) -> usize {
    m.div_ceil(4)
}

/// K^T q at the vertices that other parts want to know.
pub type Outbox<T> = Vec<[T; 4]>;

pub struct Part<T, const M: usize> {
    pub layout: Layout,
    pub rows: Box<[RowPair<T>]>,
    pub u: Buffer<T>,
    pub f: Buffer<T>,
    pub tau: Buffer<T>,
    /// c1, c2, c3, sigma: `[block][weight][lane]`.
    pub weights: Buffer<T>,
    pub q: Buffer<T>,
    /// max |x - u| of the last step.
    pub change: f64,
}

/// Powers of two that bring the numbers of a problem near 1: q, K and so f and the steps are scaled by them.
#[derive(Clone, Copy)]
pub struct Units {
    pub q: f64,
    pub k: f64,
}

impl<T: Real, const M: usize> Part<T, M> {
    pub fn new(layout: Layout) -> Self {
        let (vertices, faces) = layout.room();
        // The pass relies on it: a test of every gather would cost a tenth of a step.
        assert!(layout.corners.iter().all(|&place| (place as usize) < vertices));
        Part {
            rows: vec![RowPair { u_bar: [T::ZERO; 4], kq: [T::ZERO; 4] }; vertices * groups(M)]
                .into_boxed_slice(),
            u: Buffer::zeroed(vertices * M),
            f: Buffer::zeroed(vertices * M),
            tau: Buffer::zeroed(vertices),
            weights: Buffer::zeroed(faces * 4),
            q: Buffer::zeroed(faces * 2 * M),
            change: 0.0,
            layout,
        }
    }

    pub fn set_u(&mut self, u: &[Row<M>]) {
        // What fills up a block stays where it is in every step, and so in the corner of the simplex.
        for place in 0..self.tau.len() {
            put(&mut self.u, &self.layout.lanes, place, Row::<M>::one_hot(0).0);
        }
        for (place, v) in self.layout.places() {
            put(&mut self.u, &self.layout.lanes, place, u[v].0);
        }
    }

    pub fn set_f(&mut self, f: &[Row<M>], units: Units) {
        for (place, v) in self.layout.places() {
            put(&mut self.f, &self.layout.lanes, place, (f[v] * (units.q * units.k)).0);
        }
    }

    /// sigma and tau.
    pub fn set_steps(&mut self, steps: &Steps, units: Units) {
        for (place, v) in self.layout.places() {
            put(&mut self.tau, &self.layout.lanes, place, [steps.tau[v] / (units.q * units.k)]);
        }
        let width = self.layout.lanes.width();
        for (i, &j) in self.layout.faces.iter().enumerate() {
            self.weights[self.layout.lanes.first(i, 4) + 3 * width] =
                T::from_f64(steps.sigma[j as usize] * (units.q / units.k));
        }
    }

    /// c1, c2, c3, before the steps are set.
    pub fn set_weights(&mut self, weights: &[[f64; 3]], units: Units) {
        for (i, &j) in self.layout.faces.iter().enumerate() {
            let [c1, c2, c3] = weights[j as usize].map(|c| c * units.k);
            put(&mut self.weights, &self.layout.lanes, i, [c1, c2, c3, 0.0]);
        }
    }

    /// q, and K^T q at every vertex.
    pub fn set_q(&mut self, q: &[Tangent<M>], kq: impl Fn(usize) -> Row<M>, units: Units) {
        let width = self.layout.lanes.width();
        for (i, &j) in self.layout.faces.iter().enumerate() {
            let first = self.layout.lanes.first(i, 2 * M);
            for (axis, row) in (q[j as usize] * units.q).0.into_iter().enumerate() {
                for (p, &entry) in row.0.iter().enumerate() {
                    self.q[first + (axis * M + p) * width] = T::from_f64(entry);
                }
            }
        }
        for (place, v) in self.layout.places() {
            for (p, &entry) in (kq(v) * (units.q * units.k)).0.iter().enumerate() {
                self.rows[place * groups(M) + p / 4].kq[p % 4] = T::from_f64(entry);
            }
        }
    }

    /// u of an own vertex.
    #[inline(always)]
    pub fn u(&self, v: usize) -> Row<M> {
        let first = self.layout.lanes.first(self.layout.place(v), M);
        Row::from_fn(|p| self.u[first + p * self.layout.lanes.width()].to_f64())
    }

    /// K^T q of an own vertex.
    #[inline(always)]
    pub fn kq(&self, v: usize) -> Row<M> {
        let place = self.layout.place(v);
        Row::from_fn(|p| self.rows[place * groups(M) + p / 4].kq[p % 4].to_f64())
    }

    /// q of the i-th face.
    #[inline(always)]
    pub fn q(&self, i: usize, units: Units) -> Tangent<M> {
        let (first, width) = (self.layout.lanes.first(i, 2 * M), self.layout.lanes.width());
        let row = |axis: usize| Row::from_fn(|p| self.q[first + (axis * M + p) * width].to_f64());
        Tangent([row(0), row(1)]) * (1.0 / units.q)
    }

    /// One iteration, with K^T q of the ghosts as their owners sent it.
    pub fn advance(
        &mut self,
        arch: Arch,
        received: &[Outbox<T>],
        outbox: &mut Outbox<T>,
        lambda: f64,
        rho: f64,
        land: bool,
    ) {
        for (ghost, &(owner, letter)) in self.layout.sources.iter().enumerate() {
            for g in 0..groups(M) {
                self.rows[ghost * groups(M) + g].kq =
                    received[owner as usize][letter as usize * groups(M) + g];
            }
        }
        arch.dispatch(Pass { part: self, lambda, rho, land });
        self.post(outbox);
    }

    /// K^T q as others will need it.
    pub fn post(&self, outbox: &mut Outbox<T>) {
        outbox.clear();
        for &place in &self.layout.sent {
            let first = place as usize * groups(M);
            outbox.extend(self.rows[first..first + groups(M)].iter().map(|row| row.kq));
        }
    }
}

/// The entries of the i-th of many, a block after the other.
#[inline(always)]
fn put<T: Real, const N: usize>(buffer: &mut [T], lanes: &Lanes, i: usize, entries: [f64; N]) {
    let (first, width) = (lanes.first(i, N), lanes.width());
    for (p, &entry) in entries.iter().enumerate() {
        buffer[first + p * width] = T::from_f64(entry);
    }
}
