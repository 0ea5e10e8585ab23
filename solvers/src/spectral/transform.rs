//! Separable real transforms of fields of one to three axes.

use super::lines::{Basis, Buffers, Lines};
use crate::{Boundary, Error, Grid, Result};
use rayon::prelude::*;
use rustfft::FftPlanner;

/// Lines gathered at a time: 16 numbers are two cache lines of the source.
const BLOCK: usize = 16;

/// Real Fourier series of a periodic field, or cosine series of a mirrored one.
///
/// Both turn `n` real numbers into `n` real coefficients, one per product of
/// basis functions of the axes, and both make every operator diagonal that is an
/// even function of each wave number: Laplacians, their discrete stencils, and
/// functions of these. Two real lines share one complex FFT, so the cost is that
/// of a real-to-complex FFT.
///
/// Coefficients are stored in an order that saves transpositions; see
/// [`Transform::map_modes`]. The same bytes result for any number of threads.
/// Across processors they may differ in the last bits, because the FFT uses the
/// widest vector instructions that it finds.
#[derive(Clone, Debug)]
pub struct Transform {
    grid: Grid,
    /// Along z, y, x.
    lines: [Lines; 3],
    work: Vec<f64>,
}

#[derive(Clone, Copy)]
enum Direction {
    Forward,
    Inverse,
}

impl Transform {
    /// Plans the transforms for `grid`: Fourier for [`Boundary::Periodic`], cosine
    /// for [`Boundary::Neumann`].
    ///
    /// # Errors
    /// For [`Boundary::Extrapolate`], which has no such basis.
    pub fn new(grid: Grid, boundary: Boundary) -> Result<Self> {
        let basis = match boundary {
            Boundary::Periodic => Basis::Fourier,
            Boundary::Neumann => Basis::Cosine,
            Boundary::Extrapolate => {
                return Err(Error::Invalid(
                    "a series needs a periodic or Neumann boundary, not extrapolation".into(),
                ));
            }
        };
        let mut planner = FftPlanner::new();
        let lines = grid.shape().map(|n| Lines::new(n, basis, &mut planner));
        let work = if grid.dim() > 1 { vec![0.0; grid.len()] } else { Vec::new() };
        Ok(Self { grid, lines, work })
    }

    /// The grid of the fields.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Coefficients of `u` into `modes`; both have one number per node.
    ///
    /// # Panics
    /// If a length is not the grid's.
    pub fn forward(&mut self, u: &[f64], modes: &mut [f64]) {
        let [nz, ny, nx] = self.grid.shape();
        let [along_z, along_y, along_x] = &self.lines;
        assert_eq!(u.len(), self.grid.len(), "length of a field");
        match self.grid.dim() {
            1 => {
                modes.copy_from_slice(u);
                transform_lines(along_x, Direction::Forward, modes);
            }
            2 => {
                self.work.copy_from_slice(u);
                transform_lines(along_x, Direction::Forward, &mut self.work);
                turn(along_y, Direction::Forward, &self.work, [1, ny, nx], modes);
            }
            _ => {
                modes.copy_from_slice(u);
                transform_lines(along_x, Direction::Forward, modes);
                turn(along_y, Direction::Forward, modes, [nz, ny, nx], &mut self.work);
                turn(along_z, Direction::Forward, &self.work, [nx, nz, ny], modes);
            }
        }
    }

    /// The field with coefficients `modes` into `u`; `modes` is overwritten.
    ///
    /// # Panics
    /// If a length is not the grid's.
    pub fn inverse(&mut self, modes: &mut [f64], u: &mut [f64]) {
        let [nz, ny, nx] = self.grid.shape();
        let [along_z, along_y, along_x] = &self.lines;
        assert_eq!(modes.len(), self.grid.len(), "length of a spectrum");
        match self.grid.dim() {
            1 => {
                u.copy_from_slice(modes);
                transform_lines(along_x, Direction::Inverse, u);
            }
            2 => {
                transform_lines(along_y, Direction::Inverse, modes);
                turn(along_x, Direction::Inverse, modes, [1, nx, ny], u);
            }
            _ => {
                transform_lines(along_z, Direction::Inverse, modes);
                turn(along_y, Direction::Inverse, modes, [1, ny, nx * nz], &mut self.work);
                turn(along_x, Direction::Inverse, &self.work, [1, nx, nz * ny], u);
            }
        }
    }

