//! Several steps per pass: a wavefront over the rows of a band.
//!
//! Row j of sweep t needs rows j - 1, j, j + 1 of sweep t - 1. As soon as sweep 1
//! has done row j, sweep 2 can do row j - 1, sweep 3 row j - 2, and so on: of each
//! sweep between the first and the last only three rows are ever needed, so that
//! they stay in the cache, and memory is read once and written once for all
//! sweeps. Rows are done in groups of four, whose common neighbours are read from
//! the first-level cache; then six rows of a sweep are kept. A band recomputes what
//! it needs of its neighbours' rows (Nguyen et al. 2010, "3.5-D blocking", here in
//! 2D). In 3D a pass is one sweep.

use super::{Buffer, Explicit, Kernel, Real, Rows, SERIAL_CELLS};
use crate::Boundary;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Fewest rows of a band: twelve sweeps then recompute a sixth of it.
const BAND: usize = 64;

/// Rows that a sweep does before the next sweep has its turn: their shared
/// neighbours are then read from the first-level cache.
const GROUP: usize = 4;

/// Rows of a sweep that the next one may still need: a group and one on either side.
const KEPT: usize = GROUP + 2;

/// Puts the boundary's values into the ghost cells of each species of a row.
#[inline(always)]
pub(super) fn fill_ghosts<T: Real>(boundary: Boundary, row: &mut [T], stride: usize, nx: usize) {
    for row in row.chunks_exact_mut(stride) {
        let (first, last) =
            if boundary == Boundary::Periodic { (row[nx], row[1]) } else { (row[1], row[nx]) };
        row[0] = first;
        row[nx + 1] = last;
    }
}

impl<T: Real, K: Kernel<T>> Explicit<T, K> {
    /// Up to `levels` sweeps, the first of them phase `phase`, from `current` to
    /// `next`; returns how many were done.
    pub(super) fn pass(&mut self, phase: usize, levels: usize) -> usize {
        let [nz, ny, nx] = self.grid.shape();
        let levels = if nz > 1 { 1 } else { levels };
        let threads = if self.grid.len() < SERIAL_CELLS { 1 } else { rayon::current_num_threads() };
        let row = self.kernel.species() * self.stride;
        // Two bands per thread even out what the threads are given.
        let band = if threads == 1 { nz * ny } else { (nz * ny).div_ceil(2 * threads).max(BAND) };
        let ring = KEPT * row * (levels - 1) + self.kernel.scratch(nx);
        let bands = (nz * ny).div_ceil(band);
        if self.rings.len() != bands || self.rings.iter().any(|work| work.len() < ring) {
            self.rings = vec![Buffer::new(ring); bands];
        }
        let (kernel, current) = (&self.kernel, self.current.as_slice());
        let source = Source {
            ghost: self.ghost,
            shape: self.grid.shape(),
            boundary: self.boundary,
            row,
            current,
        };
        let run = |(index, (out, work)): (usize, (&mut [T], &mut Buffer<T>))| {
            let stride = row / kernel.species();
            let (ring, scratch) = work.as_mut_slice().split_at_mut(KEPT * row * (levels - 1));
            let first = index * band;
            let job = Job { kernel, source, stride, phase, levels, first, out, ring, scratch };
            Arch::new().dispatch(job);
        };
        let bands =
            self.next.as_mut_slice().par_chunks_mut(band * row).zip(self.rings.par_iter_mut());
        if threads == 1 {
            let bands = self.next.as_mut_slice().chunks_mut(band * row).zip(self.rings.iter_mut());
            bands.enumerate().for_each(run);
        } else {
            bands.enumerate().for_each(run);
        }
        levels
    }
}

/// The state before the pass.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    ghost: usize,
    shape: [usize; 3],
    boundary: Boundary,
    row: usize,
    current: &'a [T],
}

