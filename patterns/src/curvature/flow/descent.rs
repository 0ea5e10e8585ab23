//! L2 flow by L-BFGS.

use super::StepInfo;
use super::precondition::preconditioner;
use crate::curvature::Mask;
use crate::curvature::energy::{Edges, Energy, Scalar};
use rayon::prelude::*;
use solvers::blur::{Blur, BlurEdges};
use solvers::optimize::{Lbfgs, LbfgsConfig};
use solvers::spectral::{Multiplier, Transforms};
use solvers::{Aligned, Error, Result, diffusion::explicit::Real, field};
use std::sync::Arc;

/// Constants of the L2 flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentConfig {
    /// Of L-BFGS; ten pairs as published.
    pub lbfgs: LbfgsConfig,
    /// Standard deviation (voxels) of the blur that makes u from the variable v, none for
    /// `u = v`. Published: 1.
    pub sigma: Option<f64>,
    /// Whether the mean of u is kept.
    pub keep_mass: bool,
    /// Whether steps are preconditioned with the spectrum of the energy, whose foot is `beta`;
    /// keeps the mean, and needs a periodic box.
    pub beta: Option<f64>,
}

impl Default for DescentConfig {
    fn default() -> Self {
        // Longer steps carry surfaces through each other: a front moves by sqrt(2) epsilon / 2.
        let lbfgs = LbfgsConfig { reach: Some(0.5), ..LbfgsConfig::default() };
        Self { lbfgs, sigma: Some(1.0), keep_mass: false, beta: None }
    }
}

/// L-BFGS on v with `u = k * v` or `u = v`. Song 2021, algorithm 2; here the line search never
/// lets the energy rise.
#[derive(Debug)]
pub struct Descent<T: Transforms> {
    config: DescentConfig,
    solver: Lbfgs<T>,
    function: Function<T>,
    inverse: Option<Multiplier<T>>,
    turned: Vec<T>,
    steps: u64,
    evaluations: u64,
}

/// F as a function of v.
#[derive(Debug)]
struct Function<T> {
    energy: Energy<T>,
    blur: Option<Blur<T>>,
    mask: Option<Mask<T>>,
    /// Gradient of the mean of u, normalized, if the mean is kept.
    mean: Option<Arc<[T]>>,
    u: Aligned<T>,
    between: Aligned<T>,
}

impl<T: Scalar + Transforms> Descent<T> {
    /// Starts at `v`.
    ///
    /// # Errors
    /// If a constant is out of its range, or a preconditioner is asked for on a box that is not
    /// periodic.
    ///
    /// # Panics
    /// If `v` has not one number per voxel.
    pub fn new(
        energy: Energy<T>,
        config: DescentConfig,
        mask: Option<Mask<T>>,
        v: Vec<T>,
    ) -> Result<Self> {
        let n = energy.voxels();
        assert_eq!(v.len(), n, "one number per voxel");
        let keep_mass = config.keep_mass || config.beta.is_some();
        if keep_mass && mask.is_some() {
            return Err(Error::Invalid(
                "the mean of u cannot be kept where u is given at some voxels".into(),
            ));
        }
        let shape = energy.config().shape;
        let edges = match energy.config().edges {
            Edges::Periodic => BlurEdges::Periodic,
            _ => BlurEdges::Replicate,
        };
        let mut blur = config.sigma.map(|sigma| Blur::new(shape, sigma, edges)).transpose()?;
        let inverse = config.beta.map(|beta| preconditioner(energy.config(), beta, -1.0));
        let inverse = inverse.transpose()?;
        let mut between = Aligned::new(n, T::zero());
        let mean = keep_mass.then(|| {
            let scale = 1.0 / (n as f64).sqrt();
            let mut mean = vec![<T as Real>::from_f64(scale); n];
            if let Some(blur) = &mut blur {
                blur.transpose(&mut mean, &mut between);
                let norm = total(&mean, |v| v * v).sqrt();
                mean.iter_mut().for_each(|v| *v = <T as Real>::from_f64(Real::to_f64(*v) / norm));
            }
            Arc::from(mean)
        });
        let solver = Lbfgs::new(config.lbfgs, v)?;
        let u = Aligned::new(n, T::zero());
        let mut function = Function { energy, blur, mask, mean, u, between };
        function.phase(solver.x());
        let turned = if inverse.is_some() { vec![T::zero(); n] } else { Vec::new() };
        Ok(Self { config, solver, function, inverse, turned, steps: 0, evaluations: 0 })
    }

