//! The published flow: Adam on the vector potential.

use super::StepInfo;
use super::paper_step::Variables;
use crate::curvature::energy::{Energy, Scalar};
use crate::curvature::{Mask, Potential};
use solvers::optimize::{Adam, AdamConfig};
use solvers::random::{stream, uniform};
use solvers::{Aligned, Result};

/// Constants of the published flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperConfig {
    /// Of Adam; its epsilon is 1e-2, and matters once gradients have fallen to its size.
    pub adam: AdamConfig,
}

impl Default for PaperConfig {
    fn default() -> Self {
        Self { adam: AdamConfig { epsilon: 1e-2, ..AdamConfig::default() } }
    }
}

/// Adam on A, with `u = k * (div A + m0)`: the mean of u is that of m0, to rounding. Song 2021,
/// algorithm 1.
#[derive(Clone, Debug)]
pub struct Paper<T> {
    config: PaperConfig,
    energy: Energy<T>,
    potential: Potential<T>,
    mask: Option<Mask<T>>,
    variables: Variables<T>,
    steps: u64,
    u: Aligned<T>,
    gradient: Aligned<T>,
    between: Aligned<T>,
}

/// The published start `A = 40 dx U`, U uniform in [0, 1): components along z, y, x.
pub fn start<T: Scalar>(voxels: usize, dx: f64, seed: u64) -> [Vec<T>; 3] {
    [0, 1, 2].map(|axis| {
        let mut stream = stream(seed, "curvature potential", axis);
        (0..voxels).map(|_| T::from_f64(40.0 * dx * uniform(&mut stream))).collect()
    })
}

impl<T: Scalar> Paper<T> {
    /// The published start, `A = 40 dx U` with U uniform in [0, 1) at each voxel.
    ///
    /// # Errors
    /// If a constant is out of its range.
    pub fn new(
        energy: Energy<T>,
        potential: Potential<T>,
        config: PaperConfig,
        seed: u64,
    ) -> Result<Self> {
        let a = start(energy.voxels(), energy.config().dx, seed);
        Self::from_potential(energy, potential, config, a)
    }

    /// From a given A.
    ///
    /// # Errors
    /// If a constant is out of its range.
    ///
    /// # Panics
    /// If A has not one number per voxel and component.
    pub fn from_potential(
        energy: Energy<T>,
        potential: Potential<T>,
        config: PaperConfig,
        a: [Vec<T>; 3],
    ) -> Result<Self> {
        config.adam.check()?;
        let shape = energy.config().shape;
        let zeros = || Aligned::new(energy.voxels(), T::from_f64(0.0));
        let mut divergence = zeros();
        potential.divergence([&a[0], &a[1], &a[2]], &mut divergence);
        drop(a);
        let variables = Variables::new(shape, potential.factor(), divergence);
        let (u, gradient, between) = (zeros(), zeros(), zeros());
        let (mask, steps) = (None, 0);
        let mut flow =
            Self { config, energy, potential, mask, variables, steps, u, gradient, between };
        flow.compute_phase();
        Ok(flow)
    }

    /// Gives u at some voxels.
    #[must_use]
    pub fn with_mask(mut self, mask: Mask<T>) -> Self {
        self.mask = Some(mask);
        self.compute_phase();
        self
    }

    /// Evaluates, then steps.
    ///
    /// # Errors
    /// If the energy or its gradient is not finite; the state is then of no use.
    pub fn step(&mut self) -> Result<StepInfo> {
        let energy = self.energy.value_and_gradient(&self.u, &mut self.gradient);
        let info = StepInfo { iteration: self.steps, energy, gradient_norm: 0.0 }.check()?;
        if let Some(mask) = &self.mask {
            mask.clear(&mut self.gradient);
        }
        self.potential.blur_in_place(&mut self.gradient, &mut self.between);
        self.steps += 1;
        let adam = Adam::new(&self.config.adam, self.steps);
        let gradient_norm = self.variables.step(adam, &self.gradient);
        self.compute_phase();
        StepInfo { gradient_norm, ..info }.check()
    }

    fn compute_phase(&mut self) {
        let divergence = &self.variables.fields[0];
        self.potential.blur(divergence, &mut self.between, &mut self.u);
        if let Some(mask) = &self.mask {
            mask.fix(&mut self.u);
        }
    }

    /// The phase field of the current A, shape `[nz, ny, nx]`.
    pub fn phase(&self) -> &[T] {
        &self.u
    }

    /// Its energy's constants and measures.
    pub fn energy(&self) -> &Energy<T> {
        &self.energy
    }

    /// Steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// div A + m0, the running mean of k * dF/du, of which the mean gradient is minus the gradient,
    /// and the mean squared gradient along z, y, x: with [`Paper::steps`] all that a checkpoint
    /// needs.
    pub fn state(&self) -> &[Aligned<T>; 5] {
        &self.variables.fields
    }

    /// Takes up a state of [`Paper::state`] after `steps` steps.
    ///
    /// # Panics
    /// If it has not one number per voxel.
    pub fn restore(&mut self, state: [Vec<T>; 5], steps: u64) {
        let n = self.energy.voxels();
        assert!(state.iter().all(|values| values.len() == n), "one number per voxel");
        for (field, values) in self.variables.fields.iter_mut().zip(state) {
            field.copy_from_slice(&values);
        }
        self.steps = steps;
        self.compute_phase();
    }
}
