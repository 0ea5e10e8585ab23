//! The likeliest continuation of a texture into what is hidden, and random ones.

use super::Correlation;
use super::correlation::smooth_size;
use crate::random::{normal, stream};
use crate::spectral::Multiplier;
use crate::{Error, Result};
use std::f64::consts::PI;

/// White noise that pixels carry besides the texture, as a share of the spectrum's peak: it
/// also bounds the condition number of the system by its inverse.
const NUGGET: f64 = 0.01;

/// Relative residual at which the conjugate gradients stop: far below a grey level.
const RESIDUAL: f64 = 1e-4;

/// Most iterations; the residual falls to 1e-4 in about 5 / sqrt(nugget).
const ITERATIONS: usize = 200;

/// Entries of the table of the spectrum.
const TABLE: usize = 512;

/// Simple kriging (Chiles & Delfiner 2012, chapter 3) with the isotropic covariance C that
/// the visible pixels show.
///
/// The mean of a Gaussian field given the visible values minimizes `v' C^-1 v`, v = u - mean.
/// `C^-1` is diagonal in the Fourier basis of a box that is wider than the picture by the
/// reach of C; conjugate gradients over all that is not visible.
#[derive(Debug)]
pub struct Kriging {
    shape: [usize; 2],
    padded: [usize; 2],
    /// Whether a pixel of the box is not visible.
    free: Vec<bool>,
    visible: Vec<bool>,
    mean: f64,
    values: Vec<f64>,
    precision: Multiplier<f64>,
    root: Multiplier<f64>,
}

impl Kriging {
    /// For `values` of a picture of `shape` `[ny, nx]`, read where `visible`; covariances
    /// beyond `reach` (pixels) count as 0. None if the visible values are all the same.
    ///
    /// # Errors
    /// If a slice has not one entry per pixel, or an axis is shorter than 2 pixels.
    pub fn new(
        shape: [usize; 2],
        values: &[f64],
        visible: &[bool],
        reach: usize,
    ) -> Result<Option<Self>> {
        let [ny, nx] = shape;
        for (name, length) in [("values", values.len()), ("visible", visible.len())] {
            if length != ny * nx || ny.min(nx) < 2 {
                return Err(Error::Shape {
                    name: name.into(),
                    actual: vec![length],
                    expected: vec![ny.max(2), nx.max(2)],
                });
            }
        }
        let weights: Vec<f64> = visible.iter().map(|&v| f64::from(u8::from(v))).collect();
        let count: f64 = weights.iter().sum();
        let sum = |f: &dyn Fn(f64) -> f64| {
            values.iter().zip(&weights).map(|(&u, w)| if *w > 0.0 { f(u) } else { 0.0 }).sum()
        };
        let total: f64 = sum(&|u| u);
        let mean = total / count.max(1.0);
        let squares: f64 = sum(&|u| (u - mean).powi(2));
        let variance = squares / count.max(1.0);
        let centred: Vec<f64> =
            values.iter().zip(visible).map(|(&u, &v)| if v { u - mean } else { 0.0 }).collect();
        let zeros = vec![0.0; centred.len()];
        let reach = reach.min(ny - 1).min(nx - 1).max(1);
        let Some(c) = Correlation::of(shape, [&centred, &zeros], &weights, reach) else {
            return Ok(None);
        };
        let padded = shape.map(|n| smooth_size(n + reach));
        let spectrum = Spectrum::new(&c, padded, variance);
        let extent = [1, padded[0], padded[1]];
        let precision = Multiplier::new(extent, |k| 1.0 / (spectrum.at(k) + spectrum.nugget))?;
        let root = Multiplier::new(extent, |k| spectrum.at(k).sqrt())?;
        let inside = |n: usize| (n / padded[1] < ny && n % padded[1] < nx).then_some(n);
        let free = (0..padded[0] * padded[1])
            .map(|n| inside(n).is_none_or(|n| !visible[n / padded[1] * nx + n % padded[1]]))
            .collect();
        let visible = visible.to_vec();
        Ok(Some(Self { shape, padded, free, visible, mean, values: centred, precision, root }))
    }

