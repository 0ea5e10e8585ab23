//! Adam in a spectrally preconditioned variable.

use super::StepInfo;
use super::precondition::{check as check_preconditioner, preconditioner};
use crate::curvature::Mask;
use crate::curvature::energy::{Energy, EnergyConfig, Scalar};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use solvers::optimize::{Adam, AdamConfig};
use solvers::spectral::Multiplier;
use solvers::spectral::Transforms;
use solvers::{Aligned, Error, Result};

/// Variables that are updated together.
const PART: usize = 4096;

/// Most halvings of the rate.
const HALVINGS: u64 = 40;

/// Constants of the fast flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastConfig {
    /// Of Adam; a rate of .5 to 1.5.
    pub adam: AdamConfig,
    /// Steps in which the rate falls linearly to 0; none keeps it.
    pub decay: Option<u64>,
    /// Steps in which the rate first rises linearly from 0.
    pub warmup: u64,
    /// An energy above that of u0, times this, tells of too long a rate.
    pub rise: f64,
    /// Foot of the preconditioner's spectrum; .3 and 3 were slower.
    pub beta: f64,
}

impl Default for FastConfig {
    fn default() -> Self {
        let adam = AdamConfig { rate: 1.0, ..AdamConfig::default() };
        Self { adam, decay: Some(1000), warmup: 0, rise: 2.0, beta: 1.0 }
    }
}

impl FastConfig {
    /// Refuses constants out of their range, and energies that it cannot lower.
    pub(super) fn check(&self, energy: &EnergyConfig) -> Result<()> {
        self.adam.check()?;
        check_preconditioner(energy, self.beta)
    }
}

/// Adam on y, with `u = u0 + h^(-1/2) y` (`precondition.rs`): all wave lengths fall about as
/// fast, and the mean of u stays that of u0 to rounding. Where the energy rises far above that of
/// u0, it begins again at half the rate. Three fields of state.
#[derive(Debug)]
pub struct Fast<T: Transforms> {
    config: FastConfig,
    energy: Energy<T>,
    root: Multiplier<T>,
    mask: Option<Mask<T>>,
    start: Aligned<T>,
    /// y, mean gradient, mean squared gradient.
    state: [Aligned<T>; 3],
    steps: u64,
    guard: Guard,
    u: Aligned<T>,
    gradient: Aligned<T>,
    transformed: Aligned<T>,
    norms: Vec<f64>,
}

/// What has become of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard {
    /// Largest energy that is let pass; none before the first evaluation.
    pub ceiling: Option<f64>,
    /// Times that the rate was halved.
    pub halvings: u64,
    /// Evaluations before the flow last began.
    pub begun: u64,
}

impl<T: Scalar + Transforms> Fast<T> {
    /// Starts at `u0`.
    ///
    /// # Errors
    /// If a constant is out of its range, the box is not periodic or a20 + a02 is not positive.
    ///
    /// # Panics
    /// If `u0` has not one number per voxel.
    pub fn new(energy: Energy<T>, config: FastConfig, u0: Vec<T>) -> Result<Self> {
        config.check(energy.config())?;
        let n = energy.voxels();
        assert_eq!(u0.len(), n, "one number per voxel");
        let root = preconditioner(energy.config(), config.beta, -0.5)?;
        let zeros = || Aligned::new(n, T::zero());
        let u0 = Aligned::from(&u0[..]);
        let (gradient, transformed) = (zeros(), zeros());
        Ok(Self {
            config,
            energy,
            root,
            mask: None,
            u: u0.clone(),
            start: u0,
            state: [zeros(), zeros(), zeros()],
            steps: 0,
            guard: Guard { ceiling: None, halvings: 0, begun: 0 },
            gradient,
            transformed,
            norms: vec![0.0; n.div_ceil(PART)],
        })
    }

    /// Gives u at some voxels; the mean of u is then no longer kept.
    #[must_use]
    pub fn with_mask(mut self, mask: Mask<T>) -> Self {
        mask.fix(&mut self.u);
        self.mask = Some(mask);
        self
    }

