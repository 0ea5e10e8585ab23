//! One door to the linear solvers.

use super::{
    Direct, System,
    direct::factor_bytes,
    multigrid::{self, Multigrid, Status},
};
use crate::{Error, Result};

/// Elements from which conjugate gradients are taken, in the plane and in space. They are
/// faster at every size measured (40 designs from 60x20 to 200x66: 1.9 to 4.4 times; 30 of
/// 12x8x6 and 24x12x8: 1.8 and 4.9 times), but a factorization is exact to rounding, which
/// the published figures of small problems need, and takes milliseconds there.
const MANY_ELEMENTS: [usize; 2] = [5000, 1000];

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
    kind: Kind,
    /// Bytes that a factorization may take.
    memory: u64,
}

enum Kind {
    Direct(Box<Direct>),
    Multigrid {
        multigrid: Box<Multigrid>,
        /// Stiffness of the last design, for a factorization where the iteration stalls.
        stiffness: Vec<f64>,
        fallback: Option<Box<Direct>>,
        /// Whether `fallback` holds the factor of `stiffness`.
        factorized: bool,
    },
}

impl LinearSolver {
    /// The wanted solver of `system`, which may take `memory` bytes; nothing is factorized yet.
    ///
    /// # Errors
    /// If nothing is free, or memory does not suffice; the message has the size needed.
    pub fn new(system: &System, choice: Choice, memory: u64) -> Result<Self> {
        let lattice = system.lattice();
        let many = lattice.element_count() >= MANY_ELEMENTS[lattice.dim() - 2];
        let iterate = match choice {
            Choice::Auto => many,
            Choice::Direct => false,
            Choice::Multigrid => true,
        };
        let kind = if iterate {
            multigrid(system, memory)?
        } else {
            Kind::Direct(direct(system, memory)?)
        };
        Ok(Self { kind, memory })
    }

    /// What it is, for the run's log.
    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::Multigrid { .. } => "conjugate gradients with multigrid",
            Kind::Direct(_) => "sparse Cholesky",
        }
    }

    /// Takes new element stiffnesses.
    ///
    /// # Errors
    /// If the matrix is not positive definite or not finite.
    pub fn prepare(&mut self, system: &System, new: &[f64]) -> Result<()> {
        match &mut self.kind {
            Kind::Direct(direct) => direct.factorize(system, new),
            Kind::Multigrid { multigrid, stiffness, factorized, .. } => {
                *factorized = false;
                stiffness.copy_from_slice(new);
                multigrid.update(new)
            }
        }
    }

    /// Solves for `u`, which may hold a guess; fixed unknowns become 0. `tolerance` bounds
    /// the relative residual of an iterative solver; where that stalls, a factorization
    /// takes over.
    ///
    /// # Errors
    /// If a number is not finite, or the iteration stalls and a factorization would not fit
    /// in memory.
    pub fn solve(
        &mut self,
        system: &System,
        force: &[f64],
        u: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport> {
        let (multigrid, stiffness, fallback, factorized) = match &mut self.kind {
            Kind::Direct(direct) => {
                direct.solve(force, u)?;
                return Ok(SolveReport::default());
            }
            Kind::Multigrid { multigrid, stiffness, fallback, factorized } => {
                (multigrid, stiffness, fallback, factorized)
            }
        };
        let found = multigrid.solve(force, u, tolerance, LIMIT)?;
        let iterations = found.iterations;
        if found.status == Status::Converged {
            return Ok(SolveReport { iterations, residual: found.residual, fell_back: false });
        }
        let direct = match fallback {
            Some(direct) => direct,
            None => fallback.insert(direct(system, self.memory).map_err(|error| {
                let residual = found.residual;
                Error::Invalid(format!(
                    "conjugate gradients stalled at a residual of {residual:.1e} after \
                     {iterations} iterations, and a factorization cannot take over: {error}"
                ))
            })?),
        };
        if !*factorized {
            direct.factorize(system, stiffness)?;
            *factorized = true;
        }
        direct.solve(force, u)?;
        Ok(SolveReport { iterations, residual: 0.0, fell_back: true })
    }
}

fn multigrid(system: &System, memory: u64) -> Result<Kind> {
    let (lattice, components) = (system.lattice(), system.element().components());
    let options = multigrid::Options::default();
    let needed = multigrid::memory(&lattice, components, &options);
    check_memory("multigrid", system, needed, memory)?;
    let ke = system.element().stiffness();
    let (fixed, springs) = (system.fixed(), system.springs());
    let multigrid = Multigrid::new(&lattice, components, ke, fixed, springs, options)?;
    let stiffness = vec![0.0; lattice.element_count()];
    let multigrid = Box::new(multigrid);
    Ok(Kind::Multigrid { multigrid, stiffness, fallback: None, factorized: false })
}

fn direct(system: &System, memory: u64) -> Result<Box<Direct>> {
    let needed = factor_bytes(system.unknowns(), system.lattice().dim());
    check_memory("factor of the stiffness matrix", system, needed, memory)?;
    Ok(Box::new(Direct::new(system)?))
}

fn check_memory(name: &str, system: &System, needed: usize, memory: u64) -> Result<()> {
    if needed as u64 <= memory {
        return Ok(());
    }
    let gib = |bytes: f64| format!("{:.1} GiB", bytes / 1024.0_f64.powi(3));
    let n = system.unknowns();
    Err(Error::TooLarge {
        name: name.into(),
        shape: vec![n, n],
        needed: gib(needed as f64),
        available: gib(memory as f64),
    })
}
