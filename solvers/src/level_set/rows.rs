//! Loops over rows: serial on small grids, parallel on large ones, the same bytes either way.

use rayon::prelude::*;

/// Fewer values than this are cheaper to visit on one thread when a value costs a
/// nanosecond or so: waking the threads takes tens of microseconds.
pub(super) const LIGHT: usize = 1 << 16;

/// As [`LIGHT`] when a value costs some twenty nanoseconds.
pub(super) const HEAVY: usize = 1 << 13;

/// Values that one task visits at least.
const TASK: usize = 1 << 12;

/// Calls `f(first_row, rows)` for pieces that together are all rows of `values`.
pub(super) fn for_each(values: &mut [f64], nx: usize, f: impl Fn(usize, &mut [f64]) + Sync) {
    all(values, nx, LIGHT, |first, rows| {
        f(first, rows);
        true
    });
}

/// As [`for_each`], on one thread if there are fewer than `parallel` values; whether
/// `f` answered true everywhere.
pub(super) fn all(
    values: &mut [f64],
    nx: usize,
    parallel: usize,
    f: impl Fn(usize, &mut [f64]) -> bool + Sync,
) -> bool {
    if values.len() < parallel {
        return f(0, values);
    }
    let rows = TASK.div_ceil(nx);
    values
        .par_chunks_mut(rows * nx)
        .enumerate()
        .map(|(chunk, values)| f(chunk * rows, values))
        .reduce(|| true, |a, b| a & b)
}

/// Calls `f(first_row, rows)` for pieces of three arrays at once.
pub(super) fn for_each_of_three(
    [x, y, z]: [&mut [f64]; 3],
    nx: usize,
    f: impl Fn(usize, [&mut [f64]; 3]) + Sync,
) {
    if x.len() < LIGHT {
        return f(0, [x, y, z]);
    }
    let rows = TASK.div_ceil(nx);
    let chunks = y.par_chunks_mut(rows * nx).zip(z.par_chunks_mut(rows * nx));
    x.par_chunks_mut(rows * nx)
        .zip(chunks)
        .enumerate()
        .for_each(|(chunk, (x, (y, z)))| f(chunk * rows, [x, y, z]));
}

/// Greatest `f(first, len)` over pieces `first..first + len` of `0..count`; 0 if none is positive.
///
/// A maximum does not depend on the order in which it is taken, hence not on threads.
pub(super) fn greatest(count: usize, f: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
    if count < LIGHT {
        return f(0, count).max(0.0);
    }
    let pieces = count.div_ceil(TASK);
    (0..pieces)
        .into_par_iter()
        .map(|piece| f(piece * TASK, TASK.min(count - piece * TASK)))
        .reduce(|| 0.0, f64::max)
}