    /// Evaluates, then steps. An evaluation that shows that the rate is too long is followed by
    /// another.
    ///
    /// # Errors
    /// If the energy or its gradient is not finite at u0, or rises at every rate.
    pub fn step(&mut self) -> Result<StepInfo> {
        let info = loop {
            let energy = self.energy.value_and_gradient(&self.u, &mut self.gradient);
            let info = StepInfo { iteration: self.steps, energy, gradient_norm: 0.0 };
            let ceiling = *self.guard.ceiling.get_or_insert(self.config.rise * energy.abs());
            if self.steps == self.guard.begun || energy <= ceiling {
                break info.check()?;
            }
            self.begin_again(energy)?;
        };
        if let Some(mask) = &self.mask {
            mask.clear(&mut self.gradient);
        }
        self.root.apply(&self.gradient, &mut self.transformed);
        let adam = AdamConfig { rate: self.rate(), ..self.config.adam };
        self.steps += 1;
        let adam = Adam::new(&adam, self.steps - self.guard.begun);
        let [y, m, v] = &mut self.state;
        let parts = y.par_chunks_mut(PART).zip(m.par_chunks_mut(PART)).zip(v.par_chunks_mut(PART));
        let parts = parts.zip(self.transformed.par_chunks(PART)).zip(self.norms.par_iter_mut());
        parts.for_each(|((((y, m), v), gradient), norm)| {
            *norm = Arch::new().dispatch(Update { adam, state: [y, m, v], gradient });
        });
        let gradient_norm = self.norms.iter().sum::<f64>().sqrt();
        self.compute_phase();
        StepInfo { gradient_norm, ..info }.check()
    }

    /// Rate of the next step.
    fn rate(&self) -> f64 {
        let left = self
            .config
            .decay
            .map_or(1.0, |decay| (1.0 - self.steps as f64 / decay.max(1) as f64).max(0.0));
        let risen = (self.steps + 1 - self.guard.begun) as f64 / (self.config.warmup + 1) as f64;
        let halved = libm::exp2(-(self.guard.halvings as f64));
        self.config.adam.rate * halved * left * risen.min(1.0)
    }

    /// At u0, with half the rate, after a step to `energy`.
    fn begin_again(&mut self, energy: f64) -> Result<()> {
        if self.guard.halvings == HALVINGS {
            let (rate, steps) = (self.config.adam.rate, self.steps);
            return Err(Error::Invalid(format!(
                "the energy rose to {energy} at iteration {steps}, though the rate of {rate} was \
                 halved {HALVINGS} times; reduce the rate"
            )));
        }
        self.steps += 1;
        self.guard.begun = self.steps;
        self.guard.halvings += 1;
        self.state.iter_mut().for_each(|values| values.fill(T::zero()));
        self.compute_phase();
        Ok(())
    }

    fn compute_phase(&mut self) {
        self.root.apply(&self.state[0], &mut self.u);
        self.u.par_iter_mut().zip(&self.start[..]).for_each(|(u, &start)| *u = *u + start);
        if let Some(mask) = &self.mask {
            mask.fix(&mut self.u);
        }
    }

    /// The phase field, shape `[nz, ny, nx]`.
    pub fn phase(&self) -> &[T] {
        &self.u
    }

    /// Where it began.
    pub fn start(&self) -> &[T] {
        &self.start
    }

    /// Its energy's constants and measures.
    pub fn energy(&self) -> &Energy<T> {
        &self.energy
    }

    /// Evaluations made: the steps, and those that showed that the rate was too long.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// What has become of the rate.
    pub fn guard(&self) -> Guard {
        self.guard
    }

    /// y, mean gradient, mean squared gradient: with u0, [`Fast::steps`] and [`Fast::guard`] all
    /// that a checkpoint needs.
    pub fn state(&self) -> &[Aligned<T>; 3] {
        &self.state
    }

    /// Takes up a state of [`Fast::state`] after `steps` steps.
    ///
    /// # Panics
    /// If it has not one number per voxel.
    pub fn restore(&mut self, state: [Vec<T>; 3], steps: u64, guard: Guard) {
        let n = self.energy.voxels();
        assert!(state.iter().all(|values| values.len() == n), "one number per voxel");
        self.state = state.map(|values| Aligned::from(&values[..]));
        (self.steps, self.guard) = (steps, guard);
        self.compute_phase();
    }
}

/// Adam's update of some variables; the sum of their squared gradients.
struct Update<'a, T> {
    adam: Adam<T>,
    state: [&'a mut [T]; 3],
    gradient: &'a [T],
}

impl<T: Scalar> NullaryFnOnce for Update<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        self.adam.update(self.state, self.gradient)
    }
}
