//! One door to the linear solvers.

use super::{
    Direct, System,
    multigrid::{self, Multigrid, Status},
};
use crate::Result;

/// Elements from which conjugate gradients are taken, in the plane and in space: with a
/// start from the last design's displacements they are then faster than a factorization
/// (300x100: 4 times; 24x12x8: 2 times).
const MANY_ELEMENTS: [usize; 2] = [10_000, 2_000];

/// Most iterations before a direct solve is tried.
const LIMIT: usize = 500;

/// Which solver is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// By size.
    #[default]
    Auto,
    /// Sparse Cholesky.
    Direct,
    /// Conjugate gradients with a multigrid preconditioner.
    Multigrid,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Iterations of conjugate gradients; 0 for a direct solve.
    pub iterations: usize,
    /// `|f - K u| / |f|` over the free unknowns; 0 for a direct solve, which is exact to rounding.
    pub residual: f64,
    /// Whether the iteration stalled and a factorization took over.
    pub fell_back: bool,
}

/// A solver of `K(stiffness) u = f`, prepared once per stiffness and used for several loads.
pub struct LinearSolver {
    multigrid: Option<Box<Multigrid>>,
    direct: Option<Box<Direct>>,
    /// Stiffness that `direct` has yet to factorize.
    pending: Option<Vec<f64>>,
}

impl LinearSolver {
    /// The wanted solver of `system`; nothing is factorized yet.
    ///
    /// # Errors
    /// If nothing is free, or memory does not suffice.
    pub fn new(system: &System, choice: Choice) -> Result<Self> {
        let lattice = system.lattice();
        let many = lattice.element_count() >= MANY_ELEMENTS[lattice.dim() - 2];
        let iterate = match choice {
            Choice::Auto => many,
            Choice::Direct => false,
            Choice::Multigrid => true,
        };
        if !iterate {
            return Self::direct(system);
        }
        let multigrid = Multigrid::new(
            &lattice,
            system.element().components(),
            system.element().stiffness(),
            system.fixed(),
            system.springs(),
            multigrid::Options::default(),
        )?;
        Ok(Self { multigrid: Some(Box::new(multigrid)), direct: None, pending: None })
    }

    /// A direct solver.
    ///
    /// # Errors
    /// As [`Direct::new`].
    pub fn direct(system: &System) -> Result<Self> {
        let direct = Some(Box::new(Direct::new(system)?));
        Ok(Self { multigrid: None, direct, pending: None })
    }

    /// What it is, for the run's log.
    pub fn name(&self) -> &'static str {
        match self.multigrid {
            Some(_) => "conjugate gradients with multigrid",
            None => "sparse Cholesky",
        }
    }

    /// Takes new element stiffnesses.
    ///
    /// # Errors
    /// If the matrix is not positive definite or not finite.
    pub fn prepare(&mut self, system: &System, stiffness: &[f64]) -> Result<()> {
        match (&mut self.multigrid, &mut self.direct) {
            (Some(multigrid), _) => {
                multigrid.update(stiffness)?;
                self.pending = Some(stiffness.to_vec());
                Ok(())
            }
            (None, Some(direct)) => direct.factorize(system, stiffness),
            (None, None) => Ok(()),
        }
    }

    /// Solves for `u`, which may hold a guess; fixed unknowns become 0. `tolerance` bounds
    /// the relative residual of an iterative solver; where that stalls, a factorization
    /// takes over.
    ///
    /// # Errors
    /// If a number is not finite, or there is no solution to be had.
    pub fn solve(
        &mut self,
        system: &System,
        force: &[f64],
        u: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport> {
        let mut report = SolveReport::default();
        if let Some(multigrid) = &mut self.multigrid {
            let found = multigrid.solve(force, u, tolerance, LIMIT)?;
            report.iterations = found.iterations;
            report.residual = found.residual;
            if found.status == Status::Converged {
                return Ok(report);
            }
            report.fell_back = true;
            if self.direct.is_none() {
                self.direct = Some(Box::new(Direct::new(system)?));
            }
        }
        if let Some(direct) = &mut self.direct {
            if let Some(stiffness) = self.pending.take() {
                direct.factorize(system, &stiffness)?;
            }
            direct.solve(force, u)?;
            report.residual = 0.0;
        }
        Ok(report)
    }
}
