//! Exponential time differencing of fourth order.

use super::Reaction;
use super::rates::{self, combine};
use crate::spectral::{LaplacianSymbol, LinearPart, Transform};
use crate::{Boundary, Error, Grid, Result};
use rayon::prelude::*;
use std::f64::consts::PI;

/// How an [`Etdrk4`] steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Etdrk4Config {
    /// Time step; accuracy limits it, not diffusion.
    pub dt: f64,
    /// The Laplacian of the linear parts.
    pub laplacian: LaplacianSymbol,
    /// Whether to remove all waves beyond 2/3 of the Nyquist wave number of an axis, so
    /// that quadratic rates are free of aliases.
    pub dealias: bool,
}

/// `du_s/dt = L_s u_s + f_s(u, x)` by ETDRK4 (Cox and Matthews 2002, eqs. 26-29).
///
/// The linear parts, functions of the Laplacian, are solved exactly, so that stiffness
/// limits no step; four evaluations of f give fourth order. Works in the Fourier
/// series on periodic grids and, for mirror boundaries, in the cosine series. There is no
/// hidden state: a step depends on `u` alone.
#[derive(Clone, Debug)]
pub struct Etdrk4 {
    transform: Transform,
    dt: f64,
    linear: Vec<LinearPart>,
    /// The Laplacian of each mode at the start, NaN for waves that are removed.
    symbols: Vec<f64>,
    species: Vec<Coefficients>,
    /// Coefficients of u, of f(u), of stage a, and of f(a) + f(b), per species.
    v: Vec<Vec<f64>>,
    nv: Vec<Vec<f64>>,
    a: Vec<Vec<f64>>,
    nab: Vec<Vec<f64>>,
    stage: Vec<Vec<f64>>,
    rates: Vec<Vec<f64>>,
    modes: Vec<f64>,
}

/// Factors of every mode; `f2` multiplies f(a) + f(b).
#[derive(Clone, Debug, Default)]
struct Coefficients {
    e: Vec<f64>,
    e2: Vec<f64>,
    q: Vec<f64>,
    f1: Vec<f64>,
    f2: Vec<f64>,
    f3: Vec<f64>,
}

impl Etdrk4 {
    /// A stepper for as many species as there are linear parts.
    ///
    /// # Errors
    /// If `dt` is not positive, a linear part is not finite, or the boundary is extrapolated.
    pub fn new(
        grid: Grid,
        boundary: Boundary,
        linear: &[LinearPart],
        config: Etdrk4Config,
    ) -> Result<Self> {
        rates::check_dt(config.dt)?;
        let transform = Transform::new(grid, boundary)?;
        let Etdrk4Config { dt, laplacian, dealias } = config;
        let highest = if dealias { 2.0 / 3.0 * PI / grid.spacing() } else { f64::INFINITY };
        let symbols = transform.map_modes(|k| {
            let removed = k.iter().any(|&k| k > highest);
            if removed { f64::NAN } else { laplacian.at(k, grid.spacing()) }
        });
        let fields = || vec![vec![0.0; grid.len()]; linear.len()];
        let mut stepper = Self {
            transform,
            dt,
            linear: linear.to_vec(),
            symbols,
            species: vec![Coefficients::default(); linear.len()],
            v: fields(),
            nv: fields(),
            a: fields(),
            nab: fields(),
            stage: fields(),
            rates: fields(),
            modes: vec![0.0; grid.len()],
        };
        stepper.scale_laplacian(1.0)?;
        Ok(stepper)
    }

    /// From now on the Laplacian in all linear parts is `factor` times that of the start, as
    /// on a domain that has grown: `L(factor s)` instead of `L(s)`.
    ///
    /// # Errors
    /// If a linear part is not finite there.
    pub fn scale_laplacian(&mut self, factor: f64) -> Result<()> {
        for (coefficients, linear) in self.species.iter_mut().zip(&self.linear) {
            coefficients.set(&self.symbols, linear, factor, self.dt)?;
        }
        Ok(())
    }

