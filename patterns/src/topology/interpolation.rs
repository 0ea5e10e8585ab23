//! Stiffness as a function of density.

use super::config::{Config, Interpolation};

/// Stiffness relative to solid and its derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    kind: Interpolation,
    p: f64,
    void: f64,
}

impl Law {
    pub(super) fn new(config: &Config, p: f64) -> Self {
        Self { kind: config.interpolation, p, void: config.void_stiffness }
    }

    /// `E = void + x (1 - void)`: for solid parts of elements, and for black and white.
    pub(super) fn linear(void: f64) -> Self {
        Self { kind: Interpolation::Modified, p: 1.0, void }
    }

    /// E(x) for density x in [0, 1].
    pub(super) fn stiffness(self, x: f64) -> f64 {
        match self.kind {
            Interpolation::Simp => power(x, self.p),
            Interpolation::Modified => self.void + power(x, self.p) * (1.0 - self.void),
            Interpolation::Ramp => self.void + x / (1.0 + self.p * (1.0 - x)) * (1.0 - self.void),
        }
    }

    /// dE/dx.
    pub(super) fn derivative(self, x: f64) -> f64 {
        match self.kind {
            Interpolation::Simp => self.p * power(x, self.p - 1.0),
            Interpolation::Modified => self.p * power(x, self.p - 1.0) * (1.0 - self.void),
            Interpolation::Ramp => {
                let bottom = 1.0 + self.p * (1.0 - x);
                (1.0 + self.p) / (bottom * bottom) * (1.0 - self.void)
            }
        }
    }
}

/// x^p; whole exponents by products, whose bits are the same on every machine.
fn power(x: f64, p: f64) -> f64 {
    if p.fract() == 0.0 && p.abs() < 32.0 { x.powi(p as i32) } else { libm::pow(x, p) }
}
