//! Zeroed slices in one piece of memory. Each starts at a cache line, so that no vector straddles two lines. Separate
//! allocations would be too short for large pages.

use std::ops::Range;

use super::lanes::Real;

/// The size of a cache line, and of the widest vectors.
const CACHE_LINE_BYTES: usize = 64;

pub struct Slices<T, const N: usize> {
    memory: Vec<T>,
    ranges: [Range<usize>; N],
}

impl<T: Real, const N: usize> Slices<T, N> {
    pub fn zeroed(lengths: [usize; N]) -> Self {
        let line = CACHE_LINE_BYTES / size_of::<T>();
        let total: usize = lengths.iter().map(|length| length.next_multiple_of(line)).sum();
        let memory = vec![T::ZERO; total + line];
        let mut end = memory.as_ptr().align_offset(CACHE_LINE_BYTES);
        let ranges = lengths.map(|length| {
            let start = end;
            end += length.next_multiple_of(line);
            start..start + length
        });
        Slices { memory, ranges }
    }

    /// The i-th slice.
    pub fn get(&self, i: usize) -> &[T] {
        &self.memory[self.ranges[i].clone()]
    }

    /// All slices.
    pub fn all(&mut self) -> [&mut [T]; N] {
        self.memory.get_disjoint_mut(self.ranges.clone()).expect("the ranges are disjoint")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_start_at_cache_lines_and_do_not_overlap() {
        let lengths = [5, 0, 16, 17, 1];
        let mut slices = Slices::<f32, 5>::zeroed(lengths);
        for (i, slice) in slices.all().into_iter().enumerate() {
            assert_eq!((slice.as_ptr().addr() % CACHE_LINE_BYTES, slice.len()), (0, lengths[i]));
            assert!(slice.iter().all(|&x| x == 0.0));
            slice.fill(i as f32);
        }
        assert!((0..5).all(|i| slices.get(i).iter().all(|&x| x == i as f32)));
    }
}
