//! What is refused before a state changes.

use crate::{Error, Result};

/// Function values and gradients at one point.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<'a> {
    /// Objective.
    pub(super) f0: f64,
    /// Its gradient, `[n]`.
    pub(super) df0: &'a [f64],
    /// Constraints, `[m]`.
    pub(super) g: &'a [f64],
    /// Their gradients, row by row, `[m, n]`.
    pub(super) dg: &'a [f64],
}

impl Evaluation<'_> {
    /// Refuses lengths that do not fit `n` variables and `m` constraints, and values not finite.
    pub(super) fn check(&self, n: usize, m: usize) -> Result<()> {
        values(self.f0, self.g, m)?;
        length("df0", self.df0, n)?;
        length("dg (constraints times variables)", self.dg, m * n)?;
        finite("df0", self.df0)?;
        match self.dg.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(at) => {
                let (i, j) = (at / n, at % n);
                Err(not_finite(&format!("dg[{i}, {j}]"), self.dg[at]))
            }
        }
    }
}

/// Refuses an objective or constraints that are not finite, or not `m` of them.
pub(super) fn values(f0: f64, g: &[f64], m: usize) -> Result<()> {
    length("g", g, m)?;
    if !f0.is_finite() {
        return Err(not_finite("f0", f0));
    }
    finite("g", g)
}

/// Refuses another length than `expected`.
pub(super) fn length(name: &str, values: &[f64], expected: usize) -> Result<()> {
    if values.len() == expected {
        return Ok(());
    }
    Err(Error::Shape { name: name.into(), actual: vec![values.len()], expected: vec![expected] })
}

/// Refuses NaN and infinities, naming the first.
pub(super) fn finite(name: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(j) => Err(not_finite(&format!("{name}[{j}]"), values[j])),
    }
}

/// Refuses a number outside a range that `inside` decides and `range` writes.
pub(super) fn within(name: &str, value: f64, inside: bool, range: &str) -> Result<()> {
    if inside { Ok(()) } else { Err(Error::out_of_range(name, value, range)) }
}

fn not_finite(name: &str, value: f64) -> Error {
    Error::Invalid(format!("{name} is {value}, which is not finite"))
}
