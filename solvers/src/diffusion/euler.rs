//! Forward Euler with the diffusion of any operator.

use super::rates::{self, combine};
use super::{Diffusivity, Operator, Reaction};
use crate::{Boundary, Grid, Result};

/// `u_s += dt (f_s(u, x) + div(D_s grad u_s))` with maps and tensors of diffusion.
///
/// Stable for `dt <= 2 /` [`Euler::max_rate`] without a reaction. There is no hidden state:
/// a step depends on `u` alone.
#[derive(Clone, Debug)]
pub struct Euler {
    grid: Grid,
    dt: f64,
    laplacian: f64,
    operators: Vec<Operator>,
    rates: Vec<Vec<f64>>,
    spread: Vec<f64>,
}

impl Euler {
    /// A stepper for as many species as there are diffusivities.
    ///
    /// # Errors
    /// If `dt` is not positive, or a diffusivity is not valid (see [`Operator::new`]).
    pub fn new(grid: Grid, boundary: Boundary, diffusion: &[Diffusivity], dt: f64) -> Result<Self> {
        rates::check_dt(dt)?;
        let operator = |d: &Diffusivity| Operator::new(grid, boundary, d);
        let operators = diffusion.iter().map(operator).collect::<Result<Vec<_>>>()?;
        let rates = vec![vec![0.0; grid.len()]; operators.len()];
        Ok(Self { grid, dt, laplacian: 1.0, operators, rates, spread: vec![0.0; grid.len()] })
    }

    /// Bound on the fastest decay by diffusion (1/time), see [`Operator::max_rate`].
    pub fn max_rate(&self) -> f64 {
        self.laplacian * self.operators.iter().map(Operator::max_rate).fold(0.0, f64::max)
    }

    /// From now on all diffusion is `factor` times what it was at the start.
    pub fn scale_laplacian(&mut self, factor: f64) {
        self.laplacian = factor;
    }

    /// Advances `u`, one field per species, by one time step, without allocating.
    ///
    /// # Errors
    /// If the number of species or a length does not fit.
    pub fn step(&mut self, reaction: &dyn Reaction, u: &mut [Vec<f64>]) -> Result<()> {
        let Self { grid, dt, laplacian, operators, rates, spread } = self;
        rates::check(*grid, operators.len(), reaction, u)?;
        rates::evaluate(reaction, u, rates);
        for ((u, f), operator) in u.iter_mut().zip(rates).zip(operators) {
            operator.apply(u, spread);
            combine(u, [f, spread], |u, [f, d]| u + *dt * (f + *laplacian * d));
        }
        Ok(())
    }
}
