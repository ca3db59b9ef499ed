//! The numbers of what one thread owns, in the places of `layout`.
//!
//! Vertices and faces lie in blocks of as many as a vector has lanes, u, f and K^T q as `[block][region][lane]`, q as
//! `[block][axis][region][lane]`. What faces gather from vertices, u_bar, and vertices from faces, their shares of
//! K^T q, lies in rows of four regions.

use std::ops::Range;

use super::buffer::Buffer;
use super::lanes::Real;
use super::layout::{Lanes, Layout, ROW, Window, all_within};
use crate::field::{Row, Tangent};
use crate::solver::chambolle_pock::steps::Steps;

/// How many rows of four regions a vertex has.
pub const fn groups(m: usize) -> usize {
    m.div_ceil(ROW)
}

/// How many rows the shares of one iteration have for each group: a ring of blocks, and behind it zeros.
pub fn share_rows(layout: &Layout) -> usize {
    (3 * layout.ring + 1) * layout.lanes.width()
}

pub struct Part<T> {
    pub window: Window,
    pub lanes: Lanes,
    /// Of the vertices that are held.
    range: Range<usize>,
    /// How many numbers a row of u has.
    pub m: usize,
    /// `[vertex][group]` in rows.
    pub u_bar: Buffer<T>,
    /// Of each iteration of a pass, as long as they are needed: `[group][block of the ring][corner][row]`, zeros behind
    /// each group.
    pub shares: Buffer<T>,
    pub u: Buffer<T>,
    pub kq: Buffer<T>,
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
    /// For rows of m numbers on a mesh of so many vertices.
    pub fn new(window: Window, layout: &Layout, vertices: usize, m: usize) -> Self {
        let lanes = layout.lanes.clone();
        let width = lanes.width();
        let blocks = window.vertices();
        let (room, faces) = (blocks.len() * width, window.faces.len());
        // The pass relies on it: a test of every gather would cost a tenth of a step.
        assert!(all_within(&window.places, room));
        assert!(window.rows_at.all_within(share_rows(layout)));
        Part {
            range: blocks.start * width..vertices.min(blocks.end * width),
            m,
            u_bar: Buffer::zeroed(room * groups(m) * ROW),
            shares: Buffer::zeroed(window.depth() * groups(m) * share_rows(layout) * ROW),
            kq: Buffer::zeroed(room * m),
            u: Buffer::zeroed(room * m),
            f: Buffer::zeroed(room * m),
            tau: Buffer::zeroed(room),
            weights: Buffer::zeroed(faces * 4),
            q: Buffer::zeroed(faces * 2 * m),
            change: 0.0,
            lanes,
            window,
        }
    }

    /// The vertices that this part owns.
    pub fn own(&self) -> Range<usize> {
        let width = self.lanes.width();
        let Range { start, end } = self.window.own;
        start * width..self.range.end.min(end * width)
    }

    /// Every vertex that is held, with its place.
    #[inline(always)]
    fn each_vertex(&self) -> impl Iterator<Item = (usize, usize)> + use<T> {
        self.range.clone().enumerate()
    }

    pub fn set_u<'a>(&mut self, u: &dyn Fn(usize) -> &'a [f64]) {
        for (place, v) in self.each_vertex() {
            put(&mut self.u, &self.lanes, place, u(v), 1.0);
        }
        // What fills up a block stays where it is in every step, and so in the corner of the simplex.
        for place in self.range.len()..self.tau.len() {
            self.u[self.lanes.first(place, self.m)] = T::from_f64(1.0);
        }
    }

    pub fn set_f<'a>(&mut self, f: &dyn Fn(usize) -> &'a [f64], units: Units) {
        let unit = units.q * units.k;
        for (place, v) in self.each_vertex() {
            put(&mut self.f, &self.lanes, place, f(v), unit);
        }
    }

    /// sigma and tau.
    pub fn set_steps(&mut self, steps: &Steps, units: Units) {
        let unit = 1.0 / (units.q * units.k);
        for (place, v) in self.each_vertex() {
            put(&mut self.tau, &self.lanes, place, &[steps.tau[v]], unit);
        }
        let Part { window, lanes, weights, .. } = self;
        let width = lanes.width();
        let unit = units.q / units.k;
        window.each_face(|i, j| {
            weights[lanes.first(i, 4) + 3 * width] = T::from_f64(steps.sigma[j] * unit);
        });
    }

    /// c1, c2, c3, before the steps are set.
    pub fn set_weights(&mut self, weights: &[[f64; 3]], units: Units) {
        let Part { window, lanes, weights: buffer, .. } = self;
        window.each_face(|i, j| {
            let [c1, c2, c3] = weights[j];
            put(buffer, lanes, i, &[c1, c2, c3, 0.0], units.k);
        });
    }

    /// The two rows of q on every face, and K^T q at every vertex.
    pub fn set_q<'a>(
        &mut self,
        q: &dyn Fn(usize) -> [&'a [f64]; 2],
        kq: &dyn Fn(usize) -> &'a [f64],
        units: Units,
    ) {
        for (place, v) in self.each_vertex() {
            put(&mut self.kq, &self.lanes, place, kq(v), units.q * units.k);
        }
        let Part { window, lanes, m, q: buffer, .. } = self;
        let width = lanes.width();
        window.each_face(|i, j| {
            let first = lanes.first(i, 2 * *m);
            for (axis, row) in q(j).into_iter().enumerate() {
                for (p, &entry) in row.iter().enumerate() {
                    buffer[first + (axis * *m + p) * width] = T::from_f64(entry * units.q);
                }
            }
        });
    }

    /// u of the own vertices.
    #[inline(always)]
    pub fn read_u<const M: usize>(&self, rows: &mut [Row<M>]) {
        let width = self.lanes.width();
        let blocks = self.u[self.places(&self.window.own).start * M..].chunks_exact(M * width);
        for (rows, block) in rows.chunks_mut(width).zip(blocks) {
            for (row, &lane) in rows.iter_mut().zip(&self.lanes.order) {
                *row = Row::from_fn(|p| block[p * width + lane].to_f64());
            }
        }
    }

    /// q of an own face, by its number in the order of all.
    #[inline(always)]
    pub fn q<const M: usize>(&self, i: usize, units: Units) -> Tangent<M> {
        let width = self.lanes.width();
        let first = self.lanes.first(i - self.window.held_faces.start * width, 2 * M);
        let row = |axis: usize| Row::from_fn(|p| self.q[first + (axis * M + p) * width].to_f64());
        Tangent([row(0), row(1)]) * (1.0 / units.q)
    }

    /// The places of blocks of vertices that are held.
    pub fn places(&self, blocks: &Range<usize>) -> Range<usize> {
        self.within(blocks, self.window.vertices().start)
    }

    /// The places of blocks of faces that are held.
    pub fn face_places(&self, blocks: &Range<usize>) -> Range<usize> {
        self.within(blocks, self.window.held_faces.start)
    }

    fn within(&self, blocks: &Range<usize>, first: usize) -> Range<usize> {
        if blocks.is_empty() {
            return 0..0;
        }
        let width = self.lanes.width();
        (blocks.start - first) * width..(blocks.end - first) * width
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