    /// `f([kx, ky, kz])` of every coefficient, in the order in which they are stored;
    /// wave numbers in 1/length, not negative.
    pub fn map_modes<T: Send>(&self, f: impl Fn([f64; 3]) -> T + Sync) -> Vec<T> {
        let k = [0, 1, 2].map(|axis| self.wavenumbers(2 - axis));
        let at = |index| {
            let [mx, my, mz] = self.mode(index);
            f([k[0][mx], k[1][my], k[2][mz]])
        };
        (0..self.grid.len()).into_par_iter().map(at).collect()
    }

    /// Numbers `[mx, my, mz]` of the basis functions of the coefficient stored at `index`.
    pub(super) fn mode(&self, index: usize) -> [usize; 3] {
        let [nz, ny, nx] = self.grid.shape();
        match self.grid.dim() {
            1 => [index, 0, 0],
            2 => [index / ny, index % ny, 0],
            _ => [index / nz % nx, index / (nz * nx), index % nz],
        }
    }

    /// Where the coefficient of basis functions `[mx, my, mz]` is stored.
    pub(super) fn index(&self, [mx, my, mz]: [usize; 3]) -> usize {
        let [nz, ny, nx] = self.grid.shape();
        match self.grid.dim() {
            1 => mx,
            2 => mx * ny + my,
            _ => (my * nx + mx) * nz + mz,
        }
    }

    /// Square of each coefficient times this is its part of the field's mean square.
    pub(super) fn weights(&self) -> impl Fn([usize; 3]) -> f64 + '_ {
        let n = self.grid.len() as f64;
        let [z, y, x] = &self.lines;
        move |[mx, my, mz]| x.weight(mx) * y.weight(my) * z.weight(mz) / (n * n)
    }

    /// Wave number (1/length) of each basis function along axis 0 (z), 1 (y) or 2 (x).
    fn wavenumbers(&self, axis: usize) -> Vec<f64> {
        let (lines, h) = (&self.lines[axis], self.grid.spacing());
        (0..lines.len()).map(|m| lines.wavenumber(m) / h).collect()
    }
}

/// Transforms the contiguous lines of `data`.
fn transform_lines(lines: &Lines, direction: Direction, data: &mut [f64]) {
    let n = lines.len();
    data.par_chunks_mut(BLOCK * n).for_each_init(
        || lines.buffers(),
        |buffers, block| transform_rows(lines, direction, block, n, buffers),
    );
}

/// Transforms the first `lines.len()` numbers of every row of `stride` numbers, in pairs.
fn transform_rows(
    lines: &Lines,
    direction: Direction,
    rows: &mut [f64],
    stride: usize,
    buffers: &mut Buffers,
) {
    let n = lines.len();
    let mut alone = Vec::new();
    for pair in rows.chunks_mut(2 * stride) {
        let (x, y) = pair.split_at_mut(stride.min(pair.len()));
        // The last row of an odd number is paired with zeros.
        let y = if y.is_empty() {
            alone.resize(n, 0.0);
            &mut alone[..]
        } else {
            &mut y[..n]
        };
        match direction {
            Direction::Forward => lines.forward(&mut x[..n], y, buffers),
            Direction::Inverse => lines.inverse(&mut x[..n], y, buffers),
        }
    }
}

/// Turns `[outer, line, columns]` into `[columns, outer, line]` and transforms along `line`.
fn turn(lines: &Lines, direction: Direction, src: &[f64], shape: [usize; 3], dst: &mut [f64]) {
    let [outer, line, columns] = shape;
    let stride = outer * line;
    dst.par_chunks_mut(BLOCK * stride).enumerate().for_each_init(
        || lines.buffers(),
        |buffers, (block, rows)| {
            let first = block * BLOCK;
            let width = rows.len() / stride;
            for o in 0..outer {
                for m in o * line..(o + 1) * line {
                    let source = &src[m * columns + first..][..width];
                    for (row, &value) in rows.chunks_exact_mut(stride).zip(source) {
                        row[m] = value;
                    }
                }
                transform_rows(lines, direction, &mut rows[o * line..], stride, buffers);
            }
        },
    );
}
