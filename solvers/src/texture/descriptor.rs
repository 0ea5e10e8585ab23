//! One vector of numbers that tells patterns apart whatever their scale and direction.

use super::{Correlation, LevelSets, Masked, lineal_path, normalized_convolution};
use std::f64::consts::TAU;

/// Distances (wavelengths) at which c is read.
const DISTANCES: [f64; 14] =
    [0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.05, 1.2, 1.4, 1.6, 1.8, 2.0, 2.25, 2.5];

/// Wave numbers (of the peak's) at which the power is read, relative to the peak's.
const WAVENUMBERS: [f64; 10] = [0.25, 0.5, 0.7, 0.85, 1.15, 1.3, 1.5, 1.75, 2.0, 2.5];

/// Rings (wavelengths) whose angular harmonics are read.
const RINGS: [[f64; 2]; 3] = [[0.3, 0.7], [0.8, 1.2], [1.7, 2.3]];

/// Widths (wavelengths) of the Gaussians before level sets are measured.
const WIDTHS: [f64; 2] = [0.1, 0.22];

/// Levels of the sets, symmetric about 1/2.
const LEVELS: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];

/// Quantiles of the curvature, symmetric about 1/2.
const SHARES: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 0.9];

/// Lengths (wavelengths) of the segments of the lineal path.
const SEGMENTS: [f64; 5] = [0.25, 0.4, 0.6, 0.9, 1.3];

/// Distances (wavelengths) over which directions are compared.
const TURNS: [f64; 3] = [0.5, 1.0, 2.0];

/// Where the groups of a descriptor begin.
const LEVELS_AT: usize = 1 + 14 + 10 + 9;
const CURVATURE_AT: usize = LEVELS_AT + 2 * 5 * 3;
const PATHS_AT: usize = CURVATURE_AT + 5;
const TURNS_AT: usize = PATHS_AT + 2 * 5;
const LENGTH: usize = TURNS_AT + 4;

/// The groups of a descriptor, in order, with their lengths.
pub const NAMES: [(&str, usize); 8] = [
    ("ink fraction", 1),
    ("two-point correlation", 14),
    ("radial power", 10),
    ("angular harmonics", 9),
    ("level sets", 30),
    ("curvature", 5),
    ("lineal paths", 10),
    ("directions", 4),
];

/// Statistics of a picture: dimensionless, the same for every scale and direction up to sampling.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    /// The statistics, in the order of [`NAMES`].
    pub values: Vec<f64>,
    /// The scale by which they are made dimensionless (pixels).
    pub wavelength: f64,
    /// Direction of stripes in [0, pi), from x towards y (downwards).
    pub direction: f64,
}

impl Descriptor {
    /// Of the visible part; none if it is of one colour or too small for a correlation.
    ///
    /// Six plane Fourier transforms of twice the picture; 60 ms for 256x256 on one core.
    pub fn new(picture: &Masked<'_>) -> Option<Self> {
        let [ny, nx] = picture.shape;
        if ny.min(nx) < 16 {
            return None;
        }
        let f = picture.fraction()?;
        let c = Correlation::new(picture, (ny.min(nx) / 2).min(96))?;
        let wavelength = c.wavelength();
        let mut values = Vec::with_capacity(LENGTH);
        values.push(f);
        values.extend(DISTANCES.map(|r| c.at(r * wavelength)));
        let k = TAU / wavelength;
        let peak = c.power(k).max(1e-9);
        values.extend(WAVENUMBERS.map(|m| c.power(m * k) / peak));
        for [low, high] in RINGS {
            values.extend(c.harmonics(low * wavelength, high * wavelength));
        }
        let mut fine = None;
        for width in WIDTHS {
            let sets = LevelSets::new(picture, (width * wavelength).max(0.6));
            for level in LEVELS {
                let d = sets.densities(level);
                values.extend([d.area, d.perimeter * wavelength, d.euler * wavelength.powi(2)]);
            }
            fine = Some(sets);
        }
        let sets = fine?;
        // Tips bend far beyond what a picture resolves: the scale is compressed.
        values
            .extend(sets.curvature(0.5, &SHARES).iter().map(|k| libm::tanh(k * wavelength / 10.0)));
        let lengths = SEGMENTS.map(|s| s * wavelength);
        for paper in [false, true] {
            values.extend(lineal_path(picture, &lengths, paper));
        }
        values.extend(directions(picture, &sets, wavelength));
        let direction = c.direction(0.5 * wavelength);
        Some(Self { values, wavelength, direction })
    }
}

/// The statistics of the picture with ink and paper exchanged.
pub fn invert(values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    out[0] = 1.0 - values[0];
    for width in 0..2 {
        for level in 0..5 {
            let to = LEVELS_AT + (width * 5 + level) * 3;
            let from = LEVELS_AT + (width * 5 + 4 - level) * 3;
            out[to] = 1.0 - values[from];
            out[to + 1] = values[from + 1];
            out[to + 2] = -values[from + 2];
        }
    }
    for n in 0..5 {
        out[CURVATURE_AT + n] = -values[CURVATURE_AT + 4 - n];
        out[PATHS_AT + n] = values[PATHS_AT + 5 + n];
        out[PATHS_AT + 5 + n] = values[PATHS_AT + n];
    }
    out
}

/// How far the border's direction goes on: the correlation of `exp(2 i theta)`, weighted by
/// the gradient's square, at each of [`TURNS`], and the share that is the same everywhere.
fn directions(picture: &Masked<'_>, sets: &LevelSets, wavelength: f64) -> [f64; 4] {
    let [ny, nx] = picture.shape;
    let (u, seen) = sets.parts();
    let mut parts = [vec![0.0; u.len()], vec![0.0; u.len()], vec![0.0; u.len()]];
    let mut weights = vec![0.0; u.len()];
    for j in 1..ny - 1 {
        for i in 1..nx - 1 {
            let n = j * nx + i;
            if [n - 1, n + 1, n - nx, n + nx].iter().any(|&m| !seen[m]) {
                continue;
            }
            let (x, y) = (0.5 * (u[n + 1] - u[n - 1]), 0.5 * (u[n + nx] - u[n - nx]));
            parts[0][n] = x * x - y * y;
            parts[1][n] = 2.0 * x * y;
            parts[2][n] = x * x + y * y;
            weights[n] = 1.0;
        }
    }
    let sigma = (0.25 * wavelength).max(0.6);
    let [mut a, mut b, energy] =
        parts.map(|part| normalized_convolution(picture.shape, &part, &weights, sigma).0);
    let (mut x, mut y, mut total) = (0.0, 0.0, 0.0);
    for n in 0..a.len() {
        let scale = if weights[n] > 0.0 && energy[n] > 1e-12 { 1.0 / energy[n] } else { 0.0 };
        (a[n], b[n]) = (a[n] * scale, b[n] * scale);
        (x, y, total) = (x + a[n], y + b[n], total + weights[n]);
    }
    let order = x.hypot(y) / f64::max(total, 1.0);
    let reach = (TURNS[2] * wavelength).ceil() as usize + 1;
    let c = Correlation::of(picture.shape, [&a, &b], &weights, reach);
    let at = |r: f64| c.as_ref().map_or(0.0, |c| c.at(r * wavelength));
    [at(TURNS[0]), at(TURNS[1]), at(TURNS[2]), order]
}

#[cfg(test)]
mod lengths {
    use super::*;

    #[test]
    fn the_groups_fill_the_descriptor() {
        assert_eq!(NAMES.iter().map(|n| n.1).sum::<usize>(), LENGTH);
    }
}
