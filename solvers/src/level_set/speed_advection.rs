//! Fronts carried by a flow.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{Speed, Terms, rows, speed_field::add_field};
use crate::{Field, Result};

/// Velocity given node by node, one field per present axis, x first (length/time).
#[derive(Clone, Debug, PartialEq)]
pub struct FieldAdvection(pub Vec<Field>);

impl Speed for FieldAdvection {
    fn add(&mut self, phi: &Field, _: f64, terms: &mut Terms) -> Result<()> {
        let (grid, count) = (phi.grid(), self.0.len());
        if count != grid.dim() {
            return Err(crate::Error::out_of_range(
                "number of velocity components",
                count as f64,
                &format!("[{0}, {0}]", grid.dim()),
            ));
        }
        for (v, source) in terms.velocity().iter_mut().zip(&self.0) {
            source.check_shape("velocity", grid)?;
            add_field(v, source);
        }
        Ok(())
    }
}

/// Velocity `[vx, vy, vz] = f([x, y, z], t)` (length/time); absent axes are ignored.
///
/// ```
/// use solvers::level_set::FnAdvection;
/// let mut rotation = FnAdvection(|[x, y, _]: [f64; 3], _t: f64| [-y, x, 0.0]);
/// # let _: &mut dyn solvers::level_set::Speed = &mut rotation;
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FnAdvection<F>(pub F);

impl<F: Fn([f64; 3], f64) -> [f64; 3] + Sync> Speed for FnAdvection<F> {
    fn add(&mut self, phi: &Field, t: f64, terms: &mut Terms) -> Result<()> {
        let (grid, nx) = (phi.grid(), phi.grid().shape()[2]);
        let velocity = terms.velocity().each_mut().map(Field::as_mut_slice);
        rows::for_each_of_three(velocity, nx, |first, [vx, vy, vz]| {
            let rows = vx.chunks_exact_mut(nx).zip(vy.chunks_exact_mut(nx));
            for (row, ((vx, vy), vz)) in rows.zip(vz.chunks_exact_mut(nx)).enumerate() {
                let [_, y, z] = grid.position((first + row) * nx);
                for i in 0..nx {
                    let v = (self.0)([i as f64 * grid.spacing(), y, z], t);
                    vx[i] += v[0];
                    vy[i] += v[1];
                    vz[i] += v[2];
                }
            }
        });
        Ok(())
    }
}
