//! Sums of speeds.

use super::{Speed, Terms};
use crate::{Field, Result};

/// The sum of any speeds.
///
/// ```
/// use solvers::level_set::{ConstantSpeed, CurvatureSpeed, Speed};
/// let mut growth: Vec<Box<dyn Speed>> =
///     vec![Box::new(ConstantSpeed(1.0)), Box::new(CurvatureSpeed::new(0.1))];
/// # let _: &mut dyn Speed = &mut growth;
/// ```
impl Speed for Vec<Box<dyn Speed>> {
    fn add(&mut self, phi: &Field, t: f64, terms: &mut Terms) -> Result<()> {
        self.iter_mut().try_for_each(|speed| speed.add(phi, t, terms))
    }
}
