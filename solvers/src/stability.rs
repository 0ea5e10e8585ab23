//! Linear stability of homogeneous states: which waves grow, and how fast.
//!
//! | symbol | code         | meaning                                      | unit       |
//! |--------|--------------|----------------------------------------------|------------|
//! | J      | `jacobian`   | `d f_s / d u_r` at the steady state          | 1/time     |
//! | s      | `symbol`     | eigenvalue of minus the Laplacian, k^2       | 1/length^2 |
//! | sigma  | `growth`     | greatest real part of eig(J + diag L(s))     | 1/time     |
//! | omega  | `frequency`  | imaginary part of that eigenvalue, >= 0      | 1/time     |

use crate::diffusion::Reaction;
use crate::spectral::{LaplacianSymbol, LinearPart};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// A root of the reaction, as far as Newton's method came.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyState {
    /// Concentrations.
    pub u: Vec<f64>,
    /// Largest |f_s(u)|.
    pub residual: f64,
    /// Newton iterations done.
    pub iterations: usize,
    /// Whether the last step was below 1e-12 of the concentrations.
    pub converged: bool,
}

/// Iterations after which [`steady_state`] gives up; from a fair guess it needs less than ten.
const MAX_ITERATIONS: usize = 100;

/// Solves `f(u) = 0` by damped Newton iterations from `guess`, evaluating the reaction at `node`.
///
/// Steps are halved until the residual falls. Not converging is a status of the result.
///
/// # Errors
/// If `guess` has another number of species than the reaction or is not finite.
pub fn steady_state(reaction: &dyn Reaction, node: usize, guess: &[f64]) -> Result<SteadyState> {
    check_state(reaction, guess)?;
    let mut u = DVector::from_column_slice(guess);
    let mut f = rates(reaction, node, &u);
    let status = |u: &DVector<f64>, f: &DVector<f64>, iterations, converged| SteadyState {
        u: u.as_slice().to_vec(),
        residual: f.amax(),
        iterations,
        converged,
    };
    for iteration in 0..MAX_ITERATIONS {
        if f.amax() == 0.0 {
            return Ok(status(&u, &f, iteration, true));
        }
        let Some(full) = jacobian_at(reaction, node, &u).lu().solve(&f) else {
            return Ok(status(&u, &f, iteration, false));
        };
        let small = full.iter().zip(&u).all(|(d, u)| d.abs() <= 1e-12 * u.abs().max(1e-3));
        let damped = (0..40).find_map(|halvings| {
            let next = &u - &full * (-f64::from(halvings)).exp2();
            let residual = rates(reaction, node, &next);
            (residual.norm() < f.norm()).then_some((next, residual))
        });
        match damped {
            Some((next, residual)) => (u, f) = (next, residual),
            // At round-off no step makes the residual smaller.
            None => return Ok(status(&u, &f, iteration, small)),
        }
        if small {
            return Ok(status(&u, &f, iteration + 1, true));
        }
    }
    Ok(status(&u, &f, MAX_ITERATIONS, false))
}

/// A reaction made linear about a homogeneous state, with the linear part of each species.
#[derive(Clone, Debug)]
pub struct Linearization {
    jacobian: DMatrix<f64>,
    linear: Vec<LinearPart>,
}

/// The fastest eigenvalue of one wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Real part (1/time).
    pub growth: f64,
    /// Absolute imaginary part (1/time), 0 for waves that stand.
    pub frequency: f64,
}

/// Growth rate against wave number.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispersion {
    /// Wave number (1/length).
    pub wavenumber: Vec<f64>,
    /// Greatest growth rate of each wave (1/time).
    pub growth: Vec<f64>,
    /// Its frequency (1/time).
    pub frequency: Vec<f64>,
}

/// The fastest growing wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MostUnstable {
    /// Symbol of the Laplacian (1/length^2), the square of the wave number in the continuum.
    pub symbol: f64,
    /// Growth rate (1/time).
    pub growth: f64,
    /// Frequency (1/time).
    pub frequency: f64,
    /// What kind of instability it is.
    pub kind: Instability,
}

