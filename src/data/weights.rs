//! The masses of the regions at the vertices, for any number of regions.

use pulp::bytemuck::TransparentWrapper;

use crate::field::Row;

/// M U: V rows, whose entry p is the mass of region p at vertex k. Padding regions have mass 0.
#[derive(Clone, Copy)]
pub struct Weights<'a> {
    /// Row by row.
    numbers: &'a [f64],
    /// Length of a row.
    length: usize,
}

impl<'a> Weights<'a> {
    /// The masses in these rows.
    pub fn of<const M: usize>(rows: &'a [Row<M>]) -> Self {
        Weights { numbers: Row::peel_slice(rows).as_flattened(), length: M }
    }

    /// The masses of m regions, V x m numbers row by row.
    pub fn new(numbers: &'a [f64], m: usize) -> Self {
        assert!(m > 0 && numbers.len().is_multiple_of(m));
        Weights { numbers, length: m }
    }

    /// V.
    pub fn vertices(&self) -> usize {
        self.numbers.len() / self.length
    }

    /// The masses of all regions at vertex k.
    #[inline(always)]
    pub fn at(&self, k: usize) -> &'a [f64] {
        &self.numbers[k * self.length..][..self.length]
    }
}
