//! Normal speeds given node by node or by a function.

use super::{Speed, Terms, rows};
use crate::{Field, Result};

/// beta = the value of a field (length/time, positive outwards), e.g. of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSpeed(pub Field);

impl Speed for FieldSpeed {
    fn add(&mut self, phi: &Field, _: f64, terms: &mut Terms) -> Result<()> {
        self.0.check_shape("speed", phi.grid())?;
        add_field(terms.normal(), &self.0);
        Ok(())
    }
}

/// beta = `f([x, y, z], t)` (length/time, positive outwards), rows in parallel.
///
/// ```
/// use solvers::level_set::FnSpeed;
/// let mut blinking = FnSpeed(|[x, _, _]: [f64; 3], t: f64| x * t.cos());
/// # let _: &mut dyn solvers::level_set::Speed = &mut blinking;
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FnSpeed<F>(pub F);

impl<F: Fn([f64; 3], f64) -> f64 + Sync> Speed for FnSpeed<F> {
    fn add(&mut self, phi: &Field, t: f64, terms: &mut Terms) -> Result<()> {
        let (grid, nx) = (phi.grid(), phi.grid().shape()[2]);
        rows::for_each(terms.normal().as_mut_slice(), nx, |first, values| {
            for (row, values) in values.chunks_exact_mut(nx).enumerate() {
                let [_, y, z] = grid.position((first + row) * nx);
                for (i, beta) in values.iter_mut().enumerate() {
                    *beta += (self.0)([i as f64 * grid.spacing(), y, z], t);
                }
            }
        });
        Ok(())
    }
}

/// `target += source`, rows in parallel.
pub(super) fn add_field(target: &mut Field, source: &Field) {
    let (source, nx) = (source.as_slice(), source.grid().shape()[2]);
    rows::for_each(target.as_mut_slice(), nx, |first, values| {
        for (value, source) in values.iter_mut().zip(&source[first * nx..]) {
            *value += source;
        }
    });
}
