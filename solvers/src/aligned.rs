//! Buffers that start where the widest vector does.

use std::ops::{Deref, DerefMut};

/// Bytes: a cache line, and the widest vector. A vector that straddles two lines takes two
/// loads, which halves the speed of stencils.
const BYTES: usize = 64;

/// Numbers of a fixed count, the first at the start of a cache line.
#[derive(Debug, Default)]
pub struct Aligned<T> {
    store: Vec<T>,
    first: usize,
    len: usize,
}

impl<T: Copy> Aligned<T> {
    /// `len` times `value`.
    #[must_use]
    pub fn new(len: usize, value: T) -> Self {
        let spare = BYTES / size_of::<T>().max(1);
        let store = vec![value; len + spare];
        let first = store.as_ptr().align_offset(BYTES).min(spare);
        Self { store, first, len }
    }
}

impl<T: Copy + Default> From<&[T]> for Aligned<T> {
    fn from(values: &[T]) -> Self {
        let mut copy = Self::new(values.len(), T::default());
        copy.copy_from_slice(values);
        copy
    }
}

impl<T: Clone> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        let spare = self.store.len() - self.len;
        let mut store: Vec<T> = Vec::with_capacity(self.store.len());
        let first = store.as_ptr().align_offset(BYTES).min(spare);
        store.extend_from_slice(&self.store[..first]);
        store.extend_from_slice(self);
        store.extend_from_slice(&self.store[..spare - first]);
        Self { store, first, len: self.len }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.store[self.first..][..self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.store[self.first..][..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_and_their_copies_start_a_line() {
        for len in [0, 1, 100] {
            let mut buffer = Aligned::new(len, 1.0_f32);
            buffer.fill(2.0);
            for copy in [buffer.clone().clone(), Aligned::from(&buffer[..])] {
                assert_eq!(copy.as_ptr().align_offset(BYTES), 0);
                assert_eq!(&copy[..], vec![2.0; len]);
            }
        }
    }
}
