//! One door to the linear solvers.

use super::{Direct, System};
use crate::Result;

/// What a solve took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Iterations of conjugate gradients; 0 for a direct solve.
    pub iterations: usize,
    /// `|f - K u| / |f|` over the free unknowns, as the solver knows it; 0 for a direct solve.
    pub residual: f64,
}

/// A solver of `K(stiffness) u = f`, prepared once per stiffness and used for several loads.
pub enum LinearSolver {
    /// Sparse Cholesky.
    Direct(Box<Direct>),
}

impl LinearSolver {
    /// A direct solver.
    ///
    /// # Errors
    /// As [`Direct::new`].
    pub fn direct(system: &System) -> Result<Self> {
        Ok(Self::Direct(Box::new(Direct::new(system)?)))
    }

    /// Takes new element stiffnesses.
    ///
    /// # Errors
    /// If the matrix is not positive definite or not finite.
    pub fn prepare(&mut self, system: &System, stiffness: &[f64]) -> Result<()> {
        match self {
            Self::Direct(direct) => direct.factorize(system, stiffness),
        }
    }

    /// Solves for `u`, which may hold a guess; fixed unknowns become 0. `tolerance` bounds
    /// the relative residual of an iterative solver.
    ///
    /// # Errors
    /// If a number is not finite, or there is no solution to be had.
    pub fn solve(
        &mut self,
        _system: &System,
        force: &[f64],
        u: &mut [f64],
        _tolerance: f64,
    ) -> Result<SolveReport> {
        match self {
            Self::Direct(direct) => {
                direct.solve(force, u)?;
                Ok(SolveReport::default())
            }
        }
    }
}
