//! Between the caller's vectors, unknown by unknown, and rows of components.

use super::lattice::Layout;
use crate::{Error, Result};

/// Takes whole rows of the caller's numbers apart.
pub(super) fn spread(layout: &Layout, from: &[f64], to: &mut [f64]) {
    let per_row = layout.lattice.nodes()[2] * layout.components;
    for (from, to) in from.chunks_exact(per_row).zip(to.chunks_mut(layout.row_len())) {
        for c in 0..layout.components {
            let from = from[c..].iter().step_by(layout.components);
            to[layout.span(c)].iter_mut().zip(from).for_each(|(to, from)| *to = *from);
        }
    }
}

/// The inverse of [`spread`].
pub(super) fn collect(layout: &Layout, from: &[f64], to: &mut [f64]) {
    let per_row = layout.lattice.nodes()[2] * layout.components;
    for (to, from) in to.chunks_exact_mut(per_row).zip(from.chunks(layout.row_len())) {
        for c in 0..layout.components {
            let to = to[c..].iter_mut().step_by(layout.components);
            to.zip(&from[layout.span(c)]).for_each(|(to, from)| *to = *from);
        }
    }
}

/// Sum of products, in eight interleaved parts: a vector's lanes. Rows are multiples of 8.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum()
}

/// # Errors
/// If there is a NaN or an infinity; names the first.
pub(super) fn check_finite(name: &str, values: &[f64]) -> Result<()> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::Invalid(format!("{name}[{i}] = {}, expected a number", values[i]))),
    }
}
