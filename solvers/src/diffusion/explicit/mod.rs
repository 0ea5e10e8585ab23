//! Forward Euler steps `u += dt (f(u, x) + D lap u)`, several steps per pass through memory.
//!
//! | symbol | code      | meaning                                    | unit          |
//! |--------|-----------|--------------------------------------------|---------------|
//! | u      | `u`       | concentrations, one per species            | any           |
//! | f      | `rates`   | reaction, per cell                         | of u / time   |
//! | D      | `diffusion` | diffusion coefficient of a species       | length^2/time |
//! | dt     | `dt`      | time step                                  | time          |
//!
//! The state is stored row by row and, within a row, species by species: each
//! species' row is contiguous (one vector load serves one species), and a band
//! of rows of all species is one slice that a thread can own. Every row carries
//! one ghost cell at each end, and is filled up so that the first cell of each row
//! starts a cache line and the last is in a whole chunk (`stencil.rs`). What the
//! filling computes is never read by a cell.
//!
//! [`Explicit`] asks its [`Kernel`] for one row at a time, and orders the rows so
//! that several steps are done while they are in the cache (`sweep.rs`). A row's
//! value depends only on rows of the step before, so any order gives the same bytes.

mod buffer;
mod cell;
mod real;
mod stencil;
mod sweep;

#[cfg(test)]
mod tests;

pub use cell::{Cell, CellKernel, CellReaction, Parameter};
pub use real::Real;
pub use stencil::Stencil;

use buffer::Buffer;

use crate::{Boundary, Error, Field, Grid, Result};

/// Most steps that one pass through memory makes: at 1024 columns of two 8-byte
/// species, six rows of each step are 1 MB of level-2 cache. Measured there, 8, 12
/// and 16 steps are within a tenth of each other, 4 is a sixth slower.
const DEPTH: usize = 12;

/// Fewest cells that are worth a second thread: below, waking it costs more than it does.
const SERIAL_CELLS: usize = 1 << 15;

/// One explicit update, a row at a time.
pub trait Kernel<T: Real>: Sync {
    /// Number of species.
    fn species(&self) -> usize;

    /// Sweeps that make one time step, 1 unless a step has stages.
    fn phases(&self) -> usize {
        1
    }

    /// Length of the work space that [`Kernel::row`] wants, for rows of `nx` cells.
    fn scratch(&self, _nx: usize) -> usize {
        0
    }

    /// Writes the next values of one row of all species to `out`; `first` is the
    /// flat index of the row's first node. `out` is laid out as [`Rows::center`]
    /// is, its ghost cells are filled by the caller. Mark it `#[inline(always)]`:
    /// only then is it compiled for the machine's vector unit.
    fn row(&self, phase: usize, first: usize, rows: &Rows<'_, T>, out: &mut [T], scratch: &mut [T]);
}

/// A row of all species and the rows around it. Species `s` of a row stands at
/// `[s * stride..][..stride]`: ghost cell, `cells` cells, ghost cell, filling.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, T> {
    /// Cells of a row.
    pub cells: usize,
    /// Length of one species' row in memory.
    pub stride: usize,
    /// Ghost cells at either end: 1, but as a number of the run, not of the program. Of
    /// a known distance the compiler loads each vector once and shifts it for its two
    /// neighbours, in the unit that also adds; reading it three times is faster.
    pub ghost: usize,
    /// The row itself.
    pub center: &'a [T],
    /// Row `j - 1`.
    pub north: &'a [T],
    /// Row `j + 1`.
    pub south: &'a [T],
    /// Row `j` of plane `k - 1`.
    pub front: &'a [T],
    /// Row `j` of plane `k + 1`.
    pub back: &'a [T],
}

/// A state and the explicit stepper that advances it.
#[derive(Clone, Debug)]
pub struct Explicit<T: Real, K> {
    grid: Grid,
    boundary: Boundary,
    kernel: K,
    depth: usize,
    stride: usize,
    /// See [`Rows::ghost`].
    ghost: usize,
    current: Buffer<T>,
    next: Buffer<T>,
    rings: Vec<Buffer<T>>,
}

