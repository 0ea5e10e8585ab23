//! The speed field of shape optimization.

use solvers::{
    Field,
    level_set::{Speed, Terms},
};

/// `beta = scale (w - lambda)`: outwards where the energy density `w` is worth its volume.
///
/// The shape derivative of `compliance + lambda volume` for a free boundary is
/// `-int (A e:e - lambda) theta.n ds` (Allaire, Jouve & Toader 2004, eq. 25), so this is its
/// steepest descent. Equation 1.18 of Chattopadhyay & Mukherjee lacks the weight term
/// lambda; as printed the shape only grows or only shrinks.
#[derive(Clone, Debug)]
pub(super) struct ShapeSpeed {
    /// Smoothed energy density (force/length^2).
    pub(super) energy: Field,
    /// Multiplier of the volume, same unit.
    pub(super) lambda: f64,
    /// Brings the greatest speed to 1.
    pub(super) scale: f64,
}

impl Speed for ShapeSpeed {
    fn add(&mut self, _phi: &Field, _t: f64, terms: &mut Terms) -> solvers::Result<()> {
        let beta = terms.normal().as_mut_slice().iter_mut();
        beta.zip(self.energy.as_slice()).for_each(|(beta, w)| {
            *beta += (self.scale * (w - self.lambda)).clamp(-1.0, 1.0);
        });
        Ok(())
    }
}
