//! What one thread owns: a contiguous range of vertices, every face that touches it, and their other vertices.
//!
//! Vertices and faces lie in blocks of as many as a vector has lanes, u and f as `[block][region][lane]`, q as
//! `[block][axis][region][lane]`. What faces gather and scatter, u_bar and K^T q, lies by vertex, four regions
//! of both beside each other. Faces come in the order of their largest vertex, whichever part they lie in.
//!
//! A face between two ranges lies in both parts and is computed in both, from the same numbers. Its vertices
//! outside the range are ghosts: they move as in their own part, once K^T q is fetched from there.

use std::ops::Range;

use pulp::Arch;

use super::buffer::Buffer;
use super::lanes::Real;
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

/// The lane of each row in a block; how many there are is a power of two.
struct Lanes {
    order: Vec<usize>,
    shift: u32,
}

impl Lanes {
    fn new(order: &[usize]) -> Self {
        assert!(order.len().is_power_of_two());
        Lanes { order: order.to_vec(), shift: order.len().trailing_zeros() }
    }

    fn width(&self) -> usize {
        self.order.len()
    }

    /// The block of the i-th row, and its number there.
    #[inline(always)]
    fn block(&self, i: usize) -> (usize, usize) {
        (i >> self.shift, i & (self.order.len() - 1))
    }

    /// Where the first entry of the i-th row lies, if rows have `entries`; the next ones follow at a distance of
    /// the width.
    #[inline(always)]
    fn first(&self, i: usize, entries: usize) -> usize {
        let (block, row) = self.block(i);
        ((block * entries) << self.shift) + self.order[row]
    }
}

pub struct Part<T, const M: usize> {
    pub range: Range<usize>,
    /// Vertices of other parts, ascending; they come before the own ones, in blocks of their own.
    ghosts: Vec<u32>,
    /// Ascending by their largest vertex.
    faces: Vec<u32>,
    lanes: Lanes,
    pub rows: Vec<RowPair<T>>,
    pub u: Buffer<T>,
    pub f: Buffer<T>,
    pub tau: Buffer<T>,
    /// Places of the corners in `rows`, `[block][corner][row]`.
    pub corners: Vec<u32>,
    /// c1, c2, c3, sigma: `[block][weight][lane]`.
    pub weights: Buffer<T>,
    pub q: Buffer<T>,
    /// How many blocks of faces are done after each block of vertices.
    pub faces_due: Vec<u32>,
    /// Own vertices whose K^T q goes to the outbox, as places.
    sent: Vec<u32>,
    /// For each ghost the part that owns it, and where in its outbox it lies.
    sources: Vec<(u32, u32)>,
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
    /// `faces`: all of them, ascending by their largest vertex.
    pub fn new(range: Range<usize>, faces: &[u32], corners: &[[u32; 3]], order: &[usize]) -> Self {
        let width = order.len();
        let is_own = |v: u32| range.contains(&(v as usize));
        let corners_of = |j: &u32| corners[*j as usize];
        let touches = |j: &u32| corners_of(j).into_iter().any(is_own);
        let faces: Vec<u32> = faces.iter().copied().filter(touches).collect();
        let mut ghosts: Vec<u32> =
            faces.iter().flat_map(corners_of).filter(|&v| !is_own(v)).collect();
        ghosts.sort_unstable();
        ghosts.dedup();

        let own_from = ghosts.len().next_multiple_of(width);
        let vertex_blocks = own_from / width + range.len().div_ceil(width);
        let face_blocks = faces.len().div_ceil(width);
        let place = |v: u32| {
            if is_own(v) {
                own_from + v as usize - range.start
            } else {
                ghosts.binary_search(&v).expect("corners outside are ghosts")
            }
        };
        // Faces that only fill up the last block have no weights and lie anywhere.
        let mut corners = vec![0; 3 * width * face_blocks];
        let mut faces_due = vec![0; vertex_blocks];
        let mut last = 0;
        for (block, faces) in faces.chunks(width).enumerate() {
            for (o, j) in faces.iter().enumerate() {
                for (c, v) in corners_of(j).into_iter().enumerate() {
                    let place = place(v);
                    corners[(3 * block + c) * width + o] = place as u32;
                    last = last.max(place / width);
                }
            }
            faces_due[last] = block as u32 + 1;
        }
        let mut due = 0;
        for block in &mut faces_due {
            due = due.max(*block);
            *block = due;
        }
        Part {
            rows: vec![
                RowPair { u_bar: [T::ZERO; 4], kq: [T::ZERO; 4] };
                vertex_blocks * width * groups(M)
            ],
            u: Buffer::zeroed(vertex_blocks * width * M),
            f: Buffer::zeroed(vertex_blocks * width * M),
            tau: Buffer::zeroed(vertex_blocks * width),
            corners,
            weights: Buffer::zeroed(face_blocks * width * 4),
            q: Buffer::zeroed(face_blocks * width * 2 * M),
            faces_due,
            sent: Vec::new(),
            sources: Vec::new(),
            change: 0.0,
            lanes: Lanes::new(order),
            range,
            ghosts,
            faces,
        }
    }
}

