//! How a front is advanced.

use crate::{Boundary, Error, Result};
use serde::{Deserialize, Serialize};

/// Order of the upwind differences and of the time stepping that goes with them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// First-order differences, Godunov's Hamiltonian, one Euler step.
    ///
    /// Monotone, and the cheapest by far. Osher & Sethian 1988; Rouy & Tourin 1992.
    First,
    /// Fifth-order WENO differences with three-stage TVD Runge-Kutta steps of third order.
    ///
    /// Jiang & Peng 2000 with weights after Borges et al. 2008; Shu & Osher 1988, eq. (2.18).
    #[default]
    Weno5,
}

/// How a front is advanced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scheme {
    /// Order of the differences.
    pub order: Order,
    /// What stands beyond the border.
    pub boundary: Boundary,
    /// Fraction of the largest stable time step that `advance` takes, in (0, 1] (no unit).
    pub cfl: f64,
    /// Least value of |grad phi| in the term `beta |grad phi|` (no unit), if any.
    ///
    /// With a floor of 1 the front can nucleate where phi is flat; this no longer
    /// solves the level-set equation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_floor: Option<f64>,
    /// Bound on |phi| (length) that is imposed after every stage, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<f64>,
    /// Half-width of the narrow band (length): if given, only nodes evolve at which
    /// |phi| was below it when the band was laid. Use at least 6 node distances, and
    /// redistance (see [`LevelSet::phi_mut`](super::LevelSet::phi_mut)) before the front leaves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band: Option<f64>,
}

impl Default for Scheme {
    fn default() -> Self {
        Self {
            order: Order::Weno5,
            boundary: Boundary::Neumann,
            cfl: 0.5,
            gradient_floor: None,
            clip: None,
            band: None,
        }
    }
}

impl Scheme {
    /// Refuses values outside their range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] naming the parameter.
    pub fn check(&self) -> Result<()> {
        if !(self.cfl > 0.0 && self.cfl <= 1.0) {
            return Err(Error::out_of_range("cfl", self.cfl, "(0, 1]"));
        }
        let lengths =
            [("gradient_floor", self.gradient_floor), ("clip", self.clip), ("band", self.band)];
        for (name, value) in lengths {
            if let Some(value) = value.filter(|&v| !(v > 0.0 && v.is_finite())) {
                return Err(Error::out_of_range(name, value, "(0, inf)"));
            }
        }
        Ok(())
    }

    /// Ghost nodes that the differences reach beyond the border.
    pub(super) fn ghosts(&self) -> usize {
        match self.order {
            Order::First => 1,
            Order::Weno5 => 3,
        }
    }
}
