//! The numbers of what one thread owns, in the places of `layout`.
//!
//! Vertices and faces lie in blocks of as many as a vector has lanes, u and f as `[block][region][lane]`, q as
//! `[block][axis][region][lane]`. What faces gather and scatter, u_bar and K^T q, lies by vertex, four regions
//! of both beside each other.

use super::buffer::Buffer;
use super::lanes::Real;
use super::layout::{Lanes, Layout};
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

pub struct Part<T> {
    pub layout: Layout,
    /// How many numbers a row of u has.
    pub m: usize,
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

impl<T: Real> Part<T> {
    pub fn new(layout: Layout, m: usize) -> Self {
        let (vertices, faces) = layout.room();
        // The pass relies on it: a test of every gather would cost a tenth of a step.
        assert!(layout.corners.iter().all(|&place| (place as usize) < vertices));
        Part {
            m,
            rows: vec![RowPair { u_bar: [T::ZERO; 4], kq: [T::ZERO; 4] }; vertices * groups(m)]
                .into_boxed_slice(),
            u: Buffer::zeroed(vertices * m),
            f: Buffer::zeroed(vertices * m),
            tau: Buffer::zeroed(vertices),
            weights: Buffer::zeroed(faces * 4),
            q: Buffer::zeroed(faces * 2 * m),
            change: 0.0,
            layout,
        }
    }

    pub fn set_u<'a>(&mut self, u: &dyn Fn(usize) -> &'a [f64]) {
        let Part { layout, u: buffer, .. } = self;
        layout.each_place(|place, v| put(buffer, &layout.lanes, place, u(v), 1.0));
        // What fills up a block stays where it is in every step, and so in the corner of the simplex.
        layout.each_gap(|place| buffer[layout.lanes.first(place, self.m)] = T::from_f64(1.0));
    }

    pub fn set_f<'a>(&mut self, f: &dyn Fn(usize) -> &'a [f64], units: Units) {
        let Part { layout, f: buffer, .. } = self;
        let unit = units.q * units.k;
        layout.each_place(|place, v| put(buffer, &layout.lanes, place, f(v), unit));
    }

    /// sigma and tau.
    pub fn set_steps(&mut self, steps: &Steps, units: Units) {
        let Part { layout, tau, weights, .. } = self;
        let unit = 1.0 / (units.q * units.k);
        layout.each_place(|place, v| put(tau, &layout.lanes, place, &[steps.tau[v]], unit));
        let width = layout.lanes.width();
        let unit = units.q / units.k;
        for (i, &j) in layout.faces.iter().enumerate() {
            weights[layout.lanes.first(i, 4) + 3 * width] =
                T::from_f64(steps.sigma[j as usize] * unit);
        }
    }

    /// c1, c2, c3, before the steps are set.
    pub fn set_weights(&mut self, weights: &[[f64; 3]], units: Units) {
        let Part { layout, weights: buffer, .. } = self;
        for (i, &j) in layout.faces.iter().enumerate() {
            let [c1, c2, c3] = weights[j as usize];
            put(buffer, &layout.lanes, i, &[c1, c2, c3, 0.0], units.k);
        }
    }

    /// The two rows of q on every face, and K^T q at every vertex.
    pub fn set_q<'a>(
        &mut self,
        q: &dyn Fn(usize) -> [&'a [f64]; 2],
        kq: &dyn Fn(usize) -> &'a [f64],
        units: Units,
    ) {
        let Part { layout, m, q: buffer, rows, .. } = self;
        let width = layout.lanes.width();
        for (i, &j) in layout.faces.iter().enumerate() {
            let first = layout.lanes.first(i, 2 * *m);
            for (axis, row) in q(j as usize).into_iter().enumerate() {
                for (p, &entry) in row.iter().enumerate() {
                    buffer[first + (axis * *m + p) * width] = T::from_f64(entry * units.q);
                }
            }
        }
        layout.each_place(|place, v| {
            for (p, &entry) in kq(v).iter().enumerate() {
                rows[place * groups(*m) + p / 4].kq[p % 4] =
                    T::from_f64(entry * (units.q * units.k));
            }
        });
    }

    /// u of the own vertices.
    #[inline(always)]
    pub fn read_u<const M: usize>(&self, rows: &mut [Row<M>]) {
        let Layout { lanes, .. } = &self.layout;
        let width = lanes.width();
        let blocks = self.u[self.layout.own_from() * M..].chunks_exact(M * width);
        for (rows, block) in rows.chunks_mut(width).zip(blocks) {
            for (row, &lane) in rows.iter_mut().zip(&lanes.order) {
                *row = Row::from_fn(|p| block[p * width + lane].to_f64());
            }
        }
    }

    /// K^T q of an own vertex.
    #[inline(always)]
    pub fn kq<const M: usize>(&self, v: usize) -> Row<M> {
        let place = self.layout.place(v);
        Row::from_fn(|p| self.rows[place * groups(M) + p / 4].kq[p % 4].to_f64())
    }

    /// q of the i-th face.
    #[inline(always)]
    pub fn q<const M: usize>(&self, i: usize, units: Units) -> Tangent<M> {
        let (first, width) = (self.layout.lanes.first(i, 2 * M), self.layout.lanes.width());
        let row = |axis: usize| Row::from_fn(|p| self.q[first + (axis * M + p) * width].to_f64());
        Tangent([row(0), row(1)]) * (1.0 / units.q)
    }

    /// K^T q of the ghosts, as their owners sent it.
    pub fn receive(&mut self, received: &[Outbox<T>]) {
        let groups = groups(self.m);
        for (ghost, &(owner, letter)) in self.layout.sources.iter().enumerate() {
            for g in 0..groups {
                self.rows[ghost * groups + g].kq =
                    received[owner as usize][letter as usize * groups + g];
            }
        }
    }

    /// K^T q as others will need it.
    pub fn post(&self, outbox: &mut Outbox<T>) {
        let groups = groups(self.m);
        outbox.clear();
        for &place in &self.layout.sent {
            let first = place as usize * groups;
            outbox.extend(self.rows[first..first + groups].iter().map(|row| row.kq));
        }
    }
}

/// The entries of the i-th of many in units of their own, a block after the other.
#[inline(always)]
fn put<T: Real>(buffer: &mut [T], lanes: &Lanes, i: usize, entries: &[f64], unit: f64) {
    let (first, width) = (lanes.first(i, entries.len()), lanes.width());
    for (p, &entry) in entries.iter().enumerate() {
        buffer[first + p * width] = T::from_f64(entry * unit);
    }
}
