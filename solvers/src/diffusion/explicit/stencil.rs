//! The stencils, a chunk of cells at a time.

use super::{Real, Rows};
use crate::Grid;
use serde::{Deserialize, Serialize};

/// Cells that are computed together: one vector of 4-byte numbers or two of 8 in the
/// widest unit. A constant, so that no loop has a remainder; rows are filled up to whole
/// chunks. With 32, the sums of 8-byte numbers no longer fit the 32 registers.
pub(super) const CHUNK: usize = 16;

/// Length of a row of `cells` cells: whole chunks, and one more for the ghost cells, so
/// that rows are whole cache lines apart.
pub(super) fn stride(cells: usize) -> usize {
    cells.next_multiple_of(CHUNK) + CHUNK
}

/// Differences that stand for the Laplacian (spacing h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stencil {
    /// 2D (and 1D): `(4 (W + E + N + S) + corners - 20 C) / (6 h^2)`; isotropic to
    /// fourth order, largest symbol 16/3 h^-2.
    NinePoint,
    /// Second differences along each axis: 3, 5 or 7 points, largest symbol `4 dim h^-2`.
    Axes,
}

impl Stencil {
    /// Largest value of the symbol of `-laplacian` on `grid` (1/length^2).
    pub fn max_symbol(self, grid: Grid) -> f64 {
        let unit = match self {
            // On one axis the nine points are the three of `Axes`; on two the symbol
            // is largest at the checkerboard, (4 * 4 - 4 + 20) / 6.
            Self::NinePoint if grid.shape()[1] > 1 => 16.0 / 3.0,
            _ => 4.0 * grid.shape().iter().filter(|&&n| n > 1).count() as f64,
        };
        unit / grid.spacing().powi(2)
    }

    /// What the sum of [`Stencil::sum_row`] is to be multiplied with for a Laplacian (1/length^2).
    pub fn scale(self, grid: Grid) -> f64 {
        let unit = if self == Self::NinePoint { 6.0 } else { 1.0 };
        1.0 / (unit * grid.spacing().powi(2))
    }

    /// Integer-weighted sum of the stencil over a row of one species, one value per cell.
    #[inline(always)]
    pub fn sum_row<T: Real>(
        self,
        volumetric: bool,
        species: usize,
        rows: &Rows<'_, T>,
        out: &mut [T],
    ) {
        let near = Chunks::around(rows, species, rows.cells.div_ceil(CHUNK));
        for (j, out) in out[..rows.cells].chunks_mut(CHUNK).enumerate() {
            let values = match (volumetric, self) {
                (true, _) => sum::<T, 7>(&near, j),
                (_, Self::NinePoint) => sum::<T, 9>(&near, j),
                (_, Self::Axes) => sum::<T, 5>(&near, j),
            };
            let cells = out.len();
            out.copy_from_slice(&values[..cells]);
        }
    }
}

/// The chunks of a row of one species, and their neighbours along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunks<'a, T> {
    west: &'a [[T; CHUNK]],
    pub(super) here: &'a [[T; CHUNK]],
    east: &'a [[T; CHUNK]],
}

impl<T> Default for Chunks<'_, T> {
    #[inline(always)]
    fn default() -> Self {
        Self { west: &[], here: &[], east: &[] }
    }
}

impl<'a, T: Real> Chunks<'a, T> {
    /// `count` chunks of row `j` of a species, and those of the rows around it: rows
    /// j, j - 1, j + 1, of plane k - 1, of plane k + 1.
    #[inline(always)]
    pub(super) fn around(rows: &Rows<'a, T>, species: usize, count: usize) -> [Self; 5] {
        let mut near = [Self::default(); 5];
        let all = [rows.center, rows.north, rows.south, rows.front, rows.back];
        for (near, row) in near.iter_mut().zip(all) {
            let row = &row[species * rows.stride..][..rows.stride];
            *near = Self {
                west: &row.as_chunks().0[..count],
                here: &row[rows.ghost..].as_chunks().0[..count],
                east: &row[2 * rows.ghost..].as_chunks().0[..count],
            };
        }
        near
    }
}

/// Integer-weighted sum of the five-, seven- or nine-point stencil over chunk `j` of
/// the rows of [`Chunks::around`].
///
/// Opposite neighbours are added first: the sums have the symmetries of the square to
/// the last bit, so that mirrored states have mirrored successors.
#[inline(always)]
pub(super) fn sum<T: Real, const POINTS: u8>(near: &[Chunks<'_, T>; 5], j: usize) -> [T; CHUNK] {
    let [four, six, twenty] = [T::from_f64(4.0), T::from_f64(6.0), T::from_f64(20.0)];
    let [row, north, south, front, back] = near;
    let (w, c, e) = (&row.west[j], &row.here[j], &row.east[j]);
    let (nw, n, ne) = (&north.west[j], &north.here[j], &north.east[j]);
    let (sw, s, se) = (&south.west[j], &south.here[j], &south.east[j]);
    let (f, b) = (&front.here[j], &back.here[j]);
    let mut sum = [T::from_f64(0.0); CHUNK];
    for i in 0..CHUNK {
        let edges = (w[i] + e[i]) + (n[i] + s[i]);
        let corners = (nw[i] + se[i]) + (ne[i] + sw[i]);
        sum[i] = match POINTS {
            9 => (four * edges + corners) - twenty * c[i],
            7 => (edges + (f[i] + b[i])) - six * c[i],
            _ => edges - four * c[i],
        };
    }
    sum
}
