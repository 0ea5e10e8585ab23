//! Bands of rows, each worked on by one thread.

use std::ops::Range;

/// Fewest places of a vector that are worth a second thread: a pass takes about 10
/// microseconds then, which is what waking a thread costs.
const SERIAL: usize = 1 << 14;

/// Bands for each thread: one may be held up by another program, and its other band is
/// then taken by the other thread.
const PER_THREAD: usize = 2;

/// Rows cut into bands of equal size. A row's values never depend on the cut, and sums
/// are kept per row, so that results are the same bytes for any number of threads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bands {
    pub count: usize,
    /// Rows of a band, but for the last, which may be shorter.
    pub rows: usize,
    total: usize,
}

impl Bands {
    /// Bands of whole multiples of `unit` rows for `total` rows of `row_len` numbers.
    pub(super) fn new(total: usize, unit: usize, row_len: usize) -> Self {
        let threads = rayon::current_num_threads();
        let wanted =
            if threads == 1 || total * row_len < SERIAL { 1 } else { PER_THREAD * threads };
        let units = total / unit;
        let rows = units.div_ceil(wanted) * unit;
        Self { count: total.div_ceil(rows), rows, total }
    }

    /// The rows of a band.
    pub(super) fn range(&self, band: usize) -> Range<usize> {
        band * self.rows..((band + 1) * self.rows).min(self.total)
    }

    /// A vector of `row_len` numbers per row, to be cut into bands.
    pub(super) fn part<'a, T>(&self, data: &'a mut [T], row_len: usize) -> Part<'a, T> {
        Part { data, per_band: self.rows * row_len }
    }

    /// Calls `run(band, parts of the band)` for all bands, on all threads.
    pub(super) fn each<P: Split>(&self, parts: P, run: impl Fn(usize, P) + Sync) {
        each(0..self.count, parts, &run);
    }
}

fn each<P: Split>(bands: Range<usize>, parts: P, run: &(impl Fn(usize, P) + Sync)) {
    if bands.len() <= 1 {
        return run(bands.start, parts);
    }
    let middle = bands.start.midpoint(bands.end);
    let (left, right) = parts.split(middle - bands.start);
    rayon::join(|| each(bands.start..middle, left, run), || each(middle..bands.end, right, run));
}

/// Something that can be cut between two bands.
pub(super) trait Split: Sized + Send {
    /// The first `bands` bands, and the rest.
    fn split(self, bands: usize) -> (Self, Self);
}

/// A slice with the same number of items for each band.
pub(super) struct Part<'a, T> {
    pub data: &'a mut [T],
    per_band: usize,
}

impl<'a, T> Part<'a, T> {
    /// One item per band: work space.
    pub(super) fn one_each(data: &'a mut [T]) -> Self {
        Self { data, per_band: 1 }
    }
}

impl<T: Send> Split for Part<'_, T> {
    fn split(self, bands: usize) -> (Self, Self) {
        let at = (bands * self.per_band).min(self.data.len());
        let (left, right) = self.data.split_at_mut(at);
        let part = |data| Self { data, per_band: self.per_band };
        (part(left), part(right))
    }
}

impl<A: Split, B: Split> Split for (A, B) {
    fn split(self, bands: usize) -> (Self, Self) {
        let (a, b) = (self.0.split(bands), self.1.split(bands));
        ((a.0, b.0), (a.1, b.1))
    }
}

impl<A: Split, B: Split, C: Split> Split for (A, B, C) {
    fn split(self, bands: usize) -> (Self, Self) {
        let (a, b, c) = (self.0.split(bands), self.1.split(bands), self.2.split(bands));
        ((a.0, b.0, c.0), (a.1, b.1, c.1))
    }
}

impl<A: Split, B: Split, C: Split, D: Split> Split for (A, B, C, D) {
    fn split(self, bands: usize) -> (Self, Self) {
        let (left, right) = ((self.0, self.1), (self.2, self.3)).split(bands);
        ((left.0.0, left.0.1, left.1.0, left.1.1), (right.0.0, right.0.1, right.1.0, right.1.1))
    }
}
