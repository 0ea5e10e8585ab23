//! Refuses unusable inputs before anything is allocated.

use super::lattice::Lattice;
use super::{Options, level, memory, rows};
use crate::{Error, Result};

pub(super) fn shape(name: &str, actual: usize, expected: usize) -> Error {
    Error::Shape { name: name.into(), actual: vec![actual], expected: vec![expected] }
}

/// # Errors
/// As `Multigrid::new`.
pub(super) fn check(
    lattice: &Lattice,
    components: usize,
    ke: &[f64],
    fixed: &[bool],
    springs: &[f64],
    options: &Options,
) -> Result<()> {
    if components != 1 && components != lattice.dim() {
        let range = format!("{{1, {}}}", lattice.dim());
        return Err(Error::out_of_range("components per node", components as f64, &range));
    }
    if !level::DEGREES.contains(&options.degree) {
        return Err(Error::out_of_range("degree of the smoother", options.degree as f64, "[2, 4]"));
    }
    let n = components * lattice.corners();
    let unknowns = lattice.node_count() * components;
    if ke.len() != n * n {
        return Err(shape("element matrix", ke.len(), n * n));
    }
    if fixed.len() != unknowns {
        return Err(shape("fixed unknowns", fixed.len(), unknowns));
    }
    if !springs.is_empty() && springs.len() != unknowns {
        return Err(shape("springs", springs.len(), unknowns));
    }
    rows::check_finite("element matrix", ke)?;
    rows::check_finite("springs", springs)?;
    if let Some(u) = springs.iter().position(|&s| s < 0.0) {
        return Err(Error::out_of_range(&format!("spring of unknown {u}"), springs[u], "[0, inf)"));
    }
    let largest = ke.iter().copied().fold(0.0, f64::max);
    let differs = |i: usize| (ke[i] - ke[i % n * n + i / n]).abs() > 1e-12 * largest;
    if (0..n * n).any(differs) || (0..n).any(|i| ke[i * n + i] <= 0.0) {
        return Err(Error::Invalid(
            "the element matrix must be symmetric with a diagonal above 0".into(),
        ));
    }
    let bytes = memory(lattice, components, options);
    if Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
        return Err(Error::TooLarge {
            name: "multigrid solver".into(),
            shape: lattice.elements()[3 - lattice.dim()..].to_vec(),
            needed: format!("{bytes:.3e} bytes"),
            available: "less".into(),
        });
    }
    Ok(())
}
