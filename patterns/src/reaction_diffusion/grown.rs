//! Explicit kernels on a domain that grows.

use super::stepper::Stretch;
use solvers::Grid;
use solvers::diffusion::explicit::{Cell, CellKernel, Kernel, Real, Rows};

/// A kernel whose Laplacian can be changed between steps.
pub(super) trait Stretchable {
    /// Multiplies the Laplacian of the start by `factor`; `diffusion` is that of the start
    /// (cells^2/time), one number per species.
    fn scale_laplacian(&mut self, grid: Grid, diffusion: &[f64], factor: f64);
}

impl<T: Real, C: Cell<S, P>, const S: usize, const P: usize> Stretchable
    for CellKernel<T, C, S, P>
{
    fn scale_laplacian(&mut self, grid: Grid, diffusion: &[f64], factor: f64) {
        self.set_diffusion(grid, std::array::from_fn(|s| diffusion[s] * factor));
    }
}

/// A kernel, and the dilution of all concentrations after each of its steps.
///
/// The one that all explicit runs have, whether they grow or not, so that each kernel is
/// compiled once.
#[derive(Clone, Debug)]
pub(super) struct Grown<T, K> {
    kernel: K,
    diffusion: Vec<f64>,
    dilution: T,
}

impl<T: Real, K: Stretchable> Grown<T, K> {
    pub(super) fn new(kernel: K, diffusion: &[f64]) -> Self {
        Self { kernel, diffusion: diffusion.to_vec(), dilution: T::from_f64(1.0) }
    }

    pub(super) fn stretch(&mut self, grid: Grid, stretch: Stretch) {
        self.kernel.scale_laplacian(grid, &self.diffusion, stretch.laplacian);
        self.dilution = T::from_f64(stretch.dilution);
    }
}

impl<T: Real, K: Kernel<T>> Kernel<T> for Grown<T, K> {
    fn species(&self) -> usize {
        self.kernel.species()
    }

    fn phases(&self) -> usize {
        self.kernel.phases()
    }

    fn scratch(&self, nx: usize) -> usize {
        self.kernel.scratch(nx)
    }

    #[inline(always)]
    fn row(&self, phase: usize, first: usize, rows: &Rows<'_, T>, out: &mut [T], work: &mut [T]) {
        self.kernel.row(phase, first, rows, out, work);
        if self.dilution != T::from_f64(1.0) && phase + 1 == self.kernel.phases() {
            out.iter_mut().for_each(|value| *value = *value * self.dilution);
        }
    }
}
