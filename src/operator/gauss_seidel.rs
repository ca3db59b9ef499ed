//! One symmetric Gauss-Seidel sweep, over-relaxed (SSOR), as an approximate inverse that is never below the
//! matrix.
//!
//! The vertices are cut into parts of consecutive ones, which threads share; what couples two parts moves to
//! the diagonal:
//!
//! ```text
//! T = L + diag(T) + L^T + O        L inside the parts, O between them
//! C = diag(T) + sum_w |O_vw|       C - diag(T) >= O, being diagonally dominant
//! M = w / (2 - w) (L + C/w) C^-1 (L^T + C/w)
//!   = L + C + L^T + w / (2 - w) (L + (1 - 1/w) C) C^-1 (L^T + (1 - 1/w) C) >= T,   0 < w < 2
//! ```
//!
//! With one part and w = 1 it is the sweep of the textbooks. The parts depend on the size of T only, and so
//! does the result. It is the better the more neighbors of a vertex have numbers close to its own.

use sprs::CsMat;

use crate::field::Row;
use crate::sweep::{parts, sweep_parts};

pub struct GaussSeidel {
    /// Vertices in a part.
    length: usize,
    /// w / C_v.
    inverse: Vec<f64>,
    /// w C^-1 L.
    before: Triangle,
    /// w C^-1 L^T.
    after: Triangle,
}

/// Rows of a strict triangle, the neighbor in the order of the sweep last: it is what a row waits for.
struct Triangle {
    start: Vec<u32>,
    entries: Vec<Entry>,
}

#[derive(Clone, Copy)]
struct Entry {
    /// Counted within the part.
    vertex: u32,
    value: f64,
}

impl Triangle {
    fn new(rows: impl Iterator<Item = Vec<Entry>>) -> Self {
        let (mut start, mut entries) = (vec![0], Vec::new());
        for row in rows {
            entries.extend(row);
            start.push(entries.len() as u32);
        }
        Triangle { start, entries }
    }

    #[inline(always)]
    fn row(&self, v: usize) -> &[Entry] {
        &self.entries[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

/// Into so many parts a matrix is cut, but into none smaller than [`SMALLEST`]. On 100,000 vertices 32 parts cost
/// a tenth more steps of `solver/douglas_rachford.rs` than 8.
const PARTS: usize = 8;
const SMALLEST: usize = 1024;

/// w.
const RELAXATION: f64 = 1.3;

impl GaussSeidel {
    /// For a symmetric positive definite matrix in compressed rows.
    pub fn new(t: &CsMat<f64>) -> Self {
        let length = t.rows().div_ceil(PARTS).max(SMALLEST);
        let row = |v: usize| t.outer_view(v).expect("v is a row of the matrix");
        let together = |v: usize, w: usize| v / length == w / length;
        let inverse: Vec<f64> = (0..t.rows())
            .map(|v| {
                let on_diagonal = |&(w, &value): &(usize, &f64)| {
                    if w == v {
                        value
                    } else if together(v, w) {
                        0.0
                    } else {
                        value.abs()
                    }
                };
                RELAXATION / row(v).iter().map(|entry| on_diagonal(&entry)).sum::<f64>()
            })
            .collect();
        let triangle = |v: usize, inside: &dyn Fn(usize) -> bool| -> Vec<Entry> {
            row(v)
                .iter()
                .filter(|&(w, _)| together(v, w) && inside(w))
                .map(|(w, value)| Entry { vertex: (w % length) as u32, value: inverse[v] * value })
                .collect()
        };
        GaussSeidel {
            length,
            before: Triangle::new((0..t.rows()).map(|v| triangle(v, &|w| w < v))),
            after: Triangle::new((0..t.rows()).map(|v| {
                let mut row = triangle(v, &|w| w > v);
                row.reverse();
                row
            })),
            inverse,
        }
    }

    /// x = M^-1 r.
    #[inline(always)]
    pub fn solve<const M: usize>(&self, x: &mut [Row<M>], r: impl Fn(usize) -> Row<M> + Sync) {
        // x <- (L + C/w)^-1 r
        sweep_parts(
            parts(x, self.length),
            #[inline(always)]
            |part, x| {
                let first = part * self.length;
                for v in 0..x.len() {
                    let mut x_v = r(first + v) * self.inverse[first + v];
                    for entry in self.before.row(first + v) {
                        x_v = x_v - x[entry.vertex as usize] * entry.value;
                    }
                    x[v] = x_v;
                }
            },
        );
        // x <- (L^T + C/w)^-1 (2 - w) / w C x
        sweep_parts(
            parts(x, self.length),
            #[inline(always)]
            |part, x| {
                let first = part * self.length;
                for v in (0..x.len()).rev() {
                    let mut x_v = x[v] * (2.0 - RELAXATION);
                    for entry in self.after.row(first + v) {
                        x_v = x_v - x[entry.vertex as usize] * entry.value;
                    }
                    x[v] = x_v;
                }
            },
        );
    }
}
