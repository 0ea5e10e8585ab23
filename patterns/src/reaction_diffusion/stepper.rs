//! The time stepper that a configuration chose, behind one interface.

use super::grown::{Grown, Stretchable};
use crate::{Error, Result, State};
use serde::{Deserialize, Serialize};
use solvers::diffusion::explicit::{Cell, CellKernel, Explicit, Kernel, Parameter, Real, Stencil};
use solvers::{Boundary, Field, Grid};

/// Precision of the concentrations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 32-bit floats.
    F32,
    /// 64-bit floats.
    F64,
}

impl Precision {
    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// What a stepper is made from.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Grid of node distance 1 cell.
    pub grid: Grid,
    /// Neumann or periodic.
    pub boundary: Boundary,
    /// Differences of the Laplacian.
    pub stencil: Stencil,
    /// Precision of the concentrations.
    pub precision: Precision,
    /// Time step.
    pub dt: f64,
    /// Diffusion coefficient of each species (cells^2/time).
    pub diffusion: Vec<f64>,
    /// Parameters, in the order of the kinetics.
    pub parameters: Vec<Parameter>,
    /// Whether concentrations are kept from becoming negative.
    pub clamp: bool,
}

impl Setup {
    /// Refuses single precision, for kinetics that are not compiled in it.
    pub(super) fn check_double(&self) -> Result<()> {
        match self.precision {
            Precision::F64 => Ok(()),
            Precision::F32 => {
                let reason = "this kinetics runs in f64; turing and gray-scott run in f32 too";
                Err(Error::config("precision", reason))
            }
        }
    }

    /// Refuses a time step at which the fastest diffusion is unstable. A domain that grows
    /// has its fastest diffusion, in cells, at the start.
    fn check_diffusion(&self) -> Result<()> {
        let fastest = self.diffusion.iter().copied().fold(0.0, f64::max);
        self.check_rate(fastest * self.stencil.max_symbol(self.grid))
    }

    /// Refuses a time step at which the fastest decay, `rate` (1/time), overshoots without bound.
    pub(super) fn check_rate(&self, rate: f64) -> Result<()> {
        if self.dt * rate < 2.0 {
            return Ok(());
        }
        let reason = format!(
            "{} is unstable, an explicit step of these coefficients needs less than {:.4}",
            self.dt,
            2.0 / rate
        );
        Err(Error::config("dt", reason))
    }
}

/// What the growth of the domain does to the next steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The Laplacian over that of the start.
    pub laplacian: f64,
    /// Concentrations after a step over those without dilution.
    pub dilution: f64,
}

/// A state that advances in time.
pub trait Stepper: Send {
    /// Does `steps` time steps.
    ///
    /// # Errors
    /// Whatever stops the run for good.
    fn advance(&mut self, steps: u64) -> Result<()>;

    /// Lets the next steps be those of a domain that grows.
    ///
    /// # Errors
    /// If this stepper cannot change its Laplacian.
    fn stretch(&mut self, stretch: Stretch) -> Result<()>;

    /// Sets the concentration of one species.
    fn set(&mut self, species: usize, field: &Field);

    /// Copies the concentration of one species into `field`.
    fn copy_into(&self, species: usize, field: &mut Field);

    /// Adds the exact state to a checkpoint, under the names `names`.
    fn save(&self, names: &[String], state: &mut State);

    /// Takes the state from a checkpoint.
    ///
    /// # Errors
    /// If an array is missing or has another shape.
    fn restore(&mut self, names: &[String], state: &State) -> Result<()>;
}

impl<K: Kernel<f64> + Stretchable + Send> Stepper for Explicit<f64, Grown<f64, K>> {
    fn advance(&mut self, steps: u64) -> Result<()> {
        Explicit::advance(self, steps);
        Ok(())
    }

    fn stretch(&mut self, stretch: Stretch) -> Result<()> {
        let grid = self.grid();
        self.kernel_mut().stretch(grid, stretch);
        Ok(())
    }