    /// The mean given the visible values, which it repeats.
    pub fn mean(&mut self) -> Vec<f64> {
        let values = self.values.clone();
        let mut found = self.continuation(&values);
        found.iter_mut().for_each(|v| *v += self.mean);
        found
    }

    /// A random field of the same covariance given the visible values: the mean of them and
    /// the error that kriging makes on a field of white noise through the root of C.
    pub fn sample(&mut self, seed: u64, index: u64) -> Vec<f64> {
        let mut random = stream(seed, "kriging", index);
        let white: Vec<f64> = self.free.iter().map(|_| normal(&mut random)).collect();
        let mut field = white.clone();
        self.root.apply(&white, &mut field);
        let [ny, nx] = self.shape;
        let field: Vec<f64> =
            (0..ny * nx).map(|n| field[n / nx * self.padded[1] + n % nx]).collect();
        let known: Vec<f64> = self
            .values
            .iter()
            .zip(&field)
            .zip(&self.visible)
            .map(|((u, z), &seen)| if seen { u - z } else { 0.0 })
            .collect();
        let mut found = self.continuation(&known);
        for (n, value) in found.iter_mut().enumerate() {
            *value = self.mean + if self.visible[n] { self.values[n] } else { *value + field[n] };
        }
        found
    }

    /// `known` where visible, and what minimizes the energy elsewhere.
    fn continuation(&mut self, known: &[f64]) -> Vec<f64> {
        let [ny, nx] = self.shape;
        let width = self.padded[1];
        let n = self.free.len();
        let mut padded = vec![0.0; n];
        for j in 0..ny {
            padded[j * width..][..nx].copy_from_slice(&known[j * nx..][..nx]);
        }
        let free = &self.free;
        let mut apply = |x: &[f64], out: &mut Vec<f64>| {
            self.precision.apply(x, out);
            out.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(v, _)| *v = 0.0);
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (mut x, mut q) = (vec![0.0; n], vec![0.0; n]);
        apply(&padded, &mut q);
        let mut r: Vec<f64> = q.iter().map(|v| -v).collect();
        let mut p = r.clone();
        let first = dot(&r, &r);
        let mut square = first;
        for _ in 0..ITERATIONS {
            if square <= RESIDUAL * RESIDUAL * first {
                break;
            }
            apply(&p, &mut q);
            let step = square / dot(&p, &q);
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
            r.iter_mut().zip(&q).for_each(|(r, q)| *r -= step * q);
            let next = dot(&r, &r);
            p.iter_mut().zip(&r).for_each(|(p, r)| *p = r + next / square * *p);
            square = next;
        }
        (0..ny * nx)
            .map(|n| if self.visible[n] { known[n] } else { x[n / nx * width + n % nx] })
            .collect()
    }
}

/// The spectrum of a correlation, by wave number; its mean over the modes is the variance.
struct Spectrum {
    table: Vec<f64>,
    nugget: f64,
}

impl Spectrum {
    fn new(c: &Correlation, padded: [usize; 2], variance: f64) -> Self {
        // The tapered estimate can be negative by chance, a spectrum cannot.
        let mut table: Vec<f64> = (0..=TABLE)
            .map(|n| c.power(n as f64 * PI * std::f64::consts::SQRT_2 / TABLE as f64).max(0.0))
            .collect();
        let plain = Self { table: table.clone(), nugget: 0.0 };
        let modes = padded[0] * padded[1];
        let wave = |m: usize, n: usize| std::f64::consts::TAU * m as f64 / n as f64;
        let total: f64 = (0..modes)
            .map(|n| {
                plain.at([0.0, wave(n / padded[1], padded[0]), wave(n % padded[1], padded[1])])
            })
            .sum();
        let scale = variance * modes as f64 / total.max(f64::MIN_POSITIVE);
        table.iter_mut().for_each(|s| *s *= scale);
        let nugget = NUGGET * table.iter().fold(0.0_f64, |a, &b| a.max(b));
        Self { table, nugget }
    }