    /// One step of L-BFGS: what it saw, and its length, 0 if no lower point was found.
    ///
    /// # Errors
    /// If the energy or its gradient is not finite at the start.
    pub fn step(&mut self) -> Result<(StepInfo, f64)> {
        let Self { solver, function, inverse, turned, .. } = self;
        let mean = function.mean.clone();
        let evaluate = |v: &[T], gradient: &mut [T]| function.evaluate(v, gradient);
        let mut precondition = inverse.as_mut().map(|inverse| {
            move |d: &mut [T]| {
                inverse.apply(d, turned);
                d.copy_from_slice(turned);
                project(mean.as_deref(), d);
            }
        });
        let step = solver
            .step(evaluate, precondition.as_mut().map(|apply| apply as &mut dyn FnMut(&mut [T])))?;
        self.function.phase(self.solver.x());
        let iteration = self.steps;
        self.steps += 1;
        self.evaluations += step.evaluations as u64;
        let info = StepInfo { iteration, energy: step.value, gradient_norm: step.gradient_norm };
        Ok((info.check()?, step.length))
    }

    /// The phase field, shape `[nz, ny, nx]`.
    pub fn phase(&self) -> &[T] {
        &self.function.u
    }

    /// The variable and the pairs of L-BFGS.
    pub fn solver(&self) -> &Lbfgs<T> {
        &self.solver
    }

    /// Its constants.
    pub fn config(&self) -> &DescentConfig {
        &self.config
    }

    /// Its energy's constants and measures.
    pub fn energy(&self) -> &Energy<T> {
        &self.function.energy
    }

    /// Steps and evaluations made.
    pub fn counts(&self) -> [u64; 2] {
        [self.steps, self.evaluations]
    }

    /// Takes up a state: v, the pairs, and [`Descent::counts`].
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn restore(&mut self, v: Vec<T>, pairs: Vec<(Vec<T>, Vec<T>)>, counts: [u64; 2]) {
        [self.steps, self.evaluations] = counts;
        self.solver.restore(v, pairs, self.steps);
        self.function.phase(self.solver.x());
    }
}

impl<T: Scalar> Function<T> {
    fn phase(&mut self, v: &[T]) {
        match &mut self.blur {
            Some(blur) => blur.apply(v, &mut self.between, &mut self.u),
            None => self.u.copy_from_slice(v),
        }
        if let Some(mask) = &self.mask {
            mask.fix(&mut self.u);
        }
    }

    fn evaluate(&mut self, v: &[T], gradient: &mut [T]) -> f64 {
        self.phase(v);
        let energy = self.energy.value_and_gradient(&self.u, gradient);
        if let Some(mask) = &self.mask {
            mask.clear(gradient);
        }
        if let Some(blur) = &mut self.blur {
            blur.transpose(gradient, &mut self.between);
        }
        project(self.mean.as_deref(), gradient);
        energy
    }
}

/// Takes out the part of `d` that changes the mean of u.
fn project<T: Scalar>(mean: Option<&[T]>, d: &mut [T]) {
    let Some(mean) = mean else { return };
    // Twice: in f32 the first leaves a rounding of the whole.
    for _ in 0..2 {
        let along: Vec<f64> = d
            .par_chunks(4096)
            .zip(mean.par_chunks(4096))
            .map(|(d, m)| d.iter().zip(m).map(|(d, m)| d.to_f64() * m.to_f64()).sum())
            .collect();
        let along = T::from_f64(along.iter().sum());
        d.par_iter_mut().zip(mean).for_each(|(d, &m)| *d = *d - along * m);
    }
}

/// Sum of `f` over all values.
fn total<T: Scalar>(values: &[T], f: impl Fn(f64) -> f64 + Sync) -> f64 {
    let values: Vec<f64> = values.iter().map(|v| v.to_f64()).collect();
    field::sum(&values, f)
}
