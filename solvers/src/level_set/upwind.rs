//! First-order upwind differences, row by row.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::ghost::Row;

/// The greater of two; unlike `f64::max` one instruction, and NaN gives `b`.
#[inline(always)]
pub(super) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `rate = -beta max(|grad phi|, floor)` with Godunov's |grad phi|.
///
/// Along each axis the squared slope is `max(s D-, -s D+, 0)^2`, s the sign of
/// beta. Rouy & Tourin 1992, eq. (2.4); Osher & Fedkiw 2003, eq. (6.3).
#[inline(always)]
pub(super) fn normal<const DIM: usize>(
    row: Row<'_>,
    beta: &[f64],
    (per_h, floor): (f64, f64),
    rate: &mut [f64],
) {
    let n = row.len();
    let (center, beta, rate) = (row.along(0, 0), &beta[..n], &mut rate[..n]);
    let before: [&[f64]; DIM] = std::array::from_fn(|axis| &row.along(axis, -1)[..n]);
    let after: [&[f64]; DIM] = std::array::from_fn(|axis| &row.along(axis, 1)[..n]);
    for i in 0..n {
        let (c, sign) = (center[i], 1.0_f64.copysign(beta[i]));
        let mut square = 0.0;
        for axis in 0..DIM {
            let back = sign * (c - before[axis][i]);
            let ahead = sign * (c - after[axis][i]);
            let slope = max(max(back, ahead), 0.0);
            square += slope * slope;
        }
        rate[i] = -beta[i] * max(square.sqrt() * per_h, floor);
    }
}

/// `rate -= v D phi` along one axis, D taken on the side that v comes from.
#[inline(always)]
pub(super) fn velocity(row: Row<'_>, axis: usize, v: &[f64], per_h: f64, rate: &mut [f64]) {
    let n = row.len();
    let (before, center, after) = (row.along(axis, -1), row.along(axis, 0), row.along(axis, 1));
    let (before, center, after) = (&before[..n], &center[..n], &after[..n]);
    let (v, rate) = (&v[..n], &mut rate[..n]);
    for i in 0..n {
        let forward = max(v[i], 0.0) * (center[i] - before[i]);
        let backward = max(-v[i], 0.0) * (center[i] - after[i]);
        rate[i] -= (forward + backward) * per_h;
    }
}
