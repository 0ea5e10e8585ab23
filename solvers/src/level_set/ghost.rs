//! A field with ghost nodes around it, so that row kernels need no border cases.

use super::rows;
use crate::{Boundary, Grid};
use std::ops::Range;

/// Copy of a field with `ghosts` more nodes at either end of every present axis.
#[derive(Clone, Debug)]
pub(super) struct Padded {
    grid: Grid,
    boundary: Boundary,
    /// Ghost nodes along z, y, x; none along absent axes.
    ghosts: [usize; 3],
    shape: [usize; 3],
    values: Vec<f64>,
}

impl Padded {
    pub(super) fn new(grid: Grid, ghosts: usize, boundary: Boundary) -> Self {
        let ghosts = [0, 1, 2].map(|axis| if axis + grid.dim() >= 3 { ghosts } else { 0 });
        let shape = [0, 1, 2].map(|axis| grid.shape()[axis] + 2 * ghosts[axis]);
        Self { grid, boundary, ghosts, shape, values: vec![0.0; shape.iter().product()] }
    }

    /// Copies `values` (row-major, of the grid) and fills the ghost nodes.
    pub(super) fn load(&mut self, values: &[f64]) {
        let [nz, ny, nx] = self.grid.shape();
        let [gz, gy, gx] = self.ghosts;
        let ([_, my, mx], boundary) = (self.shape, self.boundary);
        rows::for_each(&mut self.values, mx, |first, chunk| {
            for (row, target) in chunk.chunks_exact_mut(mx).enumerate() {
                let (k, j) = ((first + row) / my, (first + row) % my);
                if (gz..gz + nz).contains(&k) && (gy..gy + ny).contains(&j) {
                    let source = ((k - gz) * ny + j - gy) * nx;
                    target[gx..gx + nx].copy_from_slice(&values[source..source + nx]);
                    fill_blocks(target, 1, gx, boundary);
                }
            }
        });
        for slab in self.values.chunks_exact_mut(my * mx).skip(gz).take(nz) {
            fill_blocks(slab, mx, gy, boundary);
        }
        fill_blocks(&mut self.values, my * mx, gz, boundary);
    }

    /// As [`Self::load`] where only the nodes `intervals` of each row have changed.
    pub(super) fn load_intervals<'a>(
        &mut self,
        values: &[f64],
        intervals: impl Iterator<Item = (usize, &'a [Range<usize>])>,
    ) {
        let [_, ny, nx] = self.grid.shape();
        let [gz, gy, gx] = self.ghosts;
        let ([_, my, mx], boundary) = (self.shape, self.boundary);
        for (row, intervals) in intervals.filter(|(_, intervals)| !intervals.is_empty()) {
            let start = ((row / ny + gz) * my + row % ny + gy) * mx;
            let target = &mut self.values[start..start + mx];
            for interval in intervals {
                let source = &values[row * nx + interval.start..row * nx + interval.end];
                target[gx + interval.start..gx + interval.end].copy_from_slice(source);
            }
            fill_blocks(target, 1, gx, boundary);
        }
        let [nz, ..] = self.grid.shape();
        for slab in self.values.chunks_exact_mut(my * mx).skip(gz).take(nz) {
            fill_blocks(slab, mx, gy, boundary);
        }
        fill_blocks(&mut self.values, my * mx, gz, boundary);
    }

    /// The nodes `nodes` of grid row `row = k ny + j`, and their neighbours.
    #[inline(always)]
    pub(super) fn row(&self, row: usize, nodes: Range<usize>) -> Row<'_> {
        let ny = self.grid.shape()[1];
        let ([gz, gy, gx], [_, my, mx]) = (self.ghosts, self.shape);
        let start = ((row / ny + gz) * my + row % ny + gy) * mx + gx + nodes.start;
        Row { values: &self.values, start, strides: [1, mx, my * mx], len: nodes.len() }
    }
}

