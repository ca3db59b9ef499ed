//! The numbers of what one thread owns, in the places of `layout`.
//!
//! Vertices and faces lie in blocks of as many as a vector has lanes, u, f and K^T q as `[block][region][lane]`, q as
//! `[block][axis][region][lane]`. What faces gather from vertices, u_bar, and vertices from faces, their shares of
//! K^T q, lies in rows of four regions.

use std::ops::Range;

use super::buffer::Slices;
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
    /// In the order of [`Numbers`].
    numbers: Slices<T, 8>,
    /// max |x - u| of the last step.
    pub change: f64,
}

/// Where u, K^T q, f and q come among the [`Numbers`].
const U: usize = 2;
const KQ: usize = 3;
const F: usize = 4;
const Q: usize = 7;

/// All numbers of a part.
pub struct Numbers<'a, T> {
    /// `[vertex][group]` in rows.
    pub u_bar: &'a mut [T],
    /// Of each iteration of a pass, as long as they are needed: `[group][block of the ring][corner][row]`, zeros behind
    /// each group.
    pub shares: &'a mut [T],
    pub u: &'a mut [T],
    pub kq: &'a mut [T],
    pub f: &'a mut [T],
    pub tau: &'a mut [T],
    /// c1, c2, c3, sigma: `[block][weight][lane]`.
    pub weights: &'a mut [T],
    pub q: &'a mut [T],
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
            numbers: Slices::zeroed([
                room * groups(m) * ROW,
                window.depth() * groups(m) * share_rows(layout) * ROW,
                room * m,
                room * m,
                room * m,
                room,
                faces * 4,
                faces * 2 * m,
            ]),
            change: 0.0,
            lanes,
            window,
        }
    }

    /// What it computes with, and where that lies.
    pub fn numbers(&mut self) -> (Numbers<'_, T>, &Window, &Lanes) {
        let [u_bar, shares, u, kq, f, tau, weights, q] = self.numbers.all();
        (Numbers { u_bar, shares, u, kq, f, tau, weights, q }, &self.window, &self.lanes)
    }

    pub fn u(&self) -> &[T] {
        self.numbers.get(U)
    }

    /// K^T q.
    pub fn kq(&self) -> &[T] {
        self.numbers.get(KQ)
    }

    pub fn f(&self) -> &[T] {
        self.numbers.get(F)
    }

    pub fn q(&self) -> &[T] {
        self.numbers.get(Q)
    }

    /// The vertices that this part owns.
    pub fn own(&self) -> Range<usize> {
        let width = self.lanes.width();
        let Range { start, end } = self.window.own;
        start * width..self.range.end.min(end * width)
    }

    pub fn set_u<const M: usize>(&mut self, u: &[Row<M>]) {
        let range = self.range.clone();
        let (Numbers { u: buffer, tau, .. }, _, lanes) = self.numbers();
        for (place, u) in u[range.clone()].iter().enumerate() {
            put(buffer, lanes, place, u.0, 1.0);
        }
        // What fills up a block stays where it is in every step, and so in the corner of the simplex.
        for place in range.len()..tau.len() {
            buffer[lanes.first(place, M)] = T::from_f64(1.0);
        }
    }

    pub fn set_f<const M: usize>(&mut self, f: &[Row<M>], units: Units) {
        let range = self.range.clone();
        let (numbers, _, lanes) = self.numbers();
        for (place, f) in f[range].iter().enumerate() {
            put(numbers.f, lanes, place, f.0, units.q * units.k);
        }
    }

    /// tau, and sigma beside c1, c2, c3.
    pub fn set_steps(&mut self, steps: &Steps, weights: &[[f64; 3]], units: Units) {
        let range = self.range.clone();
        let (numbers, window, lanes) = self.numbers();
        for (place, &tau) in steps.tau[range].iter().enumerate() {
            put(numbers.tau, lanes, place, [tau], 1.0 / (units.q * units.k));
        }
        window.each_face(|i, j| {
            let [c1, c2, c3] = weights[j].map(|c| c * units.k);
            let sigma = steps.sigma[j] * (units.q / units.k);
            put(numbers.weights, lanes, i, [c1, c2, c3, sigma], 1.0);
        });
    }

    /// q on every face, and K^T q at every vertex.
    pub fn set_q<const M: usize>(&mut self, q: &[Tangent<M>], kq: &[Row<M>], units: Units) {
        let range = self.range.clone();
        let (numbers, window, lanes) = self.numbers();
        for (place, kq) in kq[range].iter().enumerate() {
            put(numbers.kq, lanes, place, kq.0, units.q * units.k);
        }
        window.each_face(|i, j| {
            let first = lanes.first(i, 2 * M);
            for (axis, row) in q[j].0.iter().enumerate() {
                for (p, &entry) in row.0.iter().enumerate() {
                    let place = first + (axis * M + p) * lanes.width();
                    numbers.q[place] = T::from_f64(entry * units.q);
                }
            }
        });
    }

    /// u of the own vertices.
    #[inline(always)]
    pub fn read_u<const M: usize>(&self, rows: &mut [Row<M>]) {
        let width = self.lanes.width();
        let blocks = self.u()[self.places(&self.window.own).start * M..].chunks_exact(M * width);
        for (rows, block) in rows.chunks_mut(width).zip(blocks) {
            for (row, &lane) in rows.iter_mut().zip(&self.lanes.order) {
                *row = Row::from_fn(|p| block[p * width + lane].to_f64());
            }
        }
    }

    /// q of an own face, by its number in the order of all.
    #[inline(always)]
    pub fn q_at<const M: usize>(&self, i: usize, units: Units) -> Tangent<M> {
        let width = self.lanes.width();
        let first = self.lanes.first(i - self.window.held_faces.start * width, 2 * M);
        let q = self.q();
        let row = |axis: usize| Row::from_fn(|p| q[first + (axis * M + p) * width].to_f64());
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
fn put<T: Real, const N: usize>(
    buffer: &mut [T],
    lanes: &Lanes,
    i: usize,
    entries: [f64; N],
    unit: f64,
) {
    let (first, width) = (lanes.first(i, N), lanes.width());
    for (p, entry) in entries.into_iter().enumerate() {
        buffer[first + p * width] = T::from_f64(entry * unit);
    }
}
