//! The arrays of what one thread holds, in the order of `layout`.
//!
//! Vertices and faces are stored in blocks of as many as a vector has lanes: u, f and K^T q as `[block][region][lane]`,
//! q as `[block][axis][region][lane]`. Two arrays are stored in groups of [`GROUP`] regions: u_bar, which faces gather
//! from vertices, and the faces' shares of K^T q, which vertices gather from faces.

use std::ops::Range;

use super::buffer::Slices;
use super::lanes::Real;
use super::layout::{BlockLayout, GROUP, Lanes, Window, all_within};
use crate::field::{Row, Tangent};
use crate::solver::chambolle_pock::steps::Steps;

/// The number of groups of m regions.
pub const fn groups(m: usize) -> usize {
    m.div_ceil(GROUP)
}

/// The number of shares that one iteration has room for, for each group of regions: a ring of blocks, followed by a
/// block of zeros.
pub fn share_slots(layout: &BlockLayout) -> usize {
    (3 * layout.ring_length + 1) * layout.lanes.width()
}

pub struct Part<T> {
    pub window: Window,
    pub lanes: Lanes,
    /// The vertices that are held.
    held: Range<usize>,
    /// The number of regions.
    pub m: usize,
    /// The memory of [`Arrays`], in that order.
    arrays: Slices<T, 8>,
    /// max |x - u| of the last step.
    pub change: f64,
}

// The indices of u, K^T q, f and q among the [`Arrays`].
const U: usize = 2;
const KQ: usize = 3;
const F: usize = 4;
const Q: usize = 7;

/// The arrays of a part.
pub struct Arrays<'a, T> {
    /// `[slot][region]`, with zeros up to a whole number of groups.
    pub u_bar: &'a mut [T],
    /// The shares of K^T q of each iteration of a pass, as long as they are needed:
    /// `[iteration][group][block of the ring][corner][position]`, with zeros at the end of each `[group]`.
    pub shares: &'a mut [T],
    pub u: &'a mut [T],
    pub kq: &'a mut [T],
    pub f: &'a mut [T],
    pub tau: &'a mut [T],
    /// c1, c2, c3, sigma: `[block][weight][lane]`.
    pub weights: &'a mut [T],
    pub q: &'a mut [T],
}

/// Powers of two that scale q and K, and therefore f and the steps, to numbers near 1.
#[derive(Clone, Copy)]
pub struct Units {
    pub q: f64,
    pub k: f64,
}

impl<T: Real> Part<T> {
    /// For m regions, on a mesh with the given number of vertices.
    pub fn new(window: Window, layout: &BlockLayout, vertices: usize, m: usize) -> Self {
        let lanes = layout.lanes.clone();
        let width = lanes.width();
        let blocks = window.held_vertices();
        let (slots, faces) = (blocks.len() * width, window.faces.len());
        // The pass relies on this: bounds checks of all gathers would cost a tenth of a step.
        assert!(all_within(&window.corner_offsets, slots));
        assert!(window.share_offsets.all_within(share_slots(layout)));
        Part {
            held: blocks.start * width..vertices.min(blocks.end * width),
            m,
            arrays: Slices::zeroed([
                slots * groups(m) * GROUP,
                window.depth() * groups(m) * share_slots(layout) * GROUP,
                slots * m,
                slots * m,
                slots * m,
                slots,
                faces * 4,
                faces * 2 * m,
            ]),
            change: 0.0,
            lanes,
            window,
        }
    }

    /// The arrays, and what describes their order.
    pub fn arrays(&mut self) -> (Arrays<'_, T>, &Window, &Lanes) {
        let [u_bar, shares, u, kq, f, tau, weights, q] = self.arrays.all();
        (Arrays { u_bar, shares, u, kq, f, tau, weights, q }, &self.window, &self.lanes)
    }

    pub fn u(&self) -> &[T] {
        self.arrays.get(U)
    }

    /// K^T q.
    pub fn kq(&self) -> &[T] {
        self.arrays.get(KQ)
    }

    pub fn f(&self) -> &[T] {
        self.arrays.get(F)
    }

    pub fn q(&self) -> &[T] {
        self.arrays.get(Q)
    }

    /// The vertices that this part owns.
    pub fn own(&self) -> Range<usize> {
        let width = self.lanes.width();
        let Range { start, end } = self.window.own;
        start * width..self.held.end.min(end * width)
    }

