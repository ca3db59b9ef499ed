//! One over-relaxed symmetric Gauss-Seidel sweep (SSOR) as an approximate inverse M^-1 of T, where M is never below T:
//!
//! ```text
//! T = L + C + L^T         C = diag(T)
//! M = w / (2 - w) (L + C/w) C^-1 (L^T + C/w)
//!   = T + w / (2 - w) (L + (1 - 1/w) C) C^-1 (L^T + (1 - 1/w) C) >= T,   0 < w < 2
//! ```
//!
//! Reference: D. M. Young, *Iterative solution of large linear systems*, 1971. L depends on the order of the rows.
//! These are cut into parts of consecutive rows, and coupled parts get different colors: the colors are swept one after
//! the other, the parts of a color in parallel, and the rows of a part in order. The parts, and so the result, depend
//! only on T, not on the number of threads. If neighbors have close indices, two or three colors suffice; in a randomly
//! numbered mesh every part has its own color, and the sweep is as accurate but sequential.

use sprs::CsMat;

use crate::field::Row;
use crate::sweep::sweep_parts;

pub struct GaussSeidel {
    /// The index of row v of T in the order of the sweep.
    index: Vec<u32>,
    /// The row of T at each index of the order.
    order: Vec<u32>,
    colors: Vec<Color>,
    /// w / C.
    inverse: Vec<f64>,
    /// w C^-1 L.
    before: Triangle,
    /// w C^-1 L^T.
    after: Triangle,
}

/// The index range of parts that are not coupled with each other.
struct Color {
    first: usize,
    /// The beginnings of the parts and the end of the last one, relative to `first`.
    cuts: Vec<usize>,
}

impl Color {
    fn end(&self) -> usize {
        self.first + self.cuts[self.cuts.len() - 1]
    }
}

/// Rows of a strict triangle, each in the order in which its neighbors are computed. Not a sprs matrix, whose columns
/// ascend.
struct Triangle {
    start: Vec<u32>,
    couplings: Vec<Coupling>,
}

/// An off-diagonal entry.
#[derive(Clone, Copy)]
struct Coupling {
    index: u32,
    value: f64,
}

impl Triangle {
    #[inline(always)]
    fn row(&self, index: usize) -> &[Coupling] {
        &self.couplings[self.start[index] as usize..self.start[index + 1] as usize]
    }
}

/// The rows are cut into at most this many parts, each of at least [`MIN_PART_ROWS`] rows.
const MAX_PARTS: usize = 32;
const MIN_PART_ROWS: usize = 256;

/// w. Compared with w = 1, it saves a sixth of the steps of `solver/douglas_rachford.rs`.
const RELAXATION: f64 = 1.3;

impl GaussSeidel {
    /// The sweep for a symmetric positive definite matrix in compressed rows.
    pub fn new(t: &CsMat<f64>) -> Self {
        let (order, colors) = colored(t, t.rows().div_ceil(MAX_PARTS).max(MIN_PART_ROWS));
        let mut index = vec![0; order.len()];
        (0..).zip(&order).for_each(|(i, &v)| index[v as usize] = i);

        let mut triangles = [(); 2].map(|()| Triangle { start: vec![0], couplings: Vec::new() });
        let mut inverse = Vec::with_capacity(order.len());
        for (i, &v) in (0..).zip(&order) {
            let row = t.outer_view(v as usize).expect("v is a row of the matrix");
            let c = row.get(v as usize).expect("the diagonal is positive");
            inverse.push(RELAXATION / c);
            for (later, Triangle { start, couplings }) in triangles.iter_mut().enumerate() {
                let begin = couplings.len();
                let neighbors = row.iter().map(|(w, value)| (index[w], value));
                couplings.extend(
                    neighbors
                        .filter(|&(index, _)| if later == 0 { index < i } else { index > i })
                        .map(|(index, value)| Coupling { index, value: RELAXATION / c * value }),
                );
                couplings[begin..].sort_by_key(|coupling| coupling.index);
                if later == 1 {
                    couplings[begin..].reverse();
                }
                start.push(couplings.len() as u32);
            }
        }
        let [before, after] = triangles;
        GaussSeidel { index, order, colors, inverse, before, after }
    }

    /// x = M^-1 r. r is indexed by the rows of T, x by the order of the sweep: see [`at`](Self::at).
    #[inline(always)]
    pub fn solve<const M: usize>(&self, x: &mut [Row<M>], r: impl Fn(usize) -> Row<M> + Sync) {
        // x <- (L + C/w)^-1 r
        for color in &self.colors {
            let (known, x) = x.split_at_mut(color.first);
            sweep_parts(
                &mut x[..color.end() - color.first],
                &color.cuts,
                #[inline(always)]
                |first, x| {
                    let first = color.first + first;
                    for i in 0..x.len() {
                        let index = first + i;
                        let row = r(self.order[index] as usize) * self.inverse[index];
                        x[i] = row - product(self.before.row(index), (x, first), (known, 0));
                    }
                },
            );
        }
        // x <- (L^T + C/w)^-1 (2 - w) / w C x
        for color in self.colors.iter().rev() {
            let (x, known) = x.split_at_mut(color.end());
            sweep_parts(
                &mut x[color.first..],
                &color.cuts,
                #[inline(always)]
                |first, x| {
                    let first = color.first + first;
                    for i in (0..x.len()).rev() {
                        let row = x[i] * (2.0 - RELAXATION);
                        let couplings = self.after.row(first + i);
                        x[i] = row - product(couplings, (x, first), (known, color.end()));
                    }
                },
            );
        }
    }

    /// Row v of a solution.
    #[inline(always)]
    pub fn at<const M: usize>(&self, x: &[Row<M>], v: usize) -> Row<M> {
        x[self.index[v] as usize]
    }
}

/// The product of a row of a triangle with x. Neighbors are in the same part or in colors that were swept before; each
/// slice comes with its first index.
#[inline(always)]
fn product<const M: usize>(
    couplings: &[Coupling],
    (part, part_first): (&[Row<M>], usize),
    (known, known_first): (&[Row<M>], usize),
) -> Row<M> {
    let mut sum = Row::ZERO;
    for &Coupling { index, value } in couplings {
        let index = index as usize;
        let neighbor = part.get(index.wrapping_sub(part_first));
        sum += *neighbor.unwrap_or_else(|| &known[index - known_first]) * value;
    }
    sum
}

/// The rows in parts of the given length, color by color.
fn colored(t: &CsMat<f64>, length: usize) -> (Vec<u32>, Vec<Color>) {
    // The parts coupled with each part, and its color: the first that no coupled part before it has.
    let mut neighbors = [0_u32; MAX_PARTS];
    t.iter().for_each(|(_, (v, w))| neighbors[v / length] |= 1 << (w / length));
    let mut color_of = [0; MAX_PARTS];
    for part in 0..MAX_PARTS {
        let taken = (0..part)
            .filter(|other| neighbors[part] >> other & 1 == 1)
            .fold(0_u32, |taken, other| taken | 1 << color_of[other]);
        color_of[part] = taken.trailing_ones();
    }
    let (mut order, mut colors) = (Vec::new(), Vec::new());
    let parts = t.rows().div_ceil(length);
    for color in 0..MAX_PARTS as u32 {
        let first = order.len();
        let mut cuts = vec![0];
        for part in (0..parts).filter(|&part| color_of[part] == color) {
            let end = t.rows().min((part + 1) * length);
            order.extend((part * length..end).map(|v| v as u32));
            cuts.push(order.len() - first);
        }
        if cuts.len() > 1 {
            colors.push(Color { first, cuts });
        }
    }
    (order, colors)
}
