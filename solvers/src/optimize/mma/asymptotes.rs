use crate::Result;
use crate::optimize::{Bounds, check};
use serde::{Deserialize, Serialize};

/// Where the asymptotes and the bounds of a step stand; lengths are in box widths
/// `upper - lower` or in distances from a point to its asymptote.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MovingLimits {
    /// Farthest that a variable moves in one step, in box widths, in `(0, 1]`; 0.5.
    pub move_limit: f64,
    /// Distance of the first two pairs of asymptotes, in box widths, in `[0.01, 10]`;
    /// asyinit, 0.5.
    pub start: f64,
    /// Factor on the distance where a variable went on in one direction, at least 1;
    /// asyincr, 1.2.
    pub increase: f64,
    /// Factor on the distance where it turned back, in `(0, 1]`; asydecr, 0.7.
    pub decrease: f64,
    /// Part of the distance that a step leaves to the asymptote, in `(0, 1)`; albefa, 0.1.
    pub margin: f64,
}

impl Default for MovingLimits {
    fn default() -> Self {
        Self { move_limit: 0.5, start: 0.5, increase: 1.2, decrease: 0.7, margin: 0.1 }
    }
}

/// Least and greatest distance of an asymptote, in box widths (Svanberg 2007, eqs. 3.11 to 3.14).
const NEAREST: f64 = 0.01;
const FARTHEST: f64 = 10.0;

impl MovingLimits {
    pub(in crate::optimize) fn check(&self) -> Result<()> {
        let Self { move_limit, start, increase, decrease, margin } = *self;
        let unit = |v: f64| v > 0.0 && v <= 1.0;
        let reach = (NEAREST..=FARTHEST).contains(&start);
        check::within("move_limit", move_limit, unit(move_limit), "(0, 1]")?;
        check::within("start", start, reach, "[0.01, 10]")?;
        check::within("increase", increase, increase >= 1.0 && increase.is_finite(), "[1, inf)")?;
        check::within("decrease", decrease, unit(decrease), "(0, 1]")?;
        check::within("margin", margin, margin > 0.0 && margin < 1.0, "(0, 1)")
    }

    /// Bounds alpha, beta of a step from `x` (Svanberg 2007, eqs. 3.6 and 3.7).
    pub(super) fn step_bounds(
        &self,
        x: f64,
        low: f64,
        upp: f64,
        lower: f64,
        upper: f64,
    ) -> [f64; 2] {
        let reach = self.move_limit * (upper - lower);
        let alpha = lower.max(low + self.margin * (x - low)).max(x - reach);
        let beta = upper.min(upp - self.margin * (upp - x)).min(x + reach);
        [alpha, beta]
    }
}

/// The asymptotes and the two points before the present one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::optimize) struct Asymptotes {
    steps: u64,
    low: Vec<f64>,
    upp: Vec<f64>,
    /// Point of the last call, and of the one before.
    last: Vec<f64>,
    before: Vec<f64>,
}

impl Asymptotes {
    pub(in crate::optimize) fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Self { steps: 0, low: zeros(), upp: zeros(), last: zeros(), before: zeros() }
    }

    /// Refuses a history that was read for another number of variables.
    pub(in crate::optimize) fn check(&self, n: usize) -> Result<()> {
        let Self { low, upp, last, before, .. } = self;
        for (name, values) in
            [("saved low", low), ("saved upp", upp), ("saved last", last), ("saved before", before)]
        {
            check::length(name, values, n)?;
            check::finite(name, values)?;
        }
        Ok(())
    }

    pub(in crate::optimize) fn steps(&self) -> u64 {
        self.steps
    }

    /// Lower and upper asymptote of variable `j`.
    pub(in crate::optimize) fn at(&self, j: usize) -> [f64; 2] {
        [self.low[j], self.upp[j]]
    }

    /// Moves the asymptotes for a step from `x` (Svanberg 2007, eqs. 3.11 to 3.14).
    pub(in crate::optimize) fn advance(
        &mut self,
        x: &[f64],
        bounds: &Bounds,
        limits: &MovingLimits,
    ) {
        let Self { steps, low, upp, last, before } = self;
        let begins = *steps < 2;
        for (j, &x) in x.iter().enumerate() {
            let width = bounds.upper()[j] - bounds.lower()[j];
            if begins {
                low[j] = x - limits.start * width;
                upp[j] = x + limits.start * width;
            } else {
                let turn = (x - last[j]) * (last[j] - before[j]);
                let factor = if turn > 0.0 {
                    limits.increase
                } else if turn < 0.0 {
                    limits.decrease
                } else {
                    1.0
                };
                let below = x - factor * (last[j] - low[j]);
                let above = x + factor * (upp[j] - last[j]);
                low[j] = below.max(x - FARTHEST * width).min(x - NEAREST * width);
                upp[j] = above.min(x + FARTHEST * width).max(x + NEAREST * width);
            }
        }
        std::mem::swap(last, before);
        last.copy_from_slice(x);
        *steps += 1;
    }
}