/// Fills the first and last `ghosts` of equal blocks of `len` values from the blocks between.
fn fill_blocks(values: &mut [f64], len: usize, ghosts: usize, boundary: Boundary) {
    let n = (values.len() / len - 2 * ghosts) as isize;
    for m in 1..=ghosts as isize {
        for outside in [-m, n - 1 + m] {
            let target = (outside + ghosts as isize) as usize * len;
            match boundary {
                Boundary::Neumann | Boundary::Periodic => {
                    let source = (source(boundary, outside, n) + ghosts as isize) as usize * len;
                    values.copy_within(source..source + len, target);
                }
                Boundary::Extrapolate => {
                    let edge = if outside < 0 { 0 } else { n - 1 };
                    let inner = (if outside < 0 { 1 } else { n - 2 }).clamp(0, n - 1);
                    let [edge, inner] = [edge, inner].map(|i| (i + ghosts as isize) as usize * len);
                    for b in 0..len {
                        let slope = values[edge + b] - values[inner + b];
                        values[target + b] = values[edge + b] + m as f64 * slope;
                    }
                }
            }
        }
    }
}

/// The node inside `0..n` that stands for node `i`, however far outside it lies.
fn source(boundary: Boundary, i: isize, n: isize) -> isize {
    match boundary {
        Boundary::Periodic => i.rem_euclid(n),
        // Mirrors at both ends repeat after 2 n nodes.
        _ => {
            let i = i.rem_euclid(2 * n);
            if i < n { i } else { 2 * n - 1 - i }
        }
    }
}

/// Part of a row of a [`Padded`] field with a view of all its neighbours.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    values: &'a [f64],
    start: usize,
    /// Distance in memory between neighbours along x, y, z.
    strides: [usize; 3],
    len: usize,
}

impl<'a> Row<'a> {
    /// Number of nodes.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The neighbours `offset` nodes further along `axis` (0 is x).
    #[inline(always)]
    pub(super) fn along(&self, axis: usize, offset: isize) -> &'a [f64] {
        self.slice(offset * self.strides[axis] as isize)
    }

    /// The neighbours `p` nodes further along `axis` and `q` along `other`.
    #[inline(always)]
    pub(super) fn diagonal(&self, axis: usize, p: isize, other: usize, q: isize) -> &'a [f64] {
        self.slice(p * self.strides[axis] as isize + q * self.strides[other] as isize)
    }

    #[inline(always)]
    fn slice(&self, shift: isize) -> &'a [f64] {
        let start = self.start.wrapping_add_signed(shift);
        &self.values[start..start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Field;

    /// Ghosts of `0 1 2` (or of fewer nodes) two deep, along x.
    fn ghosts(n: usize, boundary: Boundary) -> Vec<f64> {
        let field = Field::from_fn(Grid::new(&[n], 1.0).unwrap(), |[x, _, _]| x);
        let mut padded = Padded::new(field.grid(), 2, boundary);
        padded.load(field.as_slice());
        padded.values
    }

    #[test]
    fn borders_mirror_repeat_and_continue() {
        assert_eq!(ghosts(3, Boundary::Neumann), [1.0, 0.0, 0.0, 1.0, 2.0, 2.0, 1.0]);
        assert_eq!(ghosts(3, Boundary::Periodic), [1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0]);
        assert_eq!(ghosts(3, Boundary::Extrapolate), [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(ghosts(1, Boundary::Neumann), [0.0; 5]);
        assert_eq!(ghosts(1, Boundary::Extrapolate), [0.0; 5]);
    }

    #[test]
    fn rows_see_their_neighbours_across_corners() {
        let grid = Grid::new(&[3, 4, 5], 1.0).unwrap();
        let field = Field::from_fn(grid, |[x, y, z]| x + 10.0 * y + 100.0 * z);
        let mut padded = Padded::new(grid, 1, Boundary::Extrapolate);
        padded.load(field.as_slice());
        // Row (k, j) = (2, 0): linear continuation is exact for a linear field.
        let row = padded.row(8, 1..5);
        assert_eq!(row.along(0, 1), [202.0, 203.0, 204.0, 205.0]);
        assert_eq!(row.diagonal(1, -1, 2, 1), [291.0, 292.0, 293.0, 294.0]);
    }

    #[test]
    fn changed_intervals_refresh_their_ghosts() {
        let grid = Grid::new(&[5, 6], 1.0).unwrap();
        let mut field = Field::from_fn(grid, |[x, y, _]| x * y);
        let mut partly = Padded::new(grid, 3, Boundary::Periodic);
        partly.load(field.as_slice());
        field.as_mut_slice()[5] = -7.0;
        let interval = 4..6;
        let changed = std::iter::once((0, std::slice::from_ref(&interval)));
        partly.load_intervals(field.as_slice(), changed);
        let mut whole = Padded::new(grid, 3, Boundary::Periodic);
        whole.load(field.as_slice());
        assert_eq!(partly.values, whole.values);
    }
}
