//! From design variables to physical densities, and gradients back.

use super::{
    build::Problem,
    config::{Config, Filter, Projection, Rules},
    filter::Smoothing,
    problem::Material,
};
use crate::Result;

/// Filter, projection, fixed material.
pub(super) struct Design {
    smoothing: Smoothing,
    /// Whether the filter acts on the densities (or on the sensitivities).
    filters_density: bool,
    filters_sensitivity: bool,
    projection: Option<Projection>,
    passive: Vec<Option<Material>>,
    /// Density of void.
    least: f64,
    filtered: Vec<f64>,
    work: Vec<f64>,
}

/// The steps of a robust design, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variant {
    /// The design that is written.
    Intermediate,
    /// Thinner.
    Eroded,
    /// Thicker.
    Dilated,
}

impl Design {
    pub(super) fn new(config: &Config, problem: &Problem) -> Result<Self> {
        let n = problem.grid.len();
        Ok(Self {
            smoothing: Smoothing::new(config, problem)?,
            filters_density: matches!(config.filter, Filter::Density | Filter::Helmholtz),
            filters_sensitivity: config.filter == Filter::Sensitivity,
            projection: config.projection,
            passive: problem.passive.clone(),
            least: if config.rules == Rules::Lines99 { 1e-3 } else { 0.0 },
            filtered: vec![0.0; n],
            work: vec![0.0; n],
        })
    }

    /// Density of void: 0.001 by the 99 rules, else 0.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    /// Density of an element whose material is fixed.
    pub(super) fn fixed(&self, element: usize) -> Option<f64> {
        self.passive[element].map(|material| match material {
            Material::Solid => 1.0,
            Material::Void => self.least,
        })
    }

    /// Physical densities of the design `x` at step sharpness `beta`.
    pub(super) fn physical(
        &mut self,
        x: &[f64],
        beta: f64,
        variant: Variant,
        rho: &mut [f64],
    ) -> Result<()> {
        if self.filters_density {
            self.smoothing.average(x, rho)?;
            self.filtered.copy_from_slice(rho);
        } else {
            rho.copy_from_slice(x);
        }
        if let Some(eta) = self.threshold(beta, variant) {
            rho.iter_mut().for_each(|v| *v = step(*v, beta, eta));
        }
        self.fix(rho);
        Ok(())
    }

    /// Writes the fixed material over a design.
    pub(super) fn fix(&self, rho: &mut [f64]) {
        for (element, rho) in rho.iter_mut().enumerate() {
            if let Some(value) = self.fixed(element) {
                *rho = value;
            }
        }
    }

    /// Density of the step, from the filtered densities last computed.
    fn threshold(&self, beta: f64, variant: Variant) -> Option<f64> {
        let projection = self.projection?;
        let shift = match variant {
            Variant::Intermediate => 0.0,
            Variant::Eroded => projection.delta,
            Variant::Dilated => -projection.delta,
        };
        if !projection.preserve_volume {
            return Some(projection.eta + shift);
        }
        // The step lowers the volume as eta rises: bisection to rounding.
        let target: f64 = self.filtered.iter().sum();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..50 {
            let eta = 0.5 * (low + high);
            let volume: f64 = self.filtered.iter().map(|&v| step(v, beta, eta)).sum();
            if volume > target { low = eta } else { high = eta }
        }
        Some((0.5 * (low + high) + shift).clamp(0.0, 1.0))
    }

    /// Turns a gradient by the physical densities of `x` into one by `x`, in place.
    /// `physical` was last called for the same `x`, `beta` and `variant`.
    ///
    /// With `preserve_volume` the step's density counts as constant, as in top99neo.
    pub(super) fn chain(
        &mut self,
        beta: f64,
        variant: Variant,
        gradient: &mut [f64],
    ) -> Result<()> {
        for (element, g) in gradient.iter_mut().enumerate() {
            if self.passive[element].is_some() {
                *g = 0.0;
            }
        }
        if let Some(eta) = self.threshold(beta, variant) {
            for (g, &v) in gradient.iter_mut().zip(&self.filtered) {
                *g *= step_derivative(v, beta, eta);
            }
        }
        if self.filters_density {
            self.work.copy_from_slice(gradient);
            self.smoothing.transpose(&self.work, gradient)?;
        }
        Ok(())
    }

    /// The sensitivity filter, if it is the one; `gradient` is that of the objective.
    pub(super) fn filter_sensitivity(&mut self, x: &[f64], gradient: &mut [f64]) {
        if let (true, Smoothing::Cone(cone)) = (self.filters_sensitivity, &mut self.smoothing) {
            cone.sensitivity(x, gradient);
        }
    }
}

/// Smooth step from 0 to 1: Wang, Lazarov & Sigmund 2011, eq. (4).
pub(super) fn step(x: f64, beta: f64, eta: f64) -> f64 {
    let (low, high) = (libm::tanh(beta * eta), libm::tanh(beta * (1.0 - eta)));
    (low + libm::tanh(beta * (x - eta))) / (low + high)
}

/// Its derivative by x.
pub(super) fn step_derivative(x: f64, beta: f64, eta: f64) -> f64 {
    let (low, high) = (libm::tanh(beta * eta), libm::tanh(beta * (1.0 - eta)));
    let t = libm::tanh(beta * (x - eta));
    beta * (1.0 - t * t) / (low + high)
}