impl<T> Source<'_, T> {
    /// Row `j` of plane `k`, both inside.
    #[inline(always)]
    fn row(&self, k: usize, j: usize) -> &[T] {
        &self.current[(k * self.shape[1] + j) * self.row..][..self.row]
    }

    /// Row `n`, counted through all planes, and its neighbours.
    #[inline(always)]
    fn around(&self, n: usize, stride: usize) -> Rows<'_, T> {
        let [nz, ny, nx] = self.shape;
        let (k, j) = (n / ny, n % ny);
        let along_y = |step: isize| self.row(k, self.boundary.wrap(j as isize + step, ny));
        let along_z = |step: isize| self.row(self.boundary.wrap(k as isize + step, nz), j);
        Rows {
            cells: nx,
            stride,
            ghost: self.ghost,
            center: self.row(k, j),
            north: along_y(-1),
            south: along_y(1),
            front: along_z(-1),
            back: along_z(1),
        }
    }

    /// Row `j`, which may lie beyond the border.
    #[inline(always)]
    fn wrapped(&self, j: isize) -> &[T] {
        let ny = self.shape[1] as isize;
        let inside = match self.boundary {
            Boundary::Periodic => j.rem_euclid(ny),
            _ => j.clamp(0, ny - 1),
        };
        self.row(0, inside as usize)
    }
}

/// The sweeps over one band.
struct Job<'a, T, K> {
    kernel: &'a K,
    source: Source<'a, T>,
    stride: usize,
    phase: usize,
    levels: usize,
    /// First row of the band.
    first: usize,
    out: &'a mut [T],
    /// `KEPT` rows of each sweep but the last.
    ring: &'a mut [T],
    scratch: &'a mut [T],
}

impl<T: Real, K: Kernel<T>> NullaryFnOnce for Job<'_, T, K> {
    type Output = ();

    /// `levels` sweeps in 2D; rows are numbered through the periodic border.
    /// In 3D one sweep, over the rows of all planes.
    #[inline(always)]
    fn call(self) {
        let Self { kernel, source, stride, phase, levels, out, ring, scratch, .. } = self;
        let ([nz, ny, nx], row, boundary) = (source.shape, source.row, source.boundary);
        let (start, end) = (self.first as isize, (self.first + out.len() / row) as isize);
        let periodic = boundary == Boundary::Periodic;
        let phases = kernel.phases();
        let volumetric = nz > 1;
        let inside = |j: isize| if periodic { j } else { j.clamp(0, ny as isize - 1) };
        let slot = |j: isize| inside(j).rem_euclid(KEPT as isize) as usize * row;
        let (floor, ceiling) =
            if periodic { (isize::MIN, isize::MAX) } else { (0, (nz * ny) as isize) };
        let reach = levels as isize - 1;
        for front in (start - reach..end + reach).step_by(GROUP) {
            for level in 1..=levels {
                // Sweep `level` needs `margin` rows beyond the band for the sweeps after it.
                let margin = (levels - level) as isize;
                let begin = front - (level as isize - 1);
                let low = begin.max(start - margin).max(floor);
                let high = (begin + GROUP as isize).min(end + margin).min(ceiling);
                for j in low..high {
                    let (below, above) =
                        ring.split_at_mut(KEPT * row * (level - 1).min(levels - 1));
                    let rows = if volumetric {
                        source.around(j as usize, stride)
                    } else {
                        let at = |j: isize| match level {
                            1 => source.wrapped(j),
                            _ => &below[KEPT * row * (level - 2) + slot(j)..][..row],
                        };
                        let (north, center, south) = (at(j - 1), at(j), at(j + 1));
                        Rows {
                            cells: nx,
                            stride,
                            ghost: source.ghost,
                            center,
                            north,
                            south,
                            front: center,
                            back: center,
                        }
                    };
                    let target = if level == levels {
                        &mut out[(j - start) as usize * row..][..row]
                    } else {
                        &mut above[slot(j)..][..row]
                    };
                    let first = j.rem_euclid((nz * ny) as isize) as usize * nx;
                    kernel.row((phase + level - 1) % phases, first, &rows, target, scratch);
                    fill_ghosts(boundary, target, stride, nx);
                }
            }
        }
    }
}
