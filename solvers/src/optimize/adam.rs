//! Adam.

use crate::{Error, Float, Result};
use serde::{Deserialize, Serialize};

/// Constants of [`Adam`]. Kingma and Ba 2015, with PyTorch's defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdamConfig {
    /// Step length where gradients keep their sign, positive.
    pub rate: f64,
    /// Share of the past in the mean gradient, in [0, 1).
    pub beta1: f64,
    /// Share of the past in the mean squared gradient, in [0, 1).
    pub beta2: f64,
    /// Gradient that counts as small, positive.
    pub epsilon: f64,
}

impl Default for AdamConfig {
    fn default() -> Self {
        Self { rate: 1e-3, beta1: 0.9, beta2: 0.999, epsilon: 1e-8 }
    }
}

impl AdamConfig {
    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self) -> Result<()> {
        for (name, value) in [("rate", self.rate), ("epsilon", self.epsilon)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::out_of_range(name, value, "(0, inf)"));
            }
        }
        for (name, value) in [("beta1", self.beta1), ("beta2", self.beta2)] {
            if !(0.0..1.0).contains(&value) {
                return Err(Error::out_of_range(name, value, "[0, 1)"));
            }
        }
        Ok(())
    }
}

/// One step of Adam for each variable on its own:
/// `m += (1 - beta1) (g - m)`, `v += (1 - beta2) (g^2 - v)`,
/// `x -= rate m / (1 - beta1^t) / (sqrt(v / (1 - beta2^t)) + epsilon)`.
///
/// Callers that know where their gradient comes from apply it while they have it at hand.
#[derive(Clone, Copy, Debug)]
pub struct Adam<T> {
    beta1: T,
    rest1: T,
    beta2: T,
    rest2: T,
    rate: T,
    scale: T,
    epsilon: T,
}

/// Variables that are updated together.
const CHUNK: usize = 16;

impl<T: Float> Adam<T> {
    /// Step number `t`, from 1.
    pub fn new(config: &AdamConfig, t: u64) -> Self {
        let power = |beta: f64| 1.0 - libm::pow(beta, t as f64);
        Self {
            beta1: T::from_f64(config.beta1),
            rest1: T::from_f64(1.0 - config.beta1),
            beta2: T::from_f64(config.beta2),
            rest2: T::from_f64(1.0 - config.beta2),
            rate: T::from_f64(config.rate / power(config.beta1)),
            scale: T::from_f64(1.0 / libm::sqrt(power(config.beta2))),
            epsilon: T::from_f64(config.epsilon),
        }
    }

    /// The new `(x, m, v)` of a variable with gradient `g`.
    #[inline(always)]
    pub fn next(&self, x: T, m: T, v: T, g: T) -> (T, T, T) {
        let m = self.beta1 * m + self.rest1 * g;
        let v = self.beta2 * v + self.rest2 * (g * g);
        (x - self.rate * m / (v.sqrt() * self.scale + self.epsilon), m, v)
    }

    /// Updates variables whose gradient is `factor (plus - minus)`; returns the sum of its
    /// squares. All slices have one length.
    #[inline(always)]
    pub fn update(&self, [x, m, v]: [&mut [T]; 3], [plus, minus]: [&[T]; 2], factor: T) -> f64 {
        let zero = T::from_f64(0.0);
        let n = x.len();
        let mut squares = [zero; CHUNK];
        for first in (0..n).step_by(CHUNK) {
            let len = CHUNK.min(n - first);
            let mut near = [[zero; CHUNK]; 5];
            if len == CHUNK {
                for (near, row) in near.iter_mut().zip([&*x, &*m, &*v, plus, minus]) {
                    near.copy_from_slice(&row[first..][..CHUNK]);
                }
            } else {
                for (near, row) in near.iter_mut().zip([&*x, &*m, &*v, plus, minus]) {
                    near[..len].copy_from_slice(&row[first..][..len]);
                }
            }
            let mut out = [[zero; CHUNK]; 3];
            for i in 0..CHUNK {
                let g = factor * (near[3][i] - near[4][i]);
                squares[i] = squares[i] + g * g;
                (out[0][i], out[1][i], out[2][i]) =
                    self.next(near[0][i], near[1][i], near[2][i], g);
            }
            if len == CHUNK {
                x[first..][..CHUNK].copy_from_slice(&out[0]);
                m[first..][..CHUNK].copy_from_slice(&out[1]);
                v[first..][..CHUNK].copy_from_slice(&out[2]);
            } else {
                x[first..].copy_from_slice(&out[0][..len]);
                m[first..].copy_from_slice(&out[1][..len]);
                v[first..].copy_from_slice(&out[2][..len]);
            }
        }
        squares.iter().map(|s| s.to_f64()).sum()
    }
}
