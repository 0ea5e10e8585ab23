//! The nodes that evolve: all of them, or those of a narrow band, as intervals of each row.

use crate::Field;
use std::ops::Range;

/// Gaps up to this many nodes are filled: short rows cost more than the nodes between.
const GAP: usize = 8;

/// The active intervals of every row. Adalsteinsson & Sethian 1995: the band
/// stays as it was laid until the caller redistances.
#[derive(Clone, Debug)]
pub(super) struct Band {
    intervals: Vec<Range<usize>>,
    /// Where the intervals of each row start in `intervals`, one more than rows.
    offsets: Vec<usize>,
}

impl Band {
    /// The nodes with |phi| < width.
    pub(super) fn lay(phi: &Field, width: f64) -> Self {
        let nx = phi.grid().shape()[2];
        let mut band = Self { intervals: Vec::new(), offsets: vec![0] };
        for row in phi.as_slice().chunks_exact(nx) {
            let start = band.intervals.len();
            for (i, _) in row.iter().enumerate().filter(|(_, v)| v.abs() < width) {
                match band.intervals[start..].last_mut() {
                    Some(last) if i <= last.end + GAP => last.end = i + 1,
                    _ => band.intervals.push(i..i + 1),
                }
            }
            band.offsets.push(band.intervals.len());
        }
        band
    }

    /// The active intervals of a row.
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &[Range<usize>] {
        &self.intervals[self.offsets[row]..self.offsets[row + 1]]
    }

    /// All rows with their intervals.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, &[Range<usize>])> {
        (0..self.offsets.len() - 1).map(|row| (row, self.row(row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Grid;

    #[test]
    fn intervals_cover_the_band_and_join_across_short_gaps() {
        let grid = Grid::new(&[2, 64], 1.0).unwrap();
        let phi =
            Field::from_fn(grid, |[x, y, _]| if y > 0.0 { 9.0 } else { (x - 32.0).abs() - 20.0 });
        let band = Band::lay(&phi, 3.0);
        assert_eq!(band.row(0), [10..15, 50..55]);
        assert!(band.row(1).is_empty());
        assert_eq!(Band::lay(&phi, 17.0).row(0), std::slice::from_ref(&(0..64)));
    }
}
