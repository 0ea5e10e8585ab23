use super::check;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// The box of the design variables: `lower[j] <= x[j] <= upper[j]`, all finite.
///
/// Where both are equal the variable is fixed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Sides")]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

/// [`Bounds`] as read, before they are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sides {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl TryFrom<Sides> for Bounds {
    type Error = Error;

    fn try_from(sides: Sides) -> Result<Self> {
        Self::new(sides.lower, sides.upper)
    }
}

impl Bounds {
    /// One lower and one upper bound per variable, in the unit of the variable.
    ///
    /// # Errors
    /// If there are no variables, the lengths differ, a bound is not finite or a lower bound
    /// is above its upper bound.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self> {
        if lower.is_empty() {
            return Err(Error::Invalid("an optimizer needs at least one variable".into()));
        }
        check::length("upper bounds", &upper, lower.len())?;
        check::finite("lower bound", &lower)?;
        check::finite("upper bound", &upper)?;
        match (0..lower.len()).find(|&j| lower[j] > upper[j]) {
            None => Ok(Self { lower, upper }),
            Some(j) => Err(Error::Invalid(format!(
                "bounds of variable {j} are crossed: lower {} > upper {}",
                lower[j], upper[j]
            ))),
        }
    }

    /// The same bounds for `n` variables.
    ///
    /// # Errors
    /// As [`Bounds::new`].
    pub fn uniform(n: usize, lower: f64, upper: f64) -> Result<Self> {
        Self::new(vec![lower; n], vec![upper; n])
    }

    /// Fixes variable `j` at `value` (a passive element), which may lie outside its old bounds.
    ///
    /// # Errors
    /// If there is no such variable or the value is not finite.
    pub fn fix(&mut self, j: usize, value: f64) -> Result<()> {
        if j >= self.len() {
            let count = self.len();
            return Err(Error::Invalid(format!("no variable {j} to fix among {count}")));
        }
        check::finite("fixed value", &[value])?;
        (self.lower[j], self.upper[j]) = (value, value);
        Ok(())
    }

    /// Number of variables, fixed ones too.
    pub fn len(&self) -> usize {
        self.lower.len()
    }

    /// Never true: there is at least one variable.
    pub fn is_empty(&self) -> bool {
        self.lower.is_empty()
    }

    /// Lower bounds.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper bounds.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Whether variable `j` cannot move.
    pub fn is_fixed(&self, j: usize) -> bool {
        self.lower[j] == self.upper[j]
    }

    /// Refuses a point of another length, not finite, or outside where it is free.
    pub(super) fn check(&self, x: &[f64]) -> Result<()> {
        check::length("x", x, self.len())?;
        check::finite("x", x)?;
        let (lower, upper) = (&self.lower, &self.upper);
        let outside = |&j: &usize| !self.is_fixed(j) && (x[j] < lower[j] || x[j] > upper[j]);
        match (0..x.len()).find(outside) {
            None => Ok(()),
            Some(j) => Err(Error::out_of_range(
                &format!("x[{j}]"),
                x[j],
                &format!("[{}, {}]", lower[j], upper[j]),
            )),
        }
    }
}