impl<T: Real, const M: usize> Part<T, M> {
    /// The place of the first own vertex: ghosts come first, then a block begins.
    pub fn own_from(&self) -> usize {
        self.ghosts.len().next_multiple_of(self.lanes.width())
    }

    /// The place of each vertex.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> + use<T, M> {
        let own_from = self.own_from();
        let ghosts: Vec<u32> = self.ghosts.clone();
        let own = self.range.clone().enumerate().map(move |(i, v)| (own_from + i, v));
        ghosts.into_iter().enumerate().map(|(i, v)| (i, v as usize)).chain(own)
    }

    pub fn set_u(&mut self, u: &[Row<M>]) {
        // What fills up a block stays where it is in every step, and so in the corner of the simplex.
        for place in 0..self.tau.len() {
            put(&mut self.u, &self.lanes, place, Row::<M>::one_hot(0).0);
        }
        self.places().for_each(|(place, v)| put(&mut self.u, &self.lanes, place, u[v].0));
    }

    pub fn set_f(&mut self, f: &[Row<M>], units: Units) {
        self.places().for_each(|(place, v)| {
            put(&mut self.f, &self.lanes, place, (f[v] * (units.q * units.k)).0);
        });
    }

    /// sigma and tau.
    pub fn set_steps(&mut self, steps: &Steps, units: Units) {
        self.places().for_each(|(place, v)| {
            put(&mut self.tau, &self.lanes, place, [steps.tau[v] / (units.q * units.k)]);
        });
        let width = self.lanes.width();
        for (i, &j) in self.faces.iter().enumerate() {
            self.weights[self.lanes.first(i, 4) + 3 * width] =
                T::from_f64(steps.sigma[j as usize] * (units.q / units.k));
        }
    }

    /// c1, c2, c3, before the steps are set.
    pub fn set_weights(&mut self, weights: &[[f64; 3]], units: Units) {
        for (i, &j) in self.faces.iter().enumerate() {
            let [c1, c2, c3] = weights[j as usize].map(|c| c * units.k);
            put(&mut self.weights, &self.lanes, i, [c1, c2, c3, 0.0]);
        }
    }

    /// q, and K^T q at every vertex.
    pub fn set_q(&mut self, q: &[Tangent<M>], kq: impl Fn(usize) -> Row<M>, units: Units) {
        let width = self.lanes.width();
        for (i, &j) in self.faces.iter().enumerate() {
            let first = self.lanes.first(i, 2 * M);
            for (axis, row) in (q[j as usize] * units.q).0.into_iter().enumerate() {
                for (p, &entry) in row.0.iter().enumerate() {
                    self.q[first + (axis * M + p) * width] = T::from_f64(entry);
                }
            }
        }
        for (place, v) in self.places() {
            for (p, &entry) in (kq(v) * (units.q * units.k)).0.iter().enumerate() {
                self.rows[place * groups(M) + p / 4].kq[p % 4] = T::from_f64(entry);
            }
        }
    }

    /// u of an own vertex.
    #[inline(always)]
    pub fn u(&self, v: usize) -> Row<M> {
        let first = self.lanes.first(self.own_from() + v - self.range.start, M);
        Row::from_fn(|p| self.u[first + p * self.lanes.width()].to_f64())
    }

    /// K^T q of an own vertex.
    #[inline(always)]
    pub fn kq(&self, v: usize) -> Row<M> {
        let place = self.own_from() + v - self.range.start;
        Row::from_fn(|p| self.rows[place * groups(M) + p / 4].kq[p % 4].to_f64())
    }

    /// q of the i-th face.
    #[inline(always)]
    pub fn q(&self, i: usize, units: Units) -> Tangent<M> {
        let (first, width) = (self.lanes.first(i, 2 * M), self.lanes.width());
        let row = |axis: usize| Row::from_fn(|p| self.q[first + (axis * M + p) * width].to_f64());
        Tangent([row(0), row(1)]) * (1.0 / units.q)
    }

    /// Ascending by their largest vertex.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// The lane of a row in a block.
    #[inline(always)]
    pub fn lane(&self, row: usize) -> usize {
        self.lanes.order[row]
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
        for (ghost, &(owner, letter)) in self.sources.iter().enumerate() {
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
        for &place in &self.sent {
            let first = place as usize * groups(M);
            outbox.extend(self.rows[first..first + groups(M)].iter().map(|row| row.kq));
        }
    }
}

/// Tells each part which of its vertices the others need, and where they find those of others.
pub fn connect<T: Real, const M: usize>(parts: &mut [Part<T, M>]) {
    for owner in 0..parts.len() {
        let range = parts[owner].range.clone();
        let is_own = |v: &u32| range.contains(&(*v as usize));
        let mut wanted: Vec<u32> =
            parts.iter().flat_map(|part| &part.ghosts).copied().filter(is_own).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let own_from = parts[owner].own_from();
        let place = |&v: &u32| (own_from + v as usize - range.start) as u32;
        parts[owner].sent = wanted.iter().map(place).collect();
        for part in &mut *parts {
            part.sources.resize(part.ghosts.len(), (0, 0));
            for (source, ghost) in part.sources.iter_mut().zip(&part.ghosts) {
                if let Ok(letter) = wanted.binary_search(ghost) {
                    *source = (owner as u32, letter as u32);
                }
            }
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