    /// At wave numbers `[0, ky, kx]` (1/pixel), in [0, 2 pi).
    fn at(&self, [_, ky, kx]: [f64; 3]) -> f64 {
        let fold = |k: f64| k.min(std::f64::consts::TAU - k);
        let k = fold(ky).hypot(fold(kx)) * TABLE as f64 / (PI * std::f64::consts::SQRT_2);
        let n = (k as usize).min(TABLE - 1);
        let t = k - n as f64;
        (1.0 - t) * self.table[n] + t * self.table[n + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of one wave number: a field that is predictable from its surroundings.
    fn waves(n: usize) -> Vec<f64> {
        let at = |m: usize| {
            let (x, y) = ((m % n) as f64, (m / n) as f64);
            let wave = |d: f64| libm::cos(0.7 * (x * libm::cos(d) + y * libm::sin(d)) + 5.0 * d);
            (0..7).map(|d| wave(0.45 * f64::from(d))).sum::<f64>()
        };
        (0..n * n).map(at).collect()
    }

    fn hole(n: usize, side: usize) -> Vec<bool> {
        let middle = (n - side) / 2..(n + side) / 2;
        (0..n * n).map(|m| !(middle.contains(&(m % n)) && middle.contains(&(m / n)))).collect()
    }

    fn error(a: &[f64], b: &[f64], visible: &[bool]) -> f64 {
        let pairs = a.iter().zip(b).zip(visible).filter(|(_, seen)| !**seen);
        let (sum, count) = pairs.fold((0.0, 0), |(s, c), ((a, b), _)| (s + (a - b).powi(2), c + 1));
        (sum / f64::from(count)).sqrt()
    }

    #[test]
    fn waves_are_continued_into_a_hole_of_a_wavelength() {
        let (u, visible) = (waves(64), hole(64, 9));
        let spread = error(&u, &vec![0.0; u.len()], &visible);
        let mut kriging = Kriging::new([64, 64], &u, &visible, 30).unwrap().unwrap();
        let mean = kriging.mean();
        assert!(error(&u, &mean, &visible) < 0.1 * spread, "{}", error(&u, &mean, &visible));
        assert!((0..u.len()).all(|n| !visible[n] || (mean[n] - u[n]).abs() < 1e-12));
    }

    #[test]
    fn samples_vary_as_much_as_the_texture_and_about_the_mean() {
        let (u, visible) = (waves(64), hole(64, 34));
        let mut kriging = Kriging::new([64, 64], &u, &visible, 30).unwrap().unwrap();
        let mean = kriging.mean();
        let samples: Vec<Vec<f64>> = (0..24).map(|n| kriging.sample(5, n)).collect();
        let average: Vec<f64> =
            (0..u.len()).map(|n| samples.iter().map(|s| s[n]).sum::<f64>() / 24.0).collect();
        let spread = samples.iter().map(|s| error(s, &mean, &visible)).sum::<f64>() / 24.0;
        // The mean of 24 independent errors is 1/sqrt(24) of one.
        assert!(error(&average, &mean, &visible) < 1.5 * spread / 24_f64.sqrt());
        let deviation = |f: &[f64]| {
            let centre = u.iter().sum::<f64>() / u.len() as f64;
            error(f, &vec![centre; f.len()], &visible)
        };
        let own = samples.iter().map(|s| deviation(s)).sum::<f64>() / 24.0;
        assert!((own / deviation(&u) - 1.0).abs() < 0.2, "{own} {}", deviation(&u));
    }

    #[test]
    fn one_value_has_no_covariance() {
        let visible = hole(16, 4);
        assert!(Kriging::new([16, 16], &[2.0; 256], &visible, 5).unwrap().is_none());
        assert!(Kriging::new([16, 16], &[2.0; 255], &visible, 5).is_err());
    }
}
