//! Motion by mean curvature.

use super::{Speed, Terms};
use crate::{Field, Result};

/// beta = constant - b kappa, kappa positive where the inside is convex.
///
/// kappa is the sum of the principal curvatures: 1/R on a circle, 2/R on a
/// sphere. The largest stable step is h^2 / (2 dim b).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureSpeed {
    /// b >= 0 (length^2/time).
    pub coefficient: f64,
    /// Speed of a flat front (length/time).
    pub constant: f64,
}

impl CurvatureSpeed {
    /// Pure motion by curvature, beta = -b kappa.
    pub fn new(coefficient: f64) -> Self {
        Self { coefficient, constant: 0.0 }
    }
}

impl Speed for CurvatureSpeed {
    fn add(&mut self, _: &Field, _: f64, terms: &mut Terms) -> Result<()> {
        terms.curvature().as_mut_slice().iter_mut().for_each(|b| *b += self.coefficient);
        if self.constant != 0.0 {
            terms.normal().as_mut_slice().iter_mut().for_each(|beta| *beta += self.constant);
        }
        Ok(())
    }
}