    /// Advances `u`, one field per species, by one time step.
    ///
    /// # Errors
    /// If the number of species or a length does not fit.
    pub fn step(&mut self, reaction: &dyn Reaction, u: &mut [Vec<f64>]) -> Result<()> {
        let Self { transform, species, v, nv, a, nab, stage, rates, modes, .. } = self;
        rates::check(transform.grid(), species.len(), reaction, u)?;
        rates::evaluate(reaction, u, rates);
        for (s, c) in species.iter().enumerate() {
            transform.forward(&u[s], &mut v[s]);
            transform.forward(&rates[s], &mut nv[s]);
            combine(&mut a[s], [&c.e2, &v[s], &c.q, &nv[s]], |_, [e, v, q, n]| e * v + q * n);
            modes.copy_from_slice(&a[s]);
            transform.inverse(modes, &mut stage[s]);
        }
        rates::evaluate(reaction, stage, rates);
        for (s, c) in species.iter().enumerate() {
            transform.forward(&rates[s], &mut nab[s]);
            combine(modes, [&c.e2, &v[s], &c.q, &nab[s]], |_, [e, v, q, n]| e * v + q * n);
            transform.inverse(modes, &mut stage[s]);
        }
        rates::evaluate(reaction, stage, rates);
        for (s, c) in species.iter().enumerate() {
            transform.forward(&rates[s], modes);
            combine(&mut nab[s], [modes], |na, [nb]| na + nb);
            combine(modes, [&c.e2, &a[s], &c.q, &nv[s]], |nb, [e, a, q, n]| {
                e * a + q * (2.0 * nb - n)
            });
            transform.inverse(modes, &mut stage[s]);
        }
        rates::evaluate(reaction, stage, rates);
        for (s, c) in species.iter().enumerate() {
            transform.forward(&rates[s], modes);
            let inputs = [&c.e[..], &v[s], &c.f1, &nv[s], &c.f2, &nab[s], &c.f3];
            combine(modes, inputs, |nc, [e, v, f1, nv, f2, nab, f3]| {
                e * v + f1 * nv + f2 * nab + f3 * nc
            });
            transform.inverse(modes, &mut u[s]);
        }
        Ok(())
    }
}

impl Coefficients {
    /// The factors of all modes, at `factor` times the Laplacian's `symbols`.
    fn set(&mut self, symbols: &[f64], linear: &LinearPart, factor: f64, dt: f64) -> Result<()> {
        let row = |&symbol: &f64| {
            // A factor of zero keeps a wave out of every stage and of the result.
            if symbol.is_nan() { [0.0; 6] } else { factors(linear.at(factor * symbol) * dt) }
        };
        let rows: Vec<[f64; 6]> = symbols.par_iter().map(row).collect();
        if let Some(bad) = rows.iter().flatten().find(|v| !v.is_finite()) {
            return Err(Error::out_of_range("factor of a linear part", *bad, "(-inf, inf)"));
        }
        let columns =
            [&mut self.e, &mut self.e2, &mut self.q, &mut self.f1, &mut self.f2, &mut self.f3];
        for (c, column) in columns.into_iter().enumerate() {
            let scale = if c < 2 { 1.0 } else { dt };
            column.clear();
            column.extend(rows.iter().map(|row| scale * row[c]));
        }
        Ok(())
    }
}

/// `[exp z, exp z/2, Q, f1, f2, f3]` at `z = L dt`, the last four over dt.
///
/// Cox and Matthews' formulas cancel near z = 0. Kassam and Trefethen (2005) average them
/// over a circle; here they are sums of `phi_n(z) = sum_j z^j / (j + n)!`, which has
/// the same values to round-off at a hundredth of the cost.
fn factors(z: f64) -> [f64; 6] {
    let [p1, p2, p3] = if z.abs() < 1.0 {
        // The series of phi_3, of which 1/20! is left out, and the recurrence downwards.
        let p3 = (4..20).rev().fold(1.0, |sum, j| 1.0 + z * sum / f64::from(j)) / 6.0;
        let p2 = 0.5 + z * p3;
        [1.0 + z * p2, p2, p3]
    } else {
        let p1 = z.exp_m1() / z;
        let p2 = (p1 - 1.0) / z;
        [p1, p2, (p2 - 0.5) / z]
    };
    let q = if z == 0.0 { 0.5 } else { (0.5 * z).exp_m1() / z };
    let weights = [p1 - 3.0 * p2 + 4.0 * p3, 2.0 * p2 - 4.0 * p3, 4.0 * p3 - p2];
    [z.exp(), (0.5 * z).exp(), q, weights[0], weights[1], weights[2]]
}

#[cfg(test)]
mod tests {
    use super::factors;
    use rustfft::num_complex::Complex64;
    use std::f64::consts::PI;

    /// The factors against the published formulas, averaged over a circle of radius 2
    /// that stays at least 0.5 away from 0.
    #[test]
    fn factors_match_their_contour_integrals() {
        let formulas = |z: Complex64| {
            let (e, z2, z3) = (z.exp(), z * z, z * z * z);
            [
                ((0.5 * z).exp() - 1.0) / z,
                (-4.0 - z + e * (4.0 - 3.0 * z + z2)) / z3,
                2.0 * (2.0 + z + e * (z - 2.0)) / z3,
                (-4.0 - 3.0 * z - z2 + e * (4.0 - z)) / z3,
            ]
        };
        for z in [-60.0, -5.0, -1.5, -1.0, -0.99, -0.3, -1e-9, 0.0, 1e-5, 0.7, 1.0, 1.2] {
            let mut wanted = [0.0; 4];
            for m in 0..32 {
                let angle = PI * (f64::from(m) + 0.5) / 32.0;
                let f = formulas(z + Complex64::from_polar(2.0, angle));
                (0..4).for_each(|i| wanted[i] += f[i].re / 32.0);
            }
            for (found, wanted) in factors(z)[2..].iter().zip(wanted) {
                // On the circle terms of size 100 are divided by z^3 of at least 1/8.
                assert!((found - wanted).abs() < 1e-13, "z = {z}: {found} {wanted}");
            }
        }
    }
}
