//! Implicit diffusion, explicit reaction.

use super::rates::{self, combine};
use super::{Diffusivity, Operator, Reaction};
use crate::field::sum;
use crate::sparse::{Cholesky, Ordering, Scratch, Symbolic, nested_dissection};
use crate::spectral::{LaplacianSymbol, LinearPart, Transform};
use crate::{Boundary, Error, Grid, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

/// Implicit-explicit one-step schemes; both are stable for any dt if there is only diffusion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ImexScheme {
    /// First order: `(1 - dt A) u' = u + dt f(u)`.
    Euler,
    /// Second order, L-stable, two stages: ARS(2,2,2) of Ascher, Ruuth and Spiteri 1997, section 2.6.
    #[default]
    Ars222,
}

/// How a [`SemiImplicit`] steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SemiImplicitConfig {
    /// Time step; the reaction limits it, diffusion does not.
    pub dt: f64,
    /// The scheme.
    pub scheme: ImexScheme,
    /// The Laplacian of species with constant diffusion; maps and tensors have their own stencil.
    pub laplacian: LaplacianSymbol,
}

/// `du_s/dt = f_s(u, x) + div(D_s grad u_s)` with implicit diffusion.
///
/// Constant D is solved in the Fourier or cosine series, maps and tensors by a sparse
/// Cholesky factor made once. There is no hidden state: a step depends on `u` alone.
#[derive(Debug)]
pub struct SemiImplicit {
    grid: Grid,
    config: SemiImplicitConfig,
    solves: Vec<Solve>,
    transform: Transform,
    /// The Laplacian of each mode at the start.
    symbols: Vec<f64>,
    modes: Vec<f64>,
    rates: Vec<Vec<f64>>,
    stage: Vec<Vec<f64>>,
    next: Vec<Vec<f64>>,
}

/// `(1 - gamma dt A)^-1` of one species.
enum Solve {
    Identity,
    /// By series: the linear part, and the factor of each mode.
    Diagonal(LinearPart, Vec<f64>),
    Factor(Cholesky, Scratch),
}

/// Both diagonal entries of ARS(2,2,2)'s implicit table.
const GAMMA: f64 = 1.0 - FRAC_1_SQRT_2;

impl SemiImplicitConfig {
    /// Length of an implicit stage.
    fn implicit_step(&self) -> f64 {
        match self.scheme {
            ImexScheme::Euler => self.dt,
            ImexScheme::Ars222 => GAMMA * self.dt,
        }
    }
}

impl SemiImplicit {
    /// A stepper for as many species as there are diffusivities.
    ///
    /// # Errors
    /// If `dt` is not positive, a diffusivity is not valid (see [`Operator::new`]), or the
    /// boundary is extrapolated.
    pub fn new(
        grid: Grid,
        boundary: Boundary,
        diffusion: &[Diffusivity],
        config: SemiImplicitConfig,
    ) -> Result<Self> {
        let theta = config.implicit_step();
        Self::with_solves(grid, boundary, config, diffusion.len(), |transform, s| {
            Solve::new(transform, boundary, &diffusion[s], theta)
        })
    }

    /// A stepper for linear parts that are functions of the Laplacian, all implicit.
    ///
    /// # Errors
    /// If `dt` is not positive, the boundary is extrapolated, or a linear part grows
    /// faster than the step can follow, at `1/dt` or more.
    pub fn with_linear_parts(
        grid: Grid,
        boundary: Boundary,
        linear: &[LinearPart],
        config: SemiImplicitConfig,
    ) -> Result<Self> {
        Self::with_solves(grid, boundary, config, linear.len(), |_, s| {
            Ok(Solve::Diagonal(linear[s].clone(), Vec::new()))
        })
    }

    fn with_solves(
        grid: Grid,
        boundary: Boundary,
        config: SemiImplicitConfig,
        species: usize,
        solve: impl Fn(&Transform, usize) -> Result<Solve>,
    ) -> Result<Self> {
        rates::check_dt(config.dt)?;
        let transform = Transform::new(grid, boundary)?;
        let symbols = transform.map_modes(|k| config.laplacian.at(k, grid.spacing()));
        let solves = (0..species).map(|s| solve(&transform, s)).collect::<Result<Vec<_>>>()?;
        let fields = || vec![vec![0.0; grid.len()]; species];
        let mut stepper = Self {
            grid,
            config,
            solves,
            transform,
            symbols,
            modes: vec![0.0; grid.len()],
            rates: fields(),
            stage: fields(),
            next: fields(),
        };
        stepper.set_factors(1.0)?;
        Ok(stepper)
    }

    /// From now on the Laplacian is `factor` times that of the start, as on a domain that has grown.
    ///
    /// # Errors
    /// If a diffusivity is a map or a tensor, whose factor would have to be made anew each
    /// step, or as [`SemiImplicit::with_linear_parts`].
    pub fn scale_laplacian(&mut self, factor: f64) -> Result<()> {
        if self.solves.iter().any(|solve| matches!(solve, Solve::Factor(..))) {
            let reason = "a Laplacian that changes needs constant diffusion in implicit steps";
            return Err(Error::Invalid(reason.into()));
        }
        self.set_factors(factor)
    }

    fn set_factors(&mut self, factor: f64) -> Result<()> {
        let theta = self.config.implicit_step();
        for solve in &mut self.solves {
            if let Solve::Diagonal(linear, factors) = solve {
                factors.clear();
                factors.extend(
                    self.symbols.iter().map(|s| 1.0 / (1.0 - theta * linear.at(factor * s))),
                );
                if let Some(&bad) = factors.iter().find(|&&f| !(f >= 0.0 && f.is_finite())) {
                    return Err(Error::out_of_range("factor of an implicit step", bad, "[0, inf)"));
                }
            }
        }
        Ok(())
    }

