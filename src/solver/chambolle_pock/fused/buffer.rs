//! A zeroed slice that begins with a line of the cache, so that no vector straddles two.

use std::ops::{Deref, DerefMut};

use super::lanes::Real;

/// Bytes, of a cache line and of the widest vectors.
const LINE: usize = 64;

pub struct Buffer<T> {
    memory: Vec<T>,
    first: usize,
    length: usize,
}

impl<T: Real> Buffer<T> {
    pub fn zeroed(length: usize) -> Self {
        let memory = vec![T::ZERO; length + LINE / size_of::<T>()];
        let first = memory.as_ptr().align_offset(LINE);
        Buffer { memory, first, length }
    }
}

impl<T> Deref for Buffer<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.memory[self.first..self.first + self.length]
    }
}

impl<T> DerefMut for Buffer<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.memory[self.first..self.first + self.length]
    }
}
