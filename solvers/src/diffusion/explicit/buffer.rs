//! Rows in memory.

use super::Real;

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;

/// Numbers whose second, the first cell of the first row behind its ghost cell,
/// starts a cache line: then neither its vectors nor those of rows a multiple of
/// [`LINE`] further on are read and written in two halves.
#[derive(Debug)]
pub(super) struct Buffer<T> {
    len: usize,
    /// The numbers, from [`Buffer::start`]; `LINE` bytes longer than they are.
    data: Vec<T>,
}

impl<T: Real> Buffer<T> {
    /// `len` zeros.
    pub(super) fn new(len: usize) -> Self {
        Self { len, data: vec![T::from_f64(0.0); len + LINE / size_of::<T>()] }
    }

    fn start(&self) -> usize {
        let line = LINE / size_of::<T>();
        (self.data.as_ptr().align_offset(LINE) + line - 1) % line
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn as_slice(&self) -> &[T] {
        &self.data[self.start()..][..self.len]
    }

    pub(super) fn as_mut_slice(&mut self) -> &mut [T] {
        let start = self.start();
        &mut self.data[start..][..self.len]
    }
}

impl<T: Real> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        // The copy's memory starts elsewhere within its line.
        let mut copy = Self::new(self.len);
        copy.as_mut_slice().copy_from_slice(self.as_slice());
        copy
    }
}
