//! The shares of the vertices of a coarse mesh in the bins: the histogram of the data that a vertex stands for.

use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;

/// A sparse matrix, one row per vertex, with row sums 1; a vertex without weight has an empty row.
#[derive(Clone)]
pub struct Shares {
    first: Vec<usize>,
    bins: Vec<u16>,
    shares: Vec<f64>,
}

impl Shares {
    fn with_rows(rows: usize) -> Self {
        let mut first = Vec::with_capacity(rows + 1);
        first.push(0);
        Shares { first, bins: Vec::new(), shares: Vec::new() }
    }

    /// The bins of vertex k, and its share in each.
    #[inline(always)]
    pub fn at(&self, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.first[k]..self.first[k + 1];
        let pairs = self.bins[range.clone()].iter().zip(&self.shares[range]);
        pairs.map(|(&b, &share)| (b as usize, share))
    }

    fn push_row(&mut self, row: impl Iterator<Item = (usize, f64)>) {
        for (b, share) in row {
            self.bins.push(b as u16);
            self.shares.push(share);
        }
        self.first.push(self.bins.len());
    }

    /// The same rows in the given order.
    pub fn in_order(&self, order: &Order) -> Self {
        let vertices = order.vertices().unwrap_or_default();
        let mut moved = Shares::with_rows(vertices.len());
        vertices.iter().for_each(|&k| moved.push_row(self.at(k as usize)));
        moved
    }

    /// P^T (w shares) / P^T w over the fine vertices with w > 0; `each(v, add)` calls `add(b, share)` for the bins of
    /// fine vertex v.
    pub fn restricted(
        level: &Coarsening,
        weights: &[f64],
        bins: usize,
        each: impl Fn(usize, &mut dyn FnMut(usize, f64)),
    ) -> Self {
        let mut children: Vec<Vec<(usize, f64)>> = vec![Vec::new(); level.mesh.vertices.len()];
        for (v, parents) in level.parents.iter().enumerate() {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                if share * weights[v] > 0.0 {
                    children[c as usize].push((v, share * weights[v]));
                }
            }
        }
        let mut coarse = Shares::with_rows(children.len());
        let mut sums = vec![0.0; bins];
        for children in &children {
            let mut used = Vec::new();
            for &(v, w) in children {
                each(v, &mut |b, share| {
                    if sums[b] == 0.0 && w * share > 0.0 {
                        used.push(b);
                    }
                    sums[b] += w * share;
                });
            }
            used.sort_unstable();
            let total: f64 = children.iter().map(|(_, w)| w).sum();
            coarse.push_row(used.iter().map(|&b| (b, std::mem::take(&mut sums[b]) / total)));
        }
        coarse
    }
}
