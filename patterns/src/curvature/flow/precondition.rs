//! The spectral preconditioner of curvature energies.

use crate::curvature::energy::{Edges, EnergyConfig, Scalar, Spatial};
use solvers::spectral::{LaplacianSymbol, Multiplier, Transforms};
use solvers::{Error, Result};

/// `h(lambda)^power` without the mean, where
/// `h = dx^3 ((a20 + a02) / eps (eps lambda + beta / eps)^2 + 2 max(c, 0) eps lambda)`
/// approximates the Hessian of the energy at a flat interface's foot; lambda is the symbol of
/// the compact Laplacian, beta about W''(1) / 2 = 1.
///
/// # Errors
/// If the box is not periodic, or a20 + a02 is nowhere positive.
pub(super) fn preconditioner<T: Scalar + Transforms>(
    energy: &EnergyConfig,
    beta: f64,
    power: f64,
) -> Result<Multiplier<T>> {
    check(energy, beta)?;
    let [_, _, _, _, _, c] = &energy.coefficients;
    let bending = bending(energy);
    let (dx, eps, tension) = (energy.dx, energy.eps, largest(c).max(0.0));
    Multiplier::new(energy.shape, move |k| {
        let lambda = LaplacianSymbol::Axes.at(k.map(|k| k / dx), dx);
        if k == [0.0; 3] {
            return 0.0;
        }
        let stiff = eps * lambda + beta / eps;
        let h = bending / eps * stiff * stiff + 2.0 * tension * eps * lambda;
        libm::pow(dx * dx * dx * h, power)
    })
}

/// Refuses energies without a preconditioner.
pub(super) fn check(energy: &EnergyConfig, beta: f64) -> Result<()> {
    if energy.edges != Edges::Periodic {
        return Err(Error::Invalid(format!(
            "edges are {:?}; the spectral preconditioner needs periodic ones",
            energy.edges
        )));
    }
    if !(beta > 0.0 && beta.is_finite()) {
        return Err(Error::out_of_range("beta", beta, "(0, inf)"));
    }
    match bending(energy) {
        bending if bending > 0.0 => Ok(()),
        bending => Err(Error::out_of_range("a20 + a02", bending, "(0, inf)")),
    }
}

fn bending(energy: &EnergyConfig) -> f64 {
    let [a20, _, a02, ..] = &energy.coefficients;
    largest(a20) + largest(a02)
}

fn largest(spatial: &Spatial) -> f64 {
    match spatial {
        Spatial::Uniform(value) => *value,
        Spatial::Map(values) => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    }
}
