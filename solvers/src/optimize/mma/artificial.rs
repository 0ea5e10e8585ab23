use crate::optimize::check;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What the artificial variables y and z cost (Svanberg 2007, eq. 1.1).
///
/// They make every subproblem solvable: at a point from which no feasible one is in reach,
/// `y_i` is the violation that is left, at the price `c_i y_i + d_i y_i^2 / 2`. Once `c_i` is
/// above the multiplier of constraint i, y vanishes at the optimum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Artificial {
    /// Cost of z, above 0.
    pub a0: f64,
    /// Share of z in each constraint, 0 or more; where it is positive, `a c > a0`.
    pub a: Vec<f64>,
    /// Linear costs of y, 0 or more.
    pub c: Vec<f64>,
    /// Quadratic costs of y, 0 or more and not 0 where `c` is.
    pub d: Vec<f64>,
}

/// Linear cost of a violation, as published: large beside multipliers of functions scaled to
/// 1 to 100, small enough to keep digits.
const STANDARD_COST: f64 = 1000.0;

impl Artificial {
    /// `m` plain constraints `g_i <= 0`: a0 = 1, a = 0, c = 1000, d = 1.
    pub fn standard(m: usize) -> Self {
        Self { a0: 1.0, a: vec![0.0; m], c: vec![STANDARD_COST; m], d: vec![1.0; m] }
    }

    /// `count` functions of which the greatest is minimized, then `m` plain constraints.
    ///
    /// The functions are handed in as the first constraints, f0 is 0, and at the optimum z is
    /// the greatest; add a constant if that may be negative, since `z >= 0`.
    pub fn min_max(count: usize, m: usize) -> Self {
        let mut costs = Self::standard(count + m);
        costs.a[..count].fill(1.0);
        costs
    }

    /// Number of constraints.
    pub fn len(&self) -> usize {
        self.c.len()
    }

    /// Whether there are no constraints.
    pub fn is_empty(&self) -> bool {
        self.c.is_empty()
    }

    pub(in crate::optimize) fn check(&self) -> Result<()> {
        let m = self.len();
        check::length("artificial a", &self.a, m)?;
        check::length("artificial d", &self.d, m)?;
        check::within("artificial a0", self.a0, self.a0 > 0.0 && self.a0.is_finite(), "(0, inf)")?;
        for (name, values) in [("a", &self.a), ("c", &self.c), ("d", &self.d)] {
            let name = format!("artificial {name}");
            check::finite(&name, values)?;
            for (i, &v) in values.iter().enumerate() {
                check::within(&format!("{name}[{i}]"), v, v >= 0.0, "[0, inf)")?;
            }
        }
        for i in 0..m {
            let (a, c, d) = (self.a[i], self.c[i], self.d[i]);
            if c + d == 0.0 || (a > 0.0 && a * c <= self.a0) {
                return Err(Error::Invalid(format!(
                    "artificial costs of constraint {i} must have c + d > 0, and a c > a0 where \
                     a > 0; found a0 = {}, a = {a}, c = {c}, d = {d}",
                    self.a0
                )));
            }
        }
        Ok(())
    }
}