/// What becomes of small disturbances of a homogeneous state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instability {
    /// All decay.
    Stable,
    /// Stable without diffusion; standing waves of a finite wavelength grow.
    Turing,
    /// Stable without diffusion; oscillating waves of a finite wavelength grow.
    Wave,
    /// The homogeneous state itself oscillates with growing amplitude.
    Hopf,
    /// The homogeneous state itself departs without oscillation.
    Homogeneous,
}

impl Linearization {
    /// Linear about the state `u` at `node`, where the reaction should vanish.
    ///
    /// # Errors
    /// If `u` or `linear` has another length than the reaction has species, or the
    /// Jacobian is not finite.
    pub fn new(
        reaction: &dyn Reaction,
        node: usize,
        u: &[f64],
        linear: &[LinearPart],
    ) -> Result<Self> {
        check_state(reaction, u)?;
        let jacobian = jacobian_at(reaction, node, &DVector::from_column_slice(u));
        Self::from_jacobian(jacobian, linear)
    }

    /// With a known Jacobian.
    ///
    /// # Errors
    /// If it is not square with one row per linear part, or not finite.
    pub fn from_jacobian(jacobian: DMatrix<f64>, linear: &[LinearPart]) -> Result<Self> {
        let n = linear.len();
        if jacobian.shape() != (n, n) {
            return Err(Error::Shape {
                name: "Jacobian".into(),
                actual: vec![jacobian.nrows(), jacobian.ncols()],
                expected: vec![n, n],
            });
        }
        if let Some(&bad) = jacobian.iter().find(|v| !v.is_finite()) {
            return Err(Error::out_of_range("entry of the Jacobian", bad, "(-inf, inf)"));
        }
        Ok(Self { jacobian, linear: linear.to_vec() })
    }

    /// The Jacobian of the reaction, `d f_s / d u_r` at row s and column r.
    pub fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    /// The fastest eigenvalue of a wave with Laplacian symbol `s`.
    pub fn growth(&self, s: f64) -> Growth {
        let mut matrix = self.jacobian.clone();
        for (i, linear) in self.linear.iter().enumerate() {
            matrix[(i, i)] += linear.at(s);
        }
        let eigenvalues = matrix.complex_eigenvalues();
        let fastest = eigenvalues.iter().max_by(|a, b| a.re.total_cmp(&b.re));
        fastest.map_or(Growth { growth: f64::NAN, frequency: 0.0 }, |value| Growth {
            growth: value.re,
            frequency: value.im.abs(),
        })
    }

    /// Growth rates at `wavenumber` (1/length), along a grid axis with node distance `h`
    /// for the discrete Laplacians.
    pub fn dispersion(&self, laplacian: LaplacianSymbol, h: f64, wavenumber: &[f64]) -> Dispersion {
        let at = |&k: &f64| self.growth(laplacian.at([k, 0.0, 0.0], h));
        let growth: Vec<Growth> = wavenumber.iter().map(at).collect();
        Dispersion {
            wavenumber: wavenumber.to_vec(),
            growth: growth.iter().map(|g| g.growth).collect(),
            frequency: growth.iter().map(|g| g.frequency).collect(),
        }
    }

