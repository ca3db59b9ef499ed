//! Zeroed slices in one piece of memory. Each begins with a line of the cache, so that no vector straddles two; each by
//! itself would be too short for large pages.

use std::ops::Range;

use super::lanes::Real;

/// Bytes, of a cache line and of the widest vectors.
const LINE: usize = 64;

pub struct Slices<T, const N: usize> {
    memory: Vec<T>,
    ranges: [Range<usize>; N],
}

impl<T: Real, const N: usize> Slices<T, N> {
    pub fn zeroed(lengths: [usize; N]) -> Self {
        let line = LINE / size_of::<T>();
        let room: usize = lengths.iter().map(|length| length.next_multiple_of(line)).sum();
        let memory = vec![T::ZERO; room + line];
        let mut end = memory.as_ptr().align_offset(LINE);
        let ranges = lengths.map(|length| {
            let start = end;
            end += length.next_multiple_of(line);
            start..start + length
        });
        Slices { memory, ranges }
    }

    /// The i-th one.
    pub fn get(&self, i: usize) -> &[T] {
        &self.memory[self.ranges[i].clone()]
    }

    /// All of them.
    pub fn all(&mut self) -> [&mut [T]; N] {
        self.memory.get_disjoint_mut(self.ranges.clone()).expect("one lies behind the other")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_begins_with_a_line_and_none_reaches_into_the_next() {
        let lengths = [5, 0, 16, 17, 1];
        let mut slices = Slices::<f32, 5>::zeroed(lengths);
        for (i, slice) in slices.all().into_iter().enumerate() {
            assert_eq!((slice.as_ptr().addr() % LINE, slice.len()), (0, lengths[i]));
            assert!(slice.iter().all(|&x| x == 0.0));
            slice.fill(i as f32);
        }
        assert!((0..5).all(|i| slices.get(i).iter().all(|&x| x == i as f32)));
    }
}
