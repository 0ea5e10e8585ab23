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

    /// The new mean gradient of a variable with gradient `g`.
    #[inline(always)]
    pub fn mean(&self, m: T, g: T) -> T {
        self.beta1 * m + self.rest1 * g
    }

    /// The new mean squared gradient of a variable with gradient `g`.
    #[inline(always)]
    pub fn square(&self, v: T, g: T) -> T {
        self.beta2 * v + self.rest2 * (g * g)
    }

    /// What a variable decreases by, given its new mean gradient and mean squared gradient.
    #[inline(always)]
    pub fn step(&self, m: T, v: T) -> T {
        self.rate * m / (v.sqrt() * self.scale + self.epsilon)
    }

    /// The new `(x, m, v)` of a variable with gradient `g`.
    #[inline(always)]
    pub fn next(&self, x: T, m: T, v: T, g: T) -> (T, T, T) {
        let (m, v) = (self.mean(m, g), self.square(v, g));
        (x - self.step(m, v), m, v)
    }

    /// Updates variables of a gradient; returns the sum of its squares. All slices have one
    /// length.
    #[inline(always)]
    pub fn update(&self, [x, m, v]: [&mut [T]; 3], gradient: &[T]) -> f64 {
        let zero = T::from_f64(0.0);
        let n = x.len();
        let gradient = &gradient[..n];
        let (x, m, v) = (&mut x[..n], &mut m[..n], &mut v[..n]);
        let mut squares = [zero; CHUNK];
        let whole = n / CHUNK * CHUNK;
        {
            let (x, m, v) = (x.as_chunks_mut().0, m.as_chunks_mut().0, v.as_chunks_mut().0);
            let gradient = gradient.as_chunks().0;
            for j in 0..n / CHUNK {
                let gs: &[T; CHUNK] = &gradient[j];
                let (mut xs, mut ms, mut vs): ([T; CHUNK], [T; CHUNK], [T; CHUNK]) =
                    (x[j], m[j], v[j]);
                for i in 0..CHUNK {
                    let g = gs[i];
                    squares[i] = squares[i] + g * g;
                    (xs[i], ms[i], vs[i]) = self.next(xs[i], ms[i], vs[i], g);
                }
                (x[j], m[j], v[j]) = (xs, ms, vs);
            }
        }
        for i in whole..n {
            let g = gradient[i];
            squares[i - whole] = squares[i - whole] + g * g;
            (x[i], m[i], v[i]) = self.next(x[i], m[i], v[i], g);
        }
        let mut sum = 0.0;
        for square in squares {
            sum += square.to_f64();
        }
        sum
    }
}