    fn set(&mut self, species: usize, field: &Field) {
        Explicit::set(self, species, field.as_slice());
    }

    fn copy_into(&self, species: usize, field: &mut Field) {
        Explicit::copy_into(self, species, field);
    }

    fn save(&self, names: &[String], state: &mut State) {
        for (s, name) in names.iter().enumerate() {
            state.put_f64(name, &self.values(s));
        }
    }

    fn restore(&mut self, names: &[String], state: &State) -> Result<()> {
        let mut values = vec![0.0; self.grid().len()];
        for (s, name) in names.iter().enumerate() {
            state.get_f64(name, &mut values)?;
            Explicit::set(self, s, &values);
        }
        Ok(())
    }
}

impl<K: Kernel<f32> + Stretchable + Send> Stepper for Explicit<f32, Grown<f32, K>> {
    fn advance(&mut self, steps: u64) -> Result<()> {
        Explicit::advance(self, steps);
        Ok(())
    }

    fn stretch(&mut self, stretch: Stretch) -> Result<()> {
        let grid = self.grid();
        self.kernel_mut().stretch(grid, stretch);
        Ok(())
    }

    fn set(&mut self, species: usize, field: &Field) {
        let values: Vec<f32> = field.as_slice().iter().map(|&v| v as f32).collect();
        Explicit::set(self, species, &values);
    }

    fn copy_into(&self, species: usize, field: &mut Field) {
        Explicit::copy_into(self, species, field);
    }

    fn save(&self, names: &[String], state: &mut State) {
        for (s, name) in names.iter().enumerate() {
            state.put_f32(name, &self.values(s));
        }
    }

    fn restore(&mut self, names: &[String], state: &State) -> Result<()> {
        let mut values = vec![0.0; self.grid().len()];
        for (s, name) in names.iter().enumerate() {
            state.get_f32(name, &mut values)?;
            Explicit::set(self, s, &values);
        }
        Ok(())
    }
}

/// `values` as an array of the length that the kinetics wants.
pub(super) fn array<V: Clone, const N: usize>(values: &[V]) -> Result<[V; N]> {
    values.to_vec().try_into().map_err(|_| {
        Error::config("parameters", format!("{} values where {N} are wanted", values.len()))
    })
}

/// The explicit stepper of a kernel in double precision.
pub(super) fn explicit_kernel<K>(setup: &Setup, kernel: K) -> Result<Box<dyn Stepper>>
where
    K: Kernel<f64> + Stretchable + Send + 'static,
{
    let kernel = Grown::new(kernel, &setup.diffusion);
    Ok(Box::new(Explicit::new(setup.grid, setup.boundary, kernel)?))
}

/// The explicit stepper of a per-cell reaction.
pub(super) fn explicit_cell<C: Cell<S, P>, const S: usize, const P: usize>(
    setup: &Setup,
) -> Result<Box<dyn Stepper>> {
    if setup.precision == Precision::F64 {
        return explicit_double::<C, S, P>(setup);
    }
    setup.check_diffusion()?;
    let kernel = Grown::new(cell::<f32, C, S, P>(setup)?, &setup.diffusion);
    Ok(Box::new(Explicit::new(setup.grid, setup.boundary, kernel)?))
}

/// As [`explicit_cell`], in double precision only.
pub(super) fn explicit_double<C: Cell<S, P>, const S: usize, const P: usize>(
    setup: &Setup,
) -> Result<Box<dyn Stepper>> {
    setup.check_double()?;
    setup.check_diffusion()?;
    explicit_kernel(setup, cell::<f64, C, S, P>(setup)?)
}

fn cell<T: Real, C: Cell<S, P>, const S: usize, const P: usize>(
    setup: &Setup,
) -> Result<CellKernel<T, C, S, P>> {
    let (diffusion, parameters) = (array(&setup.diffusion)?, array(&setup.parameters)?);
    let Setup { grid, stencil, dt, clamp, .. } = *setup;
    Ok(CellKernel::new(grid, stencil, dt, diffusion, &parameters, clamp)?)
}
