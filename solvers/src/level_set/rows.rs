//! Loops over rows: serial on small grids, parallel on large ones, the same bytes either way.

use rayon::prelude::*;

/// Fewer values than this are cheaper to visit on one thread.
const PARALLEL: usize = 1 << 14;

/// Values that one task visits at least.
const TASK: usize = 1 << 12;

/// Calls `f(first_row, rows)` for pieces that together are all rows of `values`.
pub(super) fn for_each(values: &mut [f64], nx: usize, f: impl Fn(usize, &mut [f64]) + Sync) {
    all(values, nx, |first, rows| {
        f(first, rows);
        true
    });
}

/// As [`for_each`]; whether `f` answered true everywhere.
pub(super) fn all(
    values: &mut [f64],
    nx: usize,
    f: impl Fn(usize, &mut [f64]) -> bool + Sync,
) -> bool {
    if values.len() < PARALLEL {
        return f(0, values);
    }
    let rows = TASK.div_ceil(nx);
    values
        .par_chunks_mut(rows * nx)
        .enumerate()
        .map(|(chunk, values)| f(chunk * rows, values))
        .reduce(|| true, |a, b| a & b)
}

/// Greatest `f(first, len)` over pieces `first..first + len` of `0..count`; 0 if none is positive.
///
/// A maximum does not depend on the order in which it is taken, hence not on threads.
pub(super) fn greatest(count: usize, f: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
    if count < PARALLEL {
        return f(0, count).max(0.0);
    }
    let pieces = count.div_ceil(TASK);
    (0..pieces)
        .into_par_iter()
        .map(|piece| f(piece * TASK, TASK.min(count - piece * TASK)))
        .reduce(|| 0.0, f64::max)
}
