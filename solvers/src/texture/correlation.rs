//! Two-point correlation of the visible pixels, and the spectrum of it.

use super::Masked;
use rustfft::{FftDirection, FftPlanner, num_complex::Complex};
use std::f64::consts::{PI, TAU};

/// Fewest visible pairs from which a lag's mean is taken.
const LEAST_PAIRS: f64 = 64.0;

/// Autocorrelation c at every lag up to `reach`.
#[derive(Clone, Debug)]
pub struct Correlation {
    /// Largest lag along an axis (pixels).
    pub reach: usize,
    /// c at lags (dy, dx) in [-reach, reach]^2, row by row; 0 where too few pairs are visible.
    values: Vec<f64>,
    /// Mean of c over the ring of each whole distance 0, 1, ... reach.
    pub radial: Vec<f64>,
}

impl Correlation {
    /// Of the visible pixels, up to `reach` pixels; none if they are of one colour.
    ///
    /// Numerator and denominator of `sum m(x) u(x) m(x + r) u(x + r) / sum m(x) m(x + r)`,
    /// u = ink - f, m = visibility, by padded Fourier transforms: O(n log n).
    pub fn new(picture: &Masked<'_>, reach: usize) -> Option<Self> {
        let f = picture.fraction()?;
        let weights = picture.weights();
        let real: Vec<f64> =
            picture.values().iter().zip(&weights).map(|(v, m)| m * (v - f)).collect();
        let imaginary = vec![0.0; real.len()];
        Self::of(picture.shape, [&real, &imaginary], &weights, reach)
    }

    /// Real part of the autocorrelation of a complex field that is 0 where hidden.
    pub(super) fn of(
        [ny, nx]: [usize; 2],
        [real, imaginary]: [&[f64]; 2],
        weights: &[f64],
        reach: usize,
    ) -> Option<Self> {
        let reach = reach.min(ny - 1).min(nx - 1);
        let padded = [ny, nx].map(|n| smooth_size(n + reach));
        let mut u = vec![Complex::default(); padded[0] * padded[1]];
        let mut m = u.clone();
        for j in 0..ny {
            for i in 0..nx {
                let (at, from) = (j * padded[1] + i, j * nx + i);
                u[at] = Complex::new(real[from], imaginary[from]);
                m[at] = Complex::new(weights[from], 0.0);
            }
        }
        let mut planner = FftPlanner::new();
        for values in [&mut u, &mut m] {
            fft(&mut planner, values, padded, FftDirection::Forward);
            values.iter_mut().for_each(|v| *v = Complex::new(v.norm_sqr(), 0.0));
        }
        // Both are power spectra, whose transforms' real parts are what is wanted.
        for values in [&mut u, &mut m] {
            fft(&mut planner, values, padded, FftDirection::Inverse);
        }
        let size = (padded[0] * padded[1]) as f64;
        let at = |dy: isize, dx: isize| {
            let row = dy.rem_euclid(padded[0] as isize) as usize;
            let column = dx.rem_euclid(padded[1] as isize) as usize;
            let n = row * padded[1] + column;
            (u[n].re / size, m[n].re / size)
        };
        let (sum, count) = at(0, 0);
        let variance = sum / count.max(1.0);
        if variance.is_nan() || variance <= 1e-9 {
            return None;
        }
        let r = reach as isize;
        let mut values = Vec::with_capacity((2 * reach + 1).pow(2));
        let mut rings = vec![(0.0, 0.0); reach + 1];
        for dy in -r..=r {
            for dx in -r..=r {
                let (sum, count) = at(dy, dx);
                let enough = count > LEAST_PAIRS;
                values.push(if enough { sum / count / variance } else { 0.0 });
                let ring = ((dy * dy + dx * dx) as f64).sqrt().round() as usize;
                if enough && ring <= reach {
                    rings[ring].0 += sum;
                    rings[ring].1 += count;
                }
            }
        }
        let mean =
            |&(sum, count): &(f64, f64)| if count > 0.0 { sum / count / variance } else { 0.0 };
        let radial = rings.iter().map(mean).collect();
        Some(Self { reach, values, radial })
    }

    /// c at distance `r` (pixels), averaged over directions; 0 beyond the reach.
    pub fn at(&self, r: f64) -> f64 {
        let n = r as usize;
        if n + 1 >= self.radial.len() {
            return 0.0;
        }
        let t = r - n as f64;
        (1.0 - t) * self.radial[n] + t * self.radial[n + 1]
    }

