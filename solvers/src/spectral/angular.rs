//! Power against direction.

use super::radial::{Window, windowed_modes};
use crate::{Boundary, Error, Field, Result};
use std::f64::consts::PI;

/// Power of the waves of a two-dimensional field against the direction of their wave vector.
#[derive(Clone, Debug, PartialEq)]
pub struct AngularSpectrum {
    /// Middle of each sector, in [0, pi); stripes run perpendicular to it.
    pub angle: Vec<f64>,
    /// Power in each sector; the sum is the part of the mean square in the band.
    pub power: Vec<f64>,
    /// `|sum_m P_m exp(2 i theta_m)| / sum_m P_m`: 0 for no preferred direction, 1 for
    /// perfect stripes.
    pub order: f64,
    /// Direction of the wave vector that `order` refers to, in [0, pi).
    pub direction: f64,
}

impl AngularSpectrum {
    /// Waves with wave number in `band = [k_min, k_max]` (1/length), in `sectors` sectors.
    ///
    /// Always by Fourier series: a mirrored field would contain each wave's mirror
    /// image, so use [`Window::Hann`] for fields that are not periodic.
    ///
    /// # Errors
    /// If the field is not two-dimensional, there are no sectors, or a window does not fit.
    pub fn new(field: &Field, window: Window<'_>, band: [f64; 2], sectors: usize) -> Result<Self> {
        if field.grid().dim() != 2 {
            let dim = field.grid().dim();
            return Err(Error::out_of_range("dimension of the field", dim as f64, "[2, 2]"));
        }
        if sectors == 0 {
            return Err(Error::out_of_range("sectors", 0.0, "[1, inf)"));
        }
        let [_, ny, nx] = field.grid().shape();
        let h = field.grid().spacing();
        let (transform, modes) = windowed_modes(field, Boundary::Periodic, window)?;
        let norm = (field.grid().len() as f64).powi(2);
        let mut power = vec![0.0; sectors];
        let (mut cos2, mut sin2, mut total) = (0.0, 0.0, 0.0);
        for my in 0..=ny / 2 {
            for mx in 0..=nx / 2 {
                let kx = 2.0 * PI * mx as f64 / (nx as f64 * h);
                let ky = 2.0 * PI * my as f64 / (ny as f64 * h);
                let k = kx.hypot(ky);
                if k == 0.0 || !(band[0]..=band[1]).contains(&k) {
                    continue;
                }
                // Products of the real series: R and I of x, then of y.
                let at =
                    |imag_x: bool, imag_y: bool| match (slot(mx, nx, imag_x), slot(my, ny, imag_y))
                    {
                        (Some(x), Some(y)) => modes[transform.index([x, y, 0])],
                        _ => 0.0,
                    };
                let (rr, ri, ir, ii) =
                    (at(false, false), at(false, true), at(true, false), at(true, true));
                let along = (rr - ii).powi(2) + (ri + ir).powi(2);
                let against = (rr + ii).powi(2) + (ir - ri).powi(2);
                let angle = ky.atan2(kx);
                let paired = |m: usize, n: usize| m > 0 && 2 * m < n;
                // (kx, ky) and (kx, -ky), each with its complex conjugate, if they differ.
                let waves: &[(f64, f64, f64)] = match (paired(mx, nx), paired(my, ny)) {
                    (true, true) => &[(angle, along, 2.0), (PI - angle, against, 2.0)],
                    (false, false) => &[(angle, along, 1.0)],
                    _ => &[(angle, along, 2.0)],
                };
                for &(angle, square, count) in waves {
                    let p = count * square / norm;
                    let sector = (angle / PI * sectors as f64) as usize % sectors;
                    power[sector] += p;
                    (cos2, sin2) = (cos2 + p * (2.0 * angle).cos(), sin2 + p * (2.0 * angle).sin());
                    total += p;
                }
            }
        }
        let angle = (0..sectors).map(|s| (s as f64 + 0.5) * PI / sectors as f64).collect();
        let order = if total > 0.0 { cos2.hypot(sin2) / total } else { 0.0 };
        Ok(Self { angle, power, order, direction: (0.5 * sin2.atan2(cos2)).rem_euclid(PI) })
    }
}

/// Where the real series of `n` numbers stores the real or imaginary part of mode `m`.
fn slot(m: usize, n: usize, imaginary: bool) -> Option<usize> {
    match imaginary {
        _ if m == 0 || 2 * m == n => (!imaginary).then(|| (2 * m).saturating_sub(1)),
        false => Some(2 * m - 1),
        true => Some(2 * m),
    }
}