    pub fn set_u<const M: usize>(&mut self, u: &[Row<M>]) {
        let held = self.held.clone();
        let (Arrays { u: buffer, tau, .. }, _, lanes) = self.arrays();
        for (slot, u) in u[held.clone()].iter().enumerate() {
            put(buffer, lanes, slot, u.0, 1.0);
        }
        // The padding of a block does not move in any step, and so stays in this corner of the simplex.
        for slot in held.len()..tau.len() {
            buffer[lanes.first(slot, M)] = T::from_f64(1.0);
        }
    }

    pub fn set_f<const M: usize>(&mut self, f: &[Row<M>], units: Units) {
        let held = self.held.clone();
        let (arrays, _, lanes) = self.arrays();
        for (slot, f) in f[held].iter().enumerate() {
            put(arrays.f, lanes, slot, f.0, units.q * units.k);
        }
    }

    /// tau, and c1, c2, c3 with sigma.
    pub fn set_steps(&mut self, steps: &Steps, weights: &[[f64; 3]], units: Units) {
        let held = self.held.clone();
        let (arrays, window, lanes) = self.arrays();
        for (slot, &tau) in steps.tau[held].iter().enumerate() {
            put(arrays.tau, lanes, slot, [tau], 1.0 / (units.q * units.k));
        }
        window.each_face(|i, j| {
            let [c1, c2, c3] = weights[j].map(|c| c * units.k);
            let sigma = steps.sigma[j] * (units.q / units.k);
            put(arrays.weights, lanes, i, [c1, c2, c3, sigma], 1.0);
        });
    }

    /// q on every face, and K^T q at every vertex.
    pub fn set_q<const M: usize>(&mut self, q: &[Tangent<M>], kq: &[Row<M>], units: Units) {
        let held = self.held.clone();
        let (arrays, window, lanes) = self.arrays();
        for (slot, kq) in kq[held].iter().enumerate() {
            put(arrays.kq, lanes, slot, kq.0, units.q * units.k);
        }
        window.each_face(|i, j| {
            let first = lanes.first(i, 2 * M);
            for (axis, row) in q[j].0.iter().enumerate() {
                for (p, &entry) in row.0.iter().enumerate() {
                    let index = first + (axis * M + p) * lanes.width();
                    arrays.q[index] = T::from_f64(entry * units.q);
                }
            }
        });
    }

    /// Writes u of the own vertices to `rows`.
    #[inline(always)]
    pub fn read_u<const M: usize>(&self, rows: &mut [Row<M>]) {
        let width = self.lanes.width();
        let blocks =
            self.u()[self.vertex_slots(&self.window.own).start * M..].chunks_exact(M * width);
        for (rows, block) in rows.chunks_mut(width).zip(blocks) {
            for (row, &lane) in rows.iter_mut().zip(&self.lanes.order) {
                *row = Row::from_fn(|p| block[p * width + lane].to_f64());
            }
        }
    }

    /// q of the own face at position i in the order of all faces.
    #[inline(always)]
    pub fn q_at<const M: usize>(&self, i: usize, units: Units) -> Tangent<M> {
        let width = self.lanes.width();
        let first = self.lanes.first(i - self.window.held_faces.start * width, 2 * M);
        let q = self.q();
        let row = |axis: usize| Row::from_fn(|p| q[first + (axis * M + p) * width].to_f64());
        Tangent([row(0), row(1)]) * (1.0 / units.q)
    }

    /// The slots of blocks of vertices that are held.
    pub fn vertex_slots(&self, blocks: &Range<usize>) -> Range<usize> {
        self.slots(blocks, self.window.held_vertices().start)
    }

    /// The slots of blocks of faces that are held.
    pub fn face_slots(&self, blocks: &Range<usize>) -> Range<usize> {
        self.slots(blocks, self.window.held_faces.start)
    }

    fn slots(&self, blocks: &Range<usize>, first: usize) -> Range<usize> {
        if blocks.is_empty() {
            return 0..0;
        }
        let width = self.lanes.width();
        (blocks.start - first) * width..(blocks.end - first) * width
    }
}

/// Writes the entries of the i-th vertex or face, times `unit`, to an array of blocks.
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
