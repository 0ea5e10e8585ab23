//! Growth of the domain, as the configuration says it.

use super::config::Config;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use solvers::diffusion::GrowthLaw;

/// Growth of the domain, the same in all directions and places: cells grow, their number stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// How the length L depends on time.
    #[serde(default)]
    pub law: Law,
    /// Growth rate of L / L(0) at time 0 (1/time).
    pub rate: f64,
    /// L / L(0) at which logistic growth ends, above 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Whether growth dilutes the concentrations.
    #[serde(default = "yes")]
    pub dilution: bool,
}

/// How the length of a growing domain depends on time, at growth rate r.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// `exp(r t)`.
    #[default]
    Exponential,
    /// `1 + r t`.
    Linear,
    /// `m / (1 + (m - 1) exp(-r t))`, m the limit.
    Logistic,
}

fn yes() -> bool {
    true
}

/// More than any grid has cells for: a pattern of one wave has none left there.
const GREATEST_SCALE: f64 = 1000.0;

impl Growth {
    /// As the solvers want it.
    fn law(&self) -> Result<solvers::diffusion::Growth> {
        let law = match (self.law, self.limit) {
            (Law::Exponential, None) => GrowthLaw::Exponential,
            (Law::Linear, None) => GrowthLaw::Linear,
            (Law::Logistic, Some(limit)) => GrowthLaw::Logistic { limit },
            (Law::Logistic, None) => {
                return Err(Error::config("growth.limit", "logistic growth needs one, above 1"));
            }
            (_, Some(_)) => {
                let reason = "only logistic growth ends at one";
                return Err(Error::config("growth.limit", reason));
            }
        };
        solvers::diffusion::Growth::new(law, self.rate).map_err(|error| match error {
            solvers::Error::OutOfRange { name, value, range } => {
                Error::range(&format!("growth.{name}"), value, &range)
            }
            other => other.into(),
        })
    }
}

impl Config {
    /// The growth of the domain, if it grows.
    pub(super) fn growth(&self) -> Result<Option<solvers::diffusion::Growth>> {
        let Some(growth) = &self.growth else { return Ok(None) };
        let law = growth.law()?;
        let end = law.scale(self.dt * self.iterations as f64);
        if end > GREATEST_SCALE || end.is_nan() {
            let reason = format!(
                "{} makes the domain {end:.3e} times as long by the end, at most {GREATEST_SCALE}",
                growth.rate
            );
            return Err(Error::config("growth.rate", reason));
        }
        if self.dispersion {
            let reason = "linear theory is for a domain of one size; leave out growth";
            return Err(Error::config("dispersion", reason));
        }
        Ok(Some(law))
    }
}
