//! Eigenvalues of Laplacians on plane waves.

use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Which Laplacian a wave sees: s(k) >= 0 with `laplacian exp(i k x) = -s(k) exp(i k x)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LaplacianSymbol {
    /// The derivative itself: `s = |k|^2`.
    #[default]
    Continuous,
    /// Nearest neighbours (3, 5 or 7 points): `s = sum_i s_i`, `s_i = (2 - 2 cos k_i h)/h^2`.
    Axes,
    /// Nearest and diagonal neighbours weighted 4:1 (9 points in 2D, 19 in 3D):
    /// `s = sum_i s_i - h^2/6 sum_{i<j} s_i s_j`, whose h^2 error is the same in all directions.
    Isotropic,
}

impl LaplacianSymbol {
    /// s at wave number `k` (1/length), with node distance `h`, in 1/length^2.
    pub fn at(self, k: [f64; 3], h: f64) -> f64 {
        let sine = |k: f64| 2.0 / h * (0.5 * k * h).sin();
        let [x, y, z] = match self {
            Self::Continuous => k.map(|k| k * k),
            _ => k.map(|k| sine(k).powi(2)),
        };
        match self {
            Self::Isotropic => x + y + z - h * h / 6.0 * (x * y + y * z + z * x),
            _ => x + y + z,
        }
    }

    /// The largest s in `dim` dimensions; infinite for [`LaplacianSymbol::Continuous`].
    pub fn largest(self, dim: usize, h: f64) -> f64 {
        match (self, dim) {
            (Self::Continuous, _) => f64::INFINITY,
            (Self::Axes, _) => 4.0 * dim as f64 / (h * h),
            // At one Nyquist axis 4, at two 8 - 16/6, at three 12 - 3 * 16/6 = 4.
            (Self::Isotropic, 1) => 4.0 / (h * h),
            (Self::Isotropic, _) => 16.0 / (3.0 * h * h),
        }
    }
}

impl LaplacianSymbol {
    /// Wave number (1/length) along a grid axis at which the symbol is `s`; none if there is no such wave.
    pub fn axis_wavenumber(self, s: f64, h: f64) -> Option<f64> {
        let k = match self {
            Self::Continuous => s.sqrt(),
            _ => 2.0 / h * (0.5 * h * s.sqrt()).asin(),
        };
        k.is_finite().then_some(k)
    }

    /// Wave number (1/length) at which the symbol is `s`, averaged over all directions of
    /// `dim` dimensions; none if some direction has no such wave.
    pub fn mean_wavenumber(self, s: f64, h: f64, dim: usize) -> Option<f64> {
        /// Directions per quarter turn; the smooth average is then exact to 1e-12.
        const DIRECTIONS: usize = 32;
        if self == Self::Continuous || dim < 2 {
            return self.axis_wavenumber(s, h);
        }
        let angle = |a: usize| (a as f64 + 0.5) / DIRECTIONS as f64 * FRAC_PI_2;
        let (mut sum, mut weight) = (0.0, 0.0);
        for azimuth in (0..DIRECTIONS).map(angle) {
            for b in 0..if dim == 2 { 1 } else { DIRECTIONS } {
                // In three dimensions the midpoint rule in cos(polar angle).
                let z = if dim == 2 { 0.0 } else { (b as f64 + 0.5) / DIRECTIONS as f64 };
                let r = (1.0_f64 - z * z).sqrt();
                sum += self.ray_wavenumber(s, h, [r * azimuth.cos(), r * azimuth.sin(), z])?;
                weight += 1.0;
            }
        }
        Some(sum / weight)
    }

    /// Bisection along a ray of unit `direction`, up to the first Nyquist plane.
    fn ray_wavenumber(self, s: f64, h: f64, direction: [f64; 3]) -> Option<f64> {
        let at = |k: f64| self.at(direction.map(|d| d * k), h);
        let (mut low, mut high) = (0.0, PI / h / direction.iter().copied().fold(0.0, f64::max));
        if !(s >= 0.0 && s <= at(high)) {
            return None;
        }
        while (high - low) > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            *(if at(middle) < s { &mut low } else { &mut high }) = middle;
        }
        Some(0.5 * (low + high))
    }
}

/// The linear part of a species as a function of the Laplacian's symbol: a wave with
/// symbol s grows at rate L(s) (1/time) if nothing else acts.
#[derive(Clone)]
pub struct LinearPart(Arc<dyn Fn(f64) -> f64 + Send + Sync>);

impl LinearPart {
    /// Any function of s = |k|^2, e.g. `r - (1 - s)^2` for Swift-Hohenberg.
    pub fn new(rate: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(rate))
    }

    /// Diffusion, `L(s) = -d s`, with `d` in length^2/time.
    pub fn diffusion(d: f64) -> Self {
        Self::new(move |s| -d * s)
    }

    /// L(s), 1/time.
    pub fn at(&self, s: f64) -> f64 {
        (self.0)(s)
    }
}

impl std::fmt::Debug for LinearPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "LinearPart {{ L(0): {}, L(1): {} }}", self.at(0.0), self.at(1.0))
    }
}
