//! Constant normal speed.

use super::{Speed, Terms};
use crate::{Field, Result};

/// beta = the given speed (length/time, positive outwards) everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantSpeed(pub f64);

impl Speed for ConstantSpeed {
    fn add(&mut self, _: &Field, _: f64, terms: &mut Terms) -> Result<()> {
        terms.normal().as_mut_slice().iter_mut().for_each(|beta| *beta += self.0);
        Ok(())
    }
}