    /// Advances `u`, one field per species, by one time step.
    ///
    /// # Errors
    /// If the number of species or a length does not fit.
    pub fn step(&mut self, reaction: &dyn Reaction, u: &mut [Vec<f64>]) -> Result<()> {
        rates::check(self.grid, self.solves.len(), reaction, u)?;
        match self.config.scheme {
            ImexScheme::Euler => self.euler(reaction, u),
            ImexScheme::Ars222 => self.ars222(reaction, u),
        }
        Ok(())
    }

    /// One line per species: which solver it has.
    pub fn describe(&self) -> String {
        let line = |(s, solve): (usize, &Solve)| format!("species {s}: {}", solve.describe());
        self.solves.iter().enumerate().map(line).collect::<Vec<_>>().join("\n")
    }

    fn euler(&mut self, reaction: &dyn Reaction, u: &mut [Vec<f64>]) {
        let Self { solves, transform, modes, rates, next, .. } = self;
        let dt = self.config.dt;
        rates::evaluate(reaction, u, rates);
        for (s, solve) in solves.iter_mut().enumerate() {
            combine(&mut next[s], [&u[s], &rates[s]], |_, [u, f]| u + dt * f);
            solve.apply(transform, modes, &next[s], &mut u[s]);
        }
    }

    /// Stage 2: `(1 - gamma dt A) v = u + gamma dt f(u)`. Result: `(1 - gamma dt A) u' =
    /// u + dt (delta f(u) + (1 - delta) f(v)) + (1 - gamma) dt A v`, where `A v` follows
    /// from stage 2 without applying A.
    fn ars222(&mut self, reaction: &dyn Reaction, u: &mut [Vec<f64>]) {
        let Self { solves, transform, modes, rates, stage, next, .. } = self;
        let dt = self.config.dt;
        let delta = 1.0 - 0.5 / GAMMA;
        let ratio = (1.0 - GAMMA) / GAMMA;
        rates::evaluate(reaction, u, rates);
        for (s, solve) in solves.iter_mut().enumerate() {
            combine(&mut next[s], [&u[s], &rates[s]], |_, [u, f]| u + GAMMA * dt * f);
            solve.apply(transform, modes, &next[s], &mut stage[s]);
            combine(&mut next[s], [&u[s], &rates[s], &stage[s]], |rhs, [u, f, v]| {
                u + delta * dt * f + ratio * (v - rhs)
            });
        }
        rates::evaluate(reaction, stage, rates);
        for (s, solve) in solves.iter_mut().enumerate() {
            combine(&mut next[s], [&rates[s]], |sum, [f]| sum + (1.0 - delta) * dt * f);
            solve.apply(transform, modes, &next[s], &mut u[s]);
        }
    }
}

impl Solve {
    fn new(
        transform: &Transform,
        boundary: Boundary,
        diffusivity: &Diffusivity,
        theta: f64,
    ) -> Result<Self> {
        let grid = transform.grid();
        let operator = Operator::new(grid, boundary, diffusivity)?;
        if let Diffusivity::Constant(d) = *diffusivity {
            return Ok(if d == 0.0 {
                Self::Identity
            } else {
                Self::Diagonal(LinearPart::diffusion(d), Vec::new())
            });
        }
        let matrix = operator.matrix(1.0, -theta)?;
        // Which order fills less depends on the stencil, and every step pays for the fill.
        let order = nested_dissection(grid.axes(), boundary == Boundary::Periodic);
        let degree = Symbolic::new(&matrix, Ordering::Amd)?;
        let dissection = Symbolic::new(&matrix, Ordering::Custom(&order))?;
        let fewer = dissection.factor_entries() < degree.factor_entries();
        let factor = Cholesky::new(if fewer { dissection } else { degree }, &matrix)?;
        let scratch = factor.scratch(1);
        Ok(Self::Factor(factor, scratch))
    }

    fn apply(&mut self, transform: &mut Transform, modes: &mut [f64], b: &[f64], x: &mut [f64]) {
        match self {
            Self::Identity => x.copy_from_slice(b),
            Self::Diagonal(_, factors) => {
                transform.forward(b, modes);
                combine(modes, [factors], |mode, [factor]| mode * factor);
                transform.inverse(modes, x);
            }
            Self::Factor(factor, scratch) => {
                x.copy_from_slice(b);
                factor.solve(x, scratch);
            }
        }
        let keeps_mean = match self {
            Self::Identity => false,
            Self::Diagonal(linear, _) => linear.at(0.0) == 0.0,
            Self::Factor(..) => true,
        };
        if keeps_mean {
            // Diffusion keeps the mean, of which a factor of a stiff matrix loses digits
            // and a series the last few, always in the same direction. The sum of the
            // differences rounds far less than the difference of the sums.
            combine(modes, [b, x], |_, [b, x]| b - x);
            let lost = sum(modes, |d| d) / x.len() as f64;
            combine(x, [], |x, []| x + lost);
        }
    }

    fn describe(&self) -> String {
        match self {
            Self::Identity => "no diffusion".into(),
            Self::Diagonal(..) => "linear part by series".into(),
            Self::Factor(factor, _) => {
                let (n, entries) = (factor.len(), factor.entries());
                format!("sparse Cholesky, {n} unknowns, {entries} entries in the factor")
            }
        }
    }
}

impl std::fmt::Debug for Solve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.describe())
    }
}