impl<T: Real, K: Kernel<T>> Explicit<T, K> {
    /// All concentrations 0 on `grid`; `boundary` is Neumann (mirror) or periodic.
    ///
    /// # Errors
    /// For another boundary.
    pub fn new(grid: Grid, boundary: Boundary, kernel: K) -> Result<Self> {
        if boundary == Boundary::Extrapolate {
            return Err(Error::Invalid(
                "explicit diffusion needs a neumann or periodic boundary, found extrapolate".into(),
            ));
        }
        let stride = stencil::stride(grid.shape()[2]);
        let count = grid.len() / grid.shape()[2] * kernel.species() * stride;
        Ok(Self {
            grid,
            boundary,
            kernel,
            depth: DEPTH,
            stride,
            ghost: 1,
            current: Buffer::new(count),
            next: Buffer::new(count),
            rings: Vec::new(),
        })
    }

    /// Bytes that a state of `species` species of `T` takes on `grid`.
    pub fn bytes(grid: Grid, species: usize) -> u64 {
        2 * (grid.len() * species * size_of::<T>()) as u64
    }

    /// Lets one pass through memory make `depth` sweeps, at least 1; the result is the same.
    #[must_use]
    pub fn with_depth(mut self, depth: usize) -> Self {
        self.depth = depth.max(1);
        self
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The kernel.
    pub fn kernel(&self) -> &K {
        &self.kernel
    }

    /// The kernel, to change its parameters between steps.
    pub fn kernel_mut(&mut self) -> &mut K {
        &mut self.kernel
    }

    /// Does `steps` time steps; in parallel when the grid is large enough.
    pub fn advance(&mut self, steps: u64) {
        let phases = self.kernel.phases();
        let mut left = steps * phases as u64;
        let mut phase = 0;
        while left > 0 {
            let levels = left.min(self.depth as u64) as usize;
            let done = self.pass(phase, levels);
            std::mem::swap(&mut self.current, &mut self.next);
            phase = (phase + done) % phases;
            left -= done as u64;
        }
    }

    /// Sets the concentration of one species.
    ///
    /// # Panics
    /// If the number of values is not that of the grid's nodes.
    pub fn set(&mut self, species: usize, values: &[T]) {
        assert_eq!(values.len(), self.grid.len(), "one value per node");
        let (nx, stride, all) = (self.grid.shape()[2], self.stride, self.kernel.species());
        let rows = self.current.as_mut_slice().chunks_exact_mut(stride).skip(species).step_by(all);
        for (row, values) in rows.zip(values.chunks_exact(nx)) {
            row[1..=nx].copy_from_slice(values);
            sweep::fill_ghosts(self.boundary, row, stride, nx);
        }
    }

    /// Rows of one species, in order, `nx` cells each.
    pub fn rows(&self, species: usize) -> impl Iterator<Item = &[T]> {
        let nx = self.grid.shape()[2];
        let rows = self.current.as_slice().chunks_exact(self.stride).skip(species);
        rows.step_by(self.kernel.species()).map(move |row| &row[1..=nx])
    }

    /// Copies the concentration of one species into `field`.
    ///
    /// # Panics
    /// If `field` has another number of nodes.
    pub fn copy_into(&self, species: usize, field: &mut Field) {
        assert_eq!(field.as_slice().len(), self.grid.len(), "one value per node");
        let nx = self.grid.shape()[2];
        for (row, target) in self.rows(species).zip(field.as_mut_slice().chunks_exact_mut(nx)) {
            for (value, target) in row.iter().zip(target) {
                *target = value.to_f64();
            }
        }
    }

    /// The concentration of one species.
    pub fn values(&self, species: usize) -> Vec<T> {
        self.rows(species).flatten().copied().collect()
    }
}
