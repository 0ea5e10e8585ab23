//! One-dimensional real transforms of pairs of lines, by one complex FFT per pair.

use rustfft::{Fft, FftPlanner, num_complex::Complex64};
use std::f64::consts::PI;
use std::sync::Arc;

/// The basis functions of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Basis {
    /// cos and sin of `2 pi m x / L`: periodic lines.
    Fourier,
    /// cos of `pi m (x + h/2) / L`: lines mirrored at the outer faces (DCT-II).
    Cosine,
}

/// Real transforms of lines of `n` numbers.
///
/// Fourier coefficients are stored as `[R0, R1, I1, R2, I2, ...]` with
/// `R + i I = sum_j x_j exp(-2 pi i m j / n)`; cosine coefficients as
/// `C_m = sum_j x_j cos(pi m (2 j + 1) / 2 n)`.
#[derive(Clone)]
pub(super) struct Lines {
    n: usize,
    basis: Basis,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// `(cos, sin)` of `pi m / 2 n`, for the cosine basis.
    turns: Vec<(f64, f64)>,
}

/// Buffers of one worker.
pub(super) struct Buffers {
    z: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Lines {
    pub(super) fn new(n: usize, basis: Basis, planner: &mut FftPlanner<f64>) -> Self {
        let turn = |m: usize| (PI * m as f64 / (2 * n) as f64).sin_cos();
        let turns = match basis {
            Basis::Fourier => Vec::new(),
            Basis::Cosine => (0..=n / 2).map(turn).map(|(s, c)| (c, s)).collect(),
        };
        let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        Self { n, basis, forward, inverse, turns }
    }

    pub(super) fn len(&self) -> usize {
        self.n
    }

    pub(super) fn buffers(&self) -> Buffers {
        let scratch =
            self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        let zero = Complex64::new(0.0, 0.0);
        Buffers { z: vec![zero; self.n], scratch: vec![zero; scratch] }
    }

    /// Wave number of coefficient `m` in units of one over the node distance.
    pub(super) fn wavenumber(&self, m: usize) -> f64 {
        match self.basis {
            Basis::Fourier => 2.0 * PI * m.div_ceil(2) as f64 / self.n as f64,
            Basis::Cosine => PI * m as f64 / self.n as f64,
        }
    }

    /// Square of a coefficient times this, over `n^2`, is its part of the mean square.
    pub(super) fn weight(&self, m: usize) -> f64 {
        let nyquist = self.basis == Basis::Fourier && 2 * m.div_ceil(2) == self.n;
        if m == 0 || nyquist { 1.0 } else { 2.0 }
    }

    /// Transforms the real lines `x` and `y` in place.
    pub(super) fn forward(&self, x: &mut [f64], y: &mut [f64], buffers: &mut Buffers) {
        let (n, z) = (self.n, &mut buffers.z);
        match self.basis {
            Basis::Fourier => {
                for ((z, &x), &y) in z.iter_mut().zip(&*x).zip(&*y) {
                    *z = Complex64::new(x, y);
                }
            }
            // Even samples forwards, odd samples backwards: Makhoul 1980.
            Basis::Cosine => {
                for m in 0..n.div_ceil(2) {
                    z[m] = Complex64::new(x[2 * m], y[2 * m]);
                }
                for m in 0..n / 2 {
                    z[n - 1 - m] = Complex64::new(x[2 * m + 1], y[2 * m + 1]);
                }
            }
        }
        self.forward.process_with_scratch(z, &mut buffers.scratch);
        (x[0], y[0]) = (z[0].re, z[0].im);
        for m in 1..n.div_ceil(2) {
            let (p, q) = (z[m], z[n - m]);
            let (xr, xi) = (0.5 * (p.re + q.re), 0.5 * (p.im - q.im));
            let (yr, yi) = (0.5 * (p.im + q.im), 0.5 * (q.re - p.re));
            match self.basis {
                Basis::Fourier => {
                    (x[2 * m - 1], x[2 * m]) = (xr, xi);
                    (y[2 * m - 1], y[2 * m]) = (yr, yi);
                }
                Basis::Cosine => {
                    let (c, s) = self.turns[m];
                    (x[m], x[n - m]) = (c * xr + s * xi, s * xr - c * xi);
                    (y[m], y[n - m]) = (c * yr + s * yi, s * yr - c * yi);
                }
            }
        }
        if n.is_multiple_of(2) {
            let (middle, scale) = self.middle();
            (x[middle], y[middle]) = (scale * z[n / 2].re, scale * z[n / 2].im);
        }
    }

    /// Undoes [`Lines::forward`].
    pub(super) fn inverse(&self, x: &mut [f64], y: &mut [f64], buffers: &mut Buffers) {
        let (n, z) = (self.n, &mut buffers.z);
        let scale = 1.0 / n as f64;
        z[0] = Complex64::new(x[0], y[0]) * scale;
        for m in 1..n.div_ceil(2) {
            let (xr, xi, yr, yi) = match self.basis {
                Basis::Fourier => (x[2 * m - 1], x[2 * m], y[2 * m - 1], y[2 * m]),
                Basis::Cosine => {
                    let (c, s) = self.turns[m];
                    let (x, xn, y, yn) = (x[m], x[n - m], y[m], y[n - m]);
                    (c * x + s * xn, s * x - c * xn, c * y + s * yn, s * y - c * yn)
                }
            };
            z[m] = Complex64::new(xr - yi, xi + yr) * scale;
            z[n - m] = Complex64::new(xr + yi, yr - xi) * scale;
        }
        if n.is_multiple_of(2) {
            let (middle, turn) = self.middle();
            z[n / 2] = Complex64::new(x[middle], y[middle]) * (scale / turn);
        }
        self.inverse.process_with_scratch(z, &mut buffers.scratch);
        match self.basis {
            Basis::Fourier => {
                for ((z, x), y) in z.iter().zip(x).zip(y) {
                    (*x, *y) = (z.re, z.im);
                }
            }
            Basis::Cosine => {
                for m in 0..n.div_ceil(2) {
                    (x[2 * m], y[2 * m]) = (z[m].re, z[m].im);
                }
                for m in 0..n / 2 {
                    (x[2 * m + 1], y[2 * m + 1]) = (z[n - 1 - m].re, z[n - 1 - m].im);
                }
            }
        }
    }

    /// Where the coefficient of FFT mode n/2 is stored, and its factor.
    fn middle(&self) -> (usize, f64) {
        match self.basis {
            Basis::Fourier => (self.n - 1, 1.0),
            Basis::Cosine => (self.n / 2, std::f64::consts::FRAC_1_SQRT_2),
        }
    }
}

impl std::fmt::Debug for Lines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Lines {{ n: {}, basis: {:?} }}", self.n, self.basis)
    }
}