    /// Power at wave number `k` (1/pixel) up to a factor: the plane Fourier transform of c
    /// under a Hann taper as wide as the reach, as a Hankel transform over the rings.
    pub fn power(&self, k: f64) -> f64 {
        let reach = self.reach as f64;
        let term = |(r, c): (usize, &f64)| {
            let r = r as f64;
            let taper = 0.5 * (1.0 + libm::cos(PI * r / reach));
            // The disk of radius 1/2 around lag 0 has area pi/4 of a ring's 2 pi r.
            let area = if r == 0.0 { PI / 4.0 } else { TAU * r };
            area * c * taper * libm::j0(k * r)
        };
        self.radial.iter().enumerate().map(term).sum()
    }

    /// 2 pi over the wave number (pixels) at which the power is greatest, between a
    /// wavelength of 3 pixels and 1.2 times the reach.
    pub fn wavelength(&self) -> f64 {
        let low = TAU / (1.2 * self.reach as f64);
        let high = TAU / 3.0;
        let count = 240;
        let k = |n: usize| low * (high / low).powf(n as f64 / (count - 1) as f64);
        let power: Vec<f64> = (0..count).map(|n| self.power(k(n))).collect();
        let best = (0..count).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap_or(0);
        if best == 0 || best + 1 == count {
            return TAU / k(best);
        }
        // The vertex of the parabola through the three points, even in ln k.
        let (a, b, c) = (power[best - 1], power[best], power[best + 1]);
        let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
        TAU / (k(best) * (high / low).powf(shift / (count - 1) as f64))
    }

    /// `|sum c exp(i n theta)|` over the ring of distances `[low, high]` (pixels), divided by
    /// the number of lags, for n = 2, 4, 6: order of stripes, squares and hexagons.
    pub fn harmonics(&self, low: f64, high: f64) -> [f64; 3] {
        let r = self.reach as isize;
        let mut sums = [(0.0, 0.0); 3];
        let mut count = 0.0;
        for dy in 0..=r {
            for dx in -r..=r {
                let distance = ((dy * dy + dx * dx) as f64).sqrt();
                if distance < low || distance > high {
                    continue;
                }
                let c = self.values[((dy + r) * (2 * r + 1) + dx + r) as usize];
                let angle = libm::atan2(dy as f64, dx as f64);
                for (sum, n) in sums.iter_mut().zip([2.0, 4.0, 6.0]) {
                    sum.0 += c * libm::cos(n * angle);
                    sum.1 += c * libm::sin(n * angle);
                }
                count += 1.0;
            }
        }
        sums.map(|(x, y)| x.hypot(y) / f64::max(count, 1.0))
    }

    /// Direction in [0, pi) along which c falls most slowly within `radius`: of the stripes.
    pub fn direction(&self, radius: f64) -> f64 {
        let r = self.reach as isize;
        let (mut x, mut y) = (0.0, 0.0);
        for dy in -r..=r {
            for dx in -r..=r {
                let distance = ((dy * dy + dx * dx) as f64).sqrt();
                if distance > 0.0 && distance <= radius {
                    let c = self.values[((dy + r) * (2 * r + 1) + dx + r) as usize];
                    let angle = 2.0 * libm::atan2(dy as f64, dx as f64);
                    x += c * libm::cos(angle);
                    y += c * libm::sin(angle);
                }
            }
        }
        (0.5 * libm::atan2(y, x)).rem_euclid(PI)
    }
}

/// The least number of 2^a 3^b 5^c that is at least `n`.
pub(super) fn smooth_size(n: usize) -> usize {
    let smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    (n..).find(|&n| smooth(n)).unwrap_or(n)
}

/// Plane transform in place: rows, then columns.
fn fft(
    planner: &mut FftPlanner<f64>,
    values: &mut [Complex<f64>],
    [ny, nx]: [usize; 2],
    direction: FftDirection,
) {
    planner.plan_fft(nx, direction).process(values);
    let mut turned: Vec<Complex<f64>> =
        (0..nx).flat_map(|i| (0..ny).map(move |j| j * nx + i)).map(|n| values[n]).collect();
    planner.plan_fft(ny, direction).process(&mut turned);
    for (n, value) in turned.into_iter().enumerate() {
        values[n % ny * nx + n / ny] = value;
    }
}
