//! Domains that grow: the same in all directions and at every place.
//!
//! | symbol | code    | meaning                                  | unit   |
//! |--------|---------|------------------------------------------|--------|
//! | s      | `scale` | length of the domain over that at time 0 | 1      |
//! | r      | `rate`  | growth rate: s'(0); logistic s'(0) m/(m - 1) | 1/time |
//! | m      | `limit` | scale at which logistic growth ends      | 1      |
//!
//! On the fixed grid of time 0 (Crampin, Gaffney and Maini 1999, "Reaction and diffusion
//! on growing domains", Bull. Math. Biol. 61) a concentration obeys
//! `du/dt = f(u) + D/s^2 laplacian(u) - dim (s'/s) u`; the last term is its dilution.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// How the length of a domain depends on time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GrowthLaw {
    /// `s = exp(r t)`: doublings take equal times.
    Exponential,
    /// `s = 1 + r t`.
    Linear,
    /// `s = m / (1 + (m - 1) exp(-r t))`: exponential at first, ends at m.
    Logistic {
        /// m, above 1.
        limit: f64,
    },
}

/// Uniform growth of a domain in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    law: GrowthLaw,
    rate: f64,
}

impl Growth {
    /// Growth by `law` at `rate` (1/time); at rate 0 everything below is exactly 1.
    ///
    /// # Errors
    /// If the rate is negative or not finite, or a limit is not finite and above 1.
    pub fn new(law: GrowthLaw, rate: f64) -> Result<Self> {
        if !(rate >= 0.0 && rate.is_finite()) {
            return Err(Error::out_of_range("rate", rate, "[0, inf)"));
        }
        if let GrowthLaw::Logistic { limit } = law
            && !(limit > 1.0 && limit.is_finite())
        {
            return Err(Error::out_of_range("limit", limit, "(1, inf)"));
        }
        Ok(Self { law, rate })
    }

    /// s at time `t >= 0`, at least 1; the same bits on every machine.
    pub fn scale(&self, t: f64) -> f64 {
        let grown = self.rate * t;
        match self.law {
            _ if grown == 0.0 => 1.0,
            GrowthLaw::Exponential => libm::exp(grown),
            GrowthLaw::Linear => 1.0 + grown,
            GrowthLaw::Logistic { limit } => limit / (1.0 + (limit - 1.0) * libm::exp(-grown)),
        }
    }

    /// Mean of `1/s^2` over the times from `t` to `t + dt`, exact: the factor of all diffusion
    /// in that step. Diffusion alone, solved exactly with it, is exact.
    pub fn laplacian_factor(&self, t: f64, dt: f64) -> f64 {
        let (grown, step) = (self.rate * t, self.rate * dt);
        if step == 0.0 {
            let scale = self.scale(t);
            return 1.0 / (scale * scale);
        }
        // Mean of exp(-n r t) over the step.
        let mean = |n: f64| libm::exp(-n * grown) * -libm::expm1(-n * step) / (n * step);
        match self.law {
            GrowthLaw::Exponential => mean(2.0),
            GrowthLaw::Linear => 1.0 / ((1.0 + grown) * (1.0 + grown + step)),
            GrowthLaw::Logistic { limit } => {
                let rest = limit - 1.0;
                (1.0 + 2.0 * rest * mean(1.0) + rest * rest * mean(2.0)) / (limit * limit)
            }
        }
    }

    /// What remains of a concentration from `t` to `t + dt` in `dim` dimensions if nothing else
    /// happens: `(s(t) / s(t + dt))^dim`.
    pub fn dilution(&self, t: f64, dt: f64, dim: usize) -> f64 {
        (self.scale(t) / self.scale(t + dt)).powi(dim as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [GrowthLaw; 3] =
        [GrowthLaw::Exponential, GrowthLaw::Linear, GrowthLaw::Logistic { limit: 3.0 }];

    /// The mean over a step against Simpson's rule on 200 intervals, whose error is below 1e-10.
    #[test]
    fn the_factor_of_diffusion_is_the_mean_over_the_step() {
        for law in LAWS {
            let growth = Growth::new(law, 0.3).unwrap();
            let (t, dt) = (1.7, 0.9);
            let at = |m: u32| growth.scale(t + dt * f64::from(m) / 200.0).powi(-2);
            let inner: f64 = (1..200).map(|m| if m % 2 == 1 { 4.0 } else { 2.0 } * at(m)).sum();
            let wanted = (at(0) + inner + at(200)) / 600.0;
            let found = growth.laplacian_factor(t, dt);
            assert!((found / wanted - 1.0).abs() < 1e-10, "{law:?}: {found} {wanted}");
        }
    }

    #[test]
    fn every_law_begins_at_the_same_length_and_rate() {
        for law in LAWS {
            let growth = Growth::new(law, 0.3).unwrap();
            assert_eq!(growth.scale(0.0), 1.0);
            let slope = (growth.scale(1e-6) - 1.0) / 1e-6;
            // Logistic growth begins at r (1 - 1/m).
            let begins =
                if let GrowthLaw::Logistic { limit } = law { 1.0 - 1.0 / limit } else { 1.0 };
            assert!((slope - 0.3 * begins).abs() < 1e-6, "{law:?}: {slope}");
            let still = Growth::new(law, 0.0).unwrap();
            assert_eq!((still.scale(5.0), still.laplacian_factor(5.0, 1.0)), (1.0, 1.0));
            assert_eq!(still.dilution(5.0, 1.0, 3), 1.0);
        }
        assert!((Growth::new(LAWS[2], 0.3).unwrap().scale(1e3) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_growth_is_refused() {
        assert!(Growth::new(GrowthLaw::Linear, -0.1).is_err());
        assert!(Growth::new(GrowthLaw::Exponential, f64::NAN).is_err());
        assert!(Growth::new(GrowthLaw::Logistic { limit: 1.0 }, 0.1).is_err());
    }
}
