//! The loops of an update: trial densities, their sum, and the bisection.

use super::OcConfig;
use crate::optimize::{Bounds, check};
use crate::{Error, Result};
use rayon::prelude::*;

/// Densities per task; part of the sum's last bits, which decide nothing.
const CHUNK: usize = 4096;

/// Independent partial sums.
const LANES: usize = 8;

/// Rounding errors of one term of the sum, in epsilons, with a reserve: two powers, a
/// division and two products against one of each.
const TERM_ERRORS: f64 = 32.0;

/// Multiplier below which quotients might overflow; only objectives without slope get there.
const LEAST_SAFE: f64 = 1e-100;

/// What does not change during a bisection.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    /// `-dc/dv`.
    ratio: Vec<f64>,
    /// Move limit and box together.
    low: Vec<f64>,
    high: Vec<f64>,
    /// `x (-dc/dv)^eta` and `x floor^eta`, for sums that are near enough to the exact ones.
    scaled: Vec<f64>,
    least: Vec<f64>,
    partial: Vec<f64>,
}

impl Work {
    /// Checks the gradients of free densities, and keeps what all trials share.
    pub(super) fn prepare(
        &mut self,
        config: &OcConfig,
        bounds: &Bounds,
        x: &[f64],
        dc: &[f64],
        dv: Option<&[f64]>,
    ) -> Result<()> {
        for array in [&mut self.ratio, &mut self.low, &mut self.high] {
            array.resize(x.len(), 0.0);
        }
        for (j, &x) in x.iter().enumerate() {
            let (lower, upper) = (bounds.lower()[j], bounds.upper()[j]);
            if bounds.is_fixed(j) {
                (self.ratio[j], self.low[j], self.high[j]) = (0.0, lower, lower);
                continue;
            }
            let dv = dv.map_or(1.0, |dv| dv[j]);
            if dv <= 0.0 {
                return Err(Error::out_of_range(&format!("dv[{j}]"), dv, "(0, inf)"));
            }
            if dc[j] > 0.0 && config.floor.is_none() {
                return Err(Error::out_of_range(&format!("dc[{j}]"), dc[j], "(-inf, 0]"));
            }
            self.ratio[j] = -dc[j] / dv;
            self.low[j] = greater(lower, x - config.move_limit);
            self.high[j] = smaller(upper, x + config.move_limit);
        }
        Ok(())
    }

    /// Writes the trial densities of one multiplier, rounded as the published programs do.
    pub(super) fn write(&self, config: &OcConfig, x: &[f64], multiplier: f64, next: &mut [f64]) {
        let floor = config.floor.unwrap_or(f64::NEG_INFINITY);
        next.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, next)| {
            let range = chunk * CHUNK..chunk * CHUNK + next.len();
            let (x, ratio) = (&x[range.clone()], &self.ratio[range.clone()]);
            let (low, high) = (&self.low[range.clone()], &self.high[range]);
            for (k, next) in next.iter_mut().enumerate() {
                let quotient = greater(floor, ratio[k] / multiplier);
                let wanted = x[k] * config.power(quotient);
                *next = greater(low[k], smaller(high[k], wanted));
            }
        });
    }

    /// Takes the powers once that [`Work::sum`] needs for every multiplier.
    pub(super) fn scale(&mut self, config: &OcConfig, x: &[f64]) {
        let least = config.power(config.floor.unwrap_or(0.0));
        self.scaled.resize(x.len(), 0.0);
        self.scaled.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(j, scaled)| {
            *scaled = x[j] * config.power(greater(0.0, self.ratio[j]));
        });
        self.least.clear();
        self.least.extend(x.iter().map(|x| x * least));
        self.partial.resize(x.len().div_ceil(CHUNK), 0.0);
    }

    /// Sum of the trial densities, and by how much a sum of the written ones, in whatever
    /// order, can differ from it.
    pub(super) fn sum(&mut self, config: &OcConfig, multiplier: f64) -> [f64; 2] {
        if multiplier < LEAST_SAFE {
            return [0.0, f64::INFINITY];
        }
        let factor = 1.0 / config.power(multiplier);
        let Self { low, high, scaled, least, partial, .. } = self;
        let count = scaled.len();
        partial.par_iter_mut().enumerate().for_each(|(chunk, partial)| {
            let range = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
            let arrays = [&*scaled, &*least, &*low, &*high].map(|values| &values[range.clone()]);
            *partial = chunk_sum(factor, arrays);
        });
        let sum: f64 = partial.iter().sum();
        [sum, (2.0 * count as f64 + TERM_ERRORS) * f64::EPSILON * sum]
    }
}

/// Sum over one chunk of `scaled * factor`, at least `least`, held in `[low, high]`.
fn chunk_sum(factor: f64, [scaled, least, low, high]: [&[f64]; 4]) -> f64 {
    let term = |scaled: f64, least: f64, low: f64, high: f64| {
        greater(low, smaller(high, greater(least, scaled * factor)))
    };
    let mut lanes = [0.0; LANES];
    let (scaled, scaled_rest) = scaled.as_chunks::<LANES>();
    let (least, least_rest) = least.as_chunks::<LANES>();
    let (low, low_rest) = low.as_chunks::<LANES>();
    let (high, high_rest) = high.as_chunks::<LANES>();
    for (((scaled, least), low), high) in scaled.iter().zip(least).zip(low).zip(high) {
        for lane in 0..LANES {
            lanes[lane] += term(scaled[lane], least[lane], low[lane], high[lane]);
        }
    }
    let rest = (0..scaled_rest.len())
        .map(|k| term(scaled_rest[k], least_rest[k], low_rest[k], high_rest[k]));
    lanes.iter().sum::<f64>() + rest.sum::<f64>()
}

/// Halves `[0, greatest_multiplier]` by the sign of `excess`; the last multiplier tried, as the
/// published programs keep its densities, and the number of trials.
pub(super) fn bisect(
    config: &OcConfig,
    mut excess: impl FnMut(f64) -> f64,
) -> Result<(f64, usize)> {
    let (mut l1, mut l2) = (0.0, config.greatest_multiplier);
    let (mut multiplier, mut count) = (0.0, 0);
    while config.end.goes_on(l1, l2) {
        multiplier = 0.5 * (l2 + l1);
        count += 1;
        let excess = excess(multiplier);
        check::finite("excess of the volume", &[excess])?;
        if excess > 0.0 {
            l1 = multiplier;
        } else {
            l2 = multiplier;
        }
        // Neighbouring numbers: a width below round-off would be halved for ever.
        if multiplier == 0.5 * (l2 + l1) {
            break;
        }
    }
    Ok((multiplier, count))
}

/// `max(a, b)`, where NaN and the sign of 0 have an order: `a` unless `b` is greater.
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// `min(a, b)` likewise.
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}