    /// The fastest growing wave with symbol up to `largest` (1/length^2), e.g.
    /// [`LaplacianSymbol::largest`] or, in the continuum, the square of the greatest wave
    /// number of interest.
    ///
    /// 2000 samples, half of them spaced as squares, then golden section around the best;
    /// s comes out to about the square root of round-off. Rates within 1e-12 of the
    /// Jacobian's size of 0 count as 0, and growth of 0 as unstable.
    pub fn most_unstable(&self, largest: f64) -> MostUnstable {
        const SAMPLES: usize = 2000;
        let sample = |m: usize| largest * (m as f64 / SAMPLES as f64).powi(2);
        let rate = |s: f64| self.growth(s).growth;
        let best = (0..=SAMPLES)
            .map(|m| (m, rate(sample(m))))
            .fold((0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best })
            .0;
        let (mut low, mut high) = (sample(best.saturating_sub(1)), sample((best + 1).min(SAMPLES)));
        let section = 0.5 * (5.0_f64.sqrt() - 1.0);
        while high - low > 1e-9 * high + 1e-14 * largest {
            let (a, b) = (high - section * (high - low), low + section * (high - low));
            if rate(a) >= rate(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let symbol = if best == 0 && rate(0.0) >= rate(low) { 0.0 } else { 0.5 * (low + high) };
        let Growth { growth, frequency } = self.growth(symbol);
        MostUnstable { symbol, growth, frequency, kind: self.kind(symbol) }
    }

    fn kind(&self, symbol: f64) -> Instability {
        let tolerance = 1e-12 * self.jacobian.amax();
        let (still, fastest) = (self.growth(0.0), self.growth(symbol));
        let oscillates = |g: Growth| g.frequency > tolerance;
        if still.growth > tolerance {
            return if oscillates(still) { Instability::Hopf } else { Instability::Homogeneous };
        }
        if fastest.growth < -tolerance || fastest.growth <= still.growth + tolerance {
            return Instability::Stable;
        }
        if oscillates(fastest) { Instability::Wave } else { Instability::Turing }
    }
}

impl MostUnstable {
    /// Wavelength `2 pi/k` (length) along a grid axis with node distance `h`; none if the
    /// homogeneous mode is the fastest or the grid has no such wave.
    pub fn axis_wavelength(&self, laplacian: LaplacianSymbol, h: f64) -> Option<f64> {
        wavelength(laplacian.axis_wavenumber(self.symbol, h))
    }

    /// Wavelength `2 pi/k` (length) with k averaged over the directions of `dim` dimensions.
    pub fn mean_wavelength(&self, laplacian: LaplacianSymbol, h: f64, dim: usize) -> Option<f64> {
        wavelength(laplacian.mean_wavenumber(self.symbol, h, dim))
    }
}

fn wavelength(wavenumber: Option<f64>) -> Option<f64> {
    wavenumber.filter(|&k| k > 0.0).map(|k| 2.0 * PI / k)
}

fn check_state(reaction: &dyn Reaction, u: &[f64]) -> Result<()> {
    if u.len() != reaction.species() {
        return Err(Error::Shape {
            name: "homogeneous state".into(),
            actual: vec![u.len()],
            expected: vec![reaction.species()],
        });
    }
    match u.iter().find(|v| !v.is_finite()) {
        Some(&bad) => Err(Error::out_of_range("homogeneous concentration", bad, "(-inf, inf)")),
        None => Ok(()),
    }
}

fn rates(reaction: &dyn Reaction, node: usize, u: &DVector<f64>) -> DVector<f64> {
    let mut f = DVector::zeros(u.len());
    let inputs: Vec<&[f64]> = u.as_slice().chunks(1).collect();
    let mut outputs: Vec<&mut [f64]> = f.as_mut_slice().chunks_mut(1).collect();
    reaction.rates(node, &inputs, &mut outputs);
    f
}

/// Central differences of fourth order: `(8 (f(+d) - f(-d)) - (f(+2d) - f(-2d))) / 12 d`.
///
/// With d = 1e-3 of the concentration the truncation d^4 f'''''/30 and the round-off
/// 1e-16 f/d are both about 1e-13.
fn jacobian_at(reaction: &dyn Reaction, node: usize, u: &DVector<f64>) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(u.len(), u.len());
    for r in 0..u.len() {
        // A power of two, so that u +- d and the division are exact where u is short.
        let d = (-10.0_f64).exp2() * u[r].abs().max(1e-3).log2().round().exp2();
        let at = |steps: f64| {
            let mut moved = u.clone();
            moved[r] += steps * d;
            rates(reaction, node, &moved)
        };
        let column = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * d);
        jacobian.set_column(r, &column);
    }
    jacobian
}

#[cfg(test)]
mod tests;
