//! A reaction some of whose cells are held: the model itself fills in the rest.

use super::config::CurveSpeed;
use super::resolve;
use super::setup::Start;
use super::stepper::Stepper;
use crate::{Context, Error, Inputs, Result};
use solvers::{Boundary, Field, Grid};

/// Concentrations that advance in time while those of one species stay within bounds.
pub(crate) struct Held {
    stepper: Box<dyn Stepper>,
    species: usize,
    c: Field,
    iterations: u64,
}

impl Held {
    /// The reaction of a configuration of `rd` on `ny` x `nx` cells with mirrored borders, at
    /// its mean parameters: without what was changed in places, growth and curve. The
    /// species that is held is the ink's.
    ///
    /// # Errors
    /// What the model refuses.
    pub(crate) fn new(
        table: &toml::Table,
        [ny, nx]: [usize; 2],
        inputs: &dyn Inputs,
    ) -> Result<Self> {
        let mut config = resolve::resolve(table)?;
        config.size = super::config::Size::Axes(vec![ny, nx]);
        config.boundary = Boundary::Neumann;
        config.perturbation.clear();
        config.growth = None;
        config.curve.speed = CurveSpeed::Off;
        let start = Start::new(&config, &Context { seed: 0, inputs, memory: 1 << 30 })?;
        let wanted = &config.ink.species;
        let species =
            start.chemistry.species.iter().position(|s| s == wanted).ok_or_else(|| {
                Error::config("ink.species", format!("no `{wanted}` in this kinetics"))
            })?;
        let (stepper, _) = start.stepper(config.stepper)?;
        let c = Field::constant(Grid::new(&[ny, nx], 1.0)?, 0.0);
        Ok(Self { stepper, species, c, iterations: config.iterations })
    }

    /// Time steps of a run from its usual start.
    pub(crate) fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Sets the concentration of a species, in the order of the kinetics.
    pub(crate) fn set(&mut self, species: usize, values: &[f64]) {
        self.c.as_mut_slice().copy_from_slice(values);
        self.stepper.set(species, &self.c);
    }

    /// Does `steps` time steps, after each of which what lies outside `bounds` is moved to
    /// the nearer of them.
    ///
    /// # Errors
    /// What stops the run for good; a concentration that is no number.
    pub(crate) fn advance(&mut self, steps: u64, bounds: &[[f64; 2]]) -> Result<()> {
        for _ in 0..steps {
            self.stepper.advance(1)?;
            self.stepper.copy_into(self.species, &mut self.c);
            for (value, [low, high]) in self.c.as_mut_slice().iter_mut().zip(bounds) {
                *value = value.max(*low).min(*high);
            }
            self.stepper.set(self.species, &self.c);
        }
        self.c.check_finite("held concentration", steps as f64)?;
        Ok(())
    }

    /// The concentration of the held species.
    pub(crate) fn concentration(&self) -> &[f64] {
        self.c.as_slice()
    }
}
